#include "reduced/plane_ball.h"

#include <Eigen/Dense>
#include <cmath>

#include "foldproof/eigen.h"

namespace foldproof::internal {
namespace {

// The vertex of a set that lies lowest along a direction.
struct Lowest {
  double height = std::numeric_limits<double>::infinity();
  Index vertex = 0;
};

Lowest lowest_along(const CenterPose& pose, std::span<const Index> set, const Vec3& n) {
  Lowest lowest;
  for (const Index v : set) {
    const double height = n.dot(pose.at(v));
    if (height < lowest.height) lowest = {height, v};
  }
  return lowest;
}

Vec3 mean_of(const CenterPose& pose, std::span<const Index> set) {
  Vec3 sum = Vec3::Zero();
  for (const Index v : set) sum += pose.at(v);
  return sum / static_cast<double>(set.size());
}

Vec3 scaled(const ReducedMotion& motion, std::span<const float> row, Index k) {
  return Vec3(row[3 * k], row[3 * k + 1], row[3 * k + 2]) * motion.deviations()[k];
}

constexpr double kMaxRadius = 1e6;

// At this radius a turn costs more than it gains.
constexpr double kNoTurn = 1e3;
constexpr int kMaxFits = 4;

// The largest rho with a - b rho - c rho^2 >= 0. What is not a number has none.
double largest_rho(double a, double b, double c) {
  if (!(a > 0)) return 0;
  const double rho = 2 * a / (b + std::sqrt(b * b + 4 * a * c) + 1e-300);
  return rho > 0 ? std::min(kMaxRadius, rho) : 0;
}

}  // namespace

// Gilbert's search for the shortest vector between the hulls; keeps the direction with the widest gap.
bool PlaneBall::find_plane(const CenterPose& pose, const TwoSets& sets) {
  constexpr int kMaxRounds = 16;
  Vec3 n = to_eigen(sets.direction).isZero() ? mean_of(pose, sets.a) - mean_of(pose, sets.b) : sets.direction;
  double widest = 0;
  for (int round = 0; round < kMaxRounds && n.squaredNorm() > 0; ++round) {
    const Vec3 unit = n.normalized();
    const Lowest near_a = lowest_along(pose, sets.a, unit), near_b = lowest_along(pose, sets.b, -unit);
    const double gap = near_a.height + near_b.height;
    if (gap > widest) {
      widest = gap;
      normal_ = unit;
      origin_ = (pose.at(near_a.vertex) + pose.at(near_b.vertex)) / 2;
      origin_ += unit * ((near_a.height - near_b.height) / 2 - unit.dot(origin_));
    }
    const Vec3 step = pose.at(near_a.vertex) - pose.at(near_b.vertex) - n;
    const double descent = -n.dot(step);
    if (!(descent > 1e-3 * n.squaredNorm())) break;
    n += std::min(1.0, descent / step.squaredNorm()) * step;
  }
  return widest > 0;
}

// Each set counts half.
void PlaneBall::mean_motion(const ReducedMotion& motion, const TwoSets& sets) {
  mean_.assign(motion.modes(), Vec3::Zero());
  for (const auto set : {sets.a, sets.b}) {
    const double weight = 0.5 / static_cast<double>(set.size());
    for (const Index v : set) {
      const auto row = motion.row(v);
      for (Index k = 0; k < motion.modes(); ++k) mean_[k] += weight * scaled(motion, row, k);
    }
  }
}

// The rotation per mode that fits the motion of both sets, by least squares; each set counts half.
void PlaneBall::fit_rotation(const ReducedMotion& motion, const CenterPose& pose, const TwoSets& sets) {
  const Index modes = motion.modes();
  const Vec3 mean = (mean_of(pose, sets.a) + mean_of(pose, sets.b)) / 2;
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
  turn_.assign(modes, Vec3::Zero());
  for (const auto set : {sets.a, sets.b}) {
    const double weight = 0.5 / static_cast<double>(set.size());
    for (const Index v : set) {
      const Vec3 d = pose.at(v) - mean;
      const auto row = motion.row(v);
      const Eigen::Vector3d arm = to_eigen(d);
      inertia += weight * (arm.squaredNorm() * Eigen::Matrix3d::Identity() - arm * arm.transpose());
      for (Index k = 0; k < modes; ++k) turn_[k] += d.cross(weight * scaled(motion, row, k));
    }
  }
  inertia.diagonal().array() += 1e-9 * inertia.trace() + 1e-300;
  const Eigen::Matrix3d inverse = inertia.inverse();
  shift_ = mean_;
  for (Index k = 0; k < modes; ++k) {
    const Vec3 omega = to_vec3(inverse * to_eigen(turn_[k]));
    turn_[k] = omega.cross(normal_);
    shift_[k] += omega.cross(origin_ - mean);
    if (!turn_[k].allFinite() || !shift_[k].allFinite()) turn_[k] = shift_[k] = Vec3::Zero();
  }
}

// The turn and shift per mode that keep the distances of all vertices from the plane, as shares of
// themselves, by least squares. A turn is charged its effect of second order at the radius `rho`.
void PlaneBall::fit_distances(const ReducedMotion& motion, const CenterPose& pose, const TwoSets& sets,
                              double rho) {
  const Index modes = motion.modes();
  Eigen::Matrix4d normal_matrix = Eigen::Matrix4d::Zero();
  right_sides_.assign(modes, Eigen::Vector4d::Zero());
  double second_order = 0;
  for (const auto set : {sets.a, sets.b}) {
    for (const Index v : set) {
      const Vec3 d = pose.at(v) - origin_;
      const auto row = motion.row(v);
      const double height = normal_.dot(d), weight = 1 / (height * height);
      const Eigen::Vector4d coefficients(d.x(), d.y(), d.z(), -1);
      normal_matrix += weight * coefficients * coefficients.transpose();
      double size = 0;
      for (Index k = 0; k < modes; ++k) {
        const Vec3 offset = scaled(motion, row, k) - mean_[k];
        size += offset.squaredNorm();
        right_sides_[k] -= weight * normal_.dot(offset) * coefficients;
      }
      second_order += weight * size;
    }
  }
  normal_matrix.diagonal().head<3>().array() += rho * rho * second_order;
  normal_matrix.diagonal().array() *= 1 + 1e-9;
  const Eigen::Matrix4d inverse = normal_matrix.inverse();
  turn_.resize(modes);
  shift_.resize(modes);
  for (Index k = 0; k < modes; ++k) {
    const Eigen::Vector4d found = inverse * right_sides_[k];
    const bool finite = found.allFinite();
    turn_[k] = finite ? to_vec3(found.head<3>()) : Vec3::Zero();
    shift_[k] = mean_[k] + (finite ? found[3] : 0.0) * normal_;
  }
}

// The radius with the plane's present motion, or any number below `known` if it is not above that.
double PlaneBall::radius_of(const ReducedMotion& motion, const CenterPose& pose, const TwoSets& sets,
                            double gap, double known) {
  double turn = 0, largest_row = 0;
  for (const Vec3& t : turn_) turn += t.squaredNorm();
  turn = std::sqrt(turn) * (1 + kSumError);
  const double position_error = kSumError * pose.max_coordinate + 2 * pose.rounding;
  double radius = kMaxRadius;
  for (const double side : {1.0, -1.0}) {
    for (const Index v : side > 0 ? sets.a : sets.b) {
      const Vec3 d = pose.at(v) - origin_;
      const auto row = motion.row(v);
      double first_order = 0, size = 0, row_size = 0;
      for (Index k = 0; k < motion.modes(); ++k) {
        const Vec3 own = scaled(motion, row, k), offset = own - shift_[k];
        const double along = normal_.dot(offset) + turn_[k].dot(d);
        first_order += along * along;
        size += offset.squaredNorm();
        row_size += own.squaredNorm();
      }
      // The rounding of the sums, and half of the gap, which grows with the turning normal.
      largest_row = std::max(largest_row, row_size);
      const double error = kSumError * (std::sqrt(largest_row) + std::sqrt(size) + turn * d.norm());
      const double margin = side * normal_.dot(d) - gap / 2 * (1 + kSumError) - position_error;
      radius = std::min(
          radius, largest_rho(margin, std::sqrt(first_order) + error + (gap / 2 + position_error) * turn,
                              turn * std::sqrt(size) * (1 + kSumError)));
      if (!(radius > known)) return radius;
    }
  }
  return radius;
}

double PlaneBall::radius(const ReducedMotion& motion, const CenterPose& pose, const TwoSets& sets, double gap,
                         double max_radius) {
  if (!find_plane(pose, sets)) return 0;
  mean_motion(motion, sets);
  fit_rotation(motion, pose, sets);
  double best = radius_of(motion, pose, sets, gap, 0);
  const auto fit = [&](double rho) {
    fit_distances(motion, pose, sets, rho);
    const double found = radius_of(motion, pose, sets, gap, best);
    const bool grew = found > 1.05 * best;
    best = std::max(best, found);
    return grew;
  };
  if (best < max_radius) fit(kNoTurn);
  if (best < max_radius) fit(1);
  // What a turn costs depends on the radius, which depends on the turn.
  for (int round = 0; round < kMaxFits && best < max_radius && fit(1.5 * best); ++round) {
  }
  return best * (1 - kRadiusMargin);
}

}  // namespace foldproof::internal
