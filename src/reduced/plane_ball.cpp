#include "reduced/plane_ball.h"

#include <Eigen/Dense>
#include <cmath>

namespace foldproof {
namespace {

struct Least {
  double along = std::numeric_limits<double>::infinity();
  Index at = 0;
};

Least least_along(const CentrePose& pose, std::span<const Index> set, const Vec3& n) {
  Least least;
  for (const Index v : set) {
    const double along = n.dot(pose.at(v));
    if (along < least.along) least = {along, v};
  }
  return least;
}

Vec3 mean_of(const CentrePose& pose, std::span<const Index> set) {
  Vec3 sum = Vec3::Zero();
  for (const Index v : set) sum += pose.at(v);
  return sum / static_cast<double>(set.size());
}

Vec3 scaled(const ReducedMotion& motion, std::span<const float> row, Index k) {
  return Vec3(row[3 * k], row[3 * k + 1], row[3 * k + 2]) * motion.deviations()[k];
}

// Largest radius with a - b rho - c rho^2 >= 0.
double reach_of(double a, double b, double c) {
  return a > 0 ? std::min(1e6, 2 * a / (b + std::sqrt(b * b + 4 * a * c) + 1e-300)) : 0;
}

}  // namespace

// Gilbert's search for the shortest difference of both sets; keeps the direction of the widest gap.
bool PlaneBall::find_plane(const CentrePose& pose, std::span<const Index> a, std::span<const Index> b) {
  constexpr int kMostRounds = 16;
  Vec3 n = mean_of(pose, a) - mean_of(pose, b);
  double widest = 0;
  for (int round = 0; round < kMostRounds && n.squaredNorm() > 0; ++round) {
    const Vec3 unit = n.normalized();
    const Least near_a = least_along(pose, a, unit), near_b = least_along(pose, b, -unit);
    const double gap = near_a.along + near_b.along;
    if (gap > widest) {
      widest = gap;
      normal_ = unit;
      origin_ = (pose.at(near_a.at) + pose.at(near_b.at)) / 2;
      origin_ += unit * ((near_a.along - near_b.along) / 2 - unit.dot(origin_));
    }
    const Vec3 way = pose.at(near_a.at) - pose.at(near_b.at) - n;
    const double towards = -n.dot(way);
    if (!(towards > 1e-3 * n.squaredNorm())) break;
    n += std::min(1.0, towards / way.squaredNorm()) * way;
  }
  return widest > 0;
}

// The rotation per mode that takes part in the motion of both sets, by least squares; each set counts half.
void PlaneBall::fit_rotation(const ReducedMotion& motion, const CentrePose& pose, std::span<const Index> a,
                             std::span<const Index> b) {
  const Index modes = motion.modes();
  Vec3 mean = (mean_of(pose, a) + mean_of(pose, b)) / 2;
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
  std::vector<Vec3> moment(modes, Vec3::Zero());
  shift_.assign(modes, Vec3::Zero());
  for (const auto set : {a, b}) {
    const double weight = 0.5 / static_cast<double>(set.size());
    for (const Index v : set) {
      const Vec3 d = pose.at(v) - mean;
      const auto row = motion.row(v);
      inertia += weight * (d.squaredNorm() * Eigen::Matrix3d::Identity() - d * d.transpose());
      for (Index k = 0; k < modes; ++k) {
        const Vec3 s = weight * scaled(motion, row, k);
        shift_[k] += s;
        moment[k] += d.cross(s);
      }
    }
  }
  inertia.diagonal().array() += 1e-9 * inertia.trace() + 1e-300;
  const Eigen::Matrix3d inverse = inertia.inverse();
  turn_.resize(modes);
  for (Index k = 0; k < modes; ++k) {
    const Vec3 omega = inverse * moment[k];
    turn_[k] = omega.cross(normal_);
    shift_[k] += omega.cross(origin_ - mean);
    if (!turn_[k].allFinite() || !shift_[k].allFinite()) turn_[k] = shift_[k] = Vec3::Zero();
  }
}

double PlaneBall::radius(const ReducedMotion& motion, const CentrePose& pose, std::span<const Index> a,
                         std::span<const Index> b, double gap) {
  if (!find_plane(pose, a, b)) return 0;
  fit_rotation(motion, pose, a, b);
  double turn = 0, largest_row = 0;
  for (const Vec3& t : turn_) turn += t.squaredNorm();
  turn = std::sqrt(turn) * (1 + kSumError);
  const double still_error = kSumError * pose.largest + 2 * pose.rounding;
  double turning = 1e6, straight = 1e6;
  for (const double side : {1.0, -1.0}) {
    for (const Index v : side > 0 ? a : b) {
      const Vec3 d = pose.at(v) - origin_;
      const auto row = motion.row(v);
      double both = 0, plain = 0, size = 0, row_size = 0;
      for (Index k = 0; k < motion.modes(); ++k) {
        const Vec3 own = scaled(motion, row, k), offset = own - shift_[k];
        const double along = normal_.dot(offset), with_turn = along + turn_[k].dot(d);
        both += with_turn * with_turn;
        plain += along * along;
        size += offset.squaredNorm();
        row_size += own.squaredNorm();
      }
      // What the sums may be off by, and half of the gap, which grows with the turning normal.
      largest_row = std::max(largest_row, row_size);
      const double error = kSumError * (std::sqrt(largest_row) + std::sqrt(size) + turn * d.norm());
      const double above = side * normal_.dot(d) - gap / 2 * (1 + kSumError) - still_error;
      turning = std::min(turning, reach_of(above, std::sqrt(both) + error + (gap / 2 + still_error) * turn,
                                           turn * std::sqrt(size) * (1 + kSumError)));
      straight = std::min(straight, reach_of(above, std::sqrt(plain) + error, 0));
      if (turning == 0) return 0;
    }
  }
  return std::max(turning, straight) * (1 - kRadiusMargin);
}

}  // namespace foldproof
