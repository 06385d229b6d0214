#include "reduced/chart_ball.h"

#include <Eigen/Dense>
#include <cmath>
#include <numbers>

namespace foldproof {
namespace {

// Bounds that the margin counts on (R5), the same as for charts of whole steps.
constexpr double kLeastAltitude = 4;

constexpr int kDirections = 64;
using DirectionTable = std::array<Eigen::Vector2d, kDirections>;

DirectionTable make_directions() {
  DirectionTable table;
  for (int i = 0; i < kDirections; ++i) {
    const double angle = 2 * std::numbers::pi * i / kDirections;
    table[i] = {std::cos(angle), std::sin(angle)};
  }
  return table;
}

// Gram matrix of (h, u1, u2), and the largest square of |h - w . u| over unit vectors w, from above (R1).
struct Gram {
  double hh, hx, hy, xx, xy, yy;

  double quick_bound() const {
    const double middle = (xx + yy) / 2, swing = std::hypot((xx - yy) / 2, xy);
    return hh + 2 * std::hypot(hx, hy) + middle + swing;
  }
  double bound() const {
    static const DirectionTable directions = make_directions();
    double most = 0;
    for (const Eigen::Vector2d& w : directions) {
      const double x = w.x(), y = w.y();
      most = std::max(most, hh - 2 * (x * hx + y * hy) + x * x * xx + 2 * x * y * xy + y * y * yy);
    }
    // Between two directions: the second derivative of a trigonometric polynomial is below this.
    constexpr double kStep = 2 * std::numbers::pi / kDirections;
    const double bend = 2 * std::hypot(hx, hy) + 4 * std::hypot((xx - yy) / 2, xy);
    return std::min(quick_bound(), most + kStep * kStep / 8 * bend);
  }
};

}  // namespace

struct ChartBall::Corners {
  std::uint32_t v[3];
};

// S2 with the heights left out: the pose is the one that the chart was drawn in, so that W^T x are the
// places again, but for their rounding. Any W is valid.
bool ChartBall::pull_back(const CentrePose& pose, const Patch& patch, const Eigen::Vector3f& facing) {
  const Vec3 normal = facing.cast<double>().normalized();
  const Vec3 along = normal.unitOrthogonal(), across = normal.cross(along);
  const auto count = static_cast<double>(patch.vertices.size());
  const Vec3 first = pose.at(patch.vertices[0]);
  Eigen::Vector2d mean_x = Eigen::Vector2d::Zero(), mean_y = mean_x;
  Eigen::Matrix2d xx = Eigen::Matrix2d::Zero(), yx = xx;
  for (std::size_t i = 0; i < patch.vertices.size(); ++i) {
    const Vec3 d = pose.at(patch.vertices[i]) - first;
    const Eigen::Vector2d x(d.dot(along), d.dot(across));
    mean_x += x / count;
    mean_y += places_[i] / count;
    xx += x * x.transpose();
    yx += places_[i] * x.transpose();
  }
  xx -= count * mean_x * mean_x.transpose();
  yx -= count * mean_y * mean_x.transpose();
  if (!(xx.determinant() > 0)) return false;
  const Eigen::Matrix2d fit = yx * xx.inverse();
  w_.row(0) = fit(0, 0) * along + fit(0, 1) * across;
  w_.row(1) = fit(1, 0) * along + fit(1, 1) * across;
  w_norm_ = w_.norm();
  w_sum_ = w_.cwiseAbs().rowwise().sum().maxCoeff();
  return std::isfinite(w_norm_);
}

void ChartBall::draw(const ReducedMotion& motion, const CentrePose& pose, const Patch& patch,
                     const Drawing& drawing) {
  const std::size_t count = patch.vertices.size(), all = count + kChartCorners.size();
  drawn_.resize(all);
  moved_.resize(all * 2 * modes_);
  const Vec3 first = pose.at(patch.vertices[0]);
  const auto first_row = motion.row(patch.vertices[0]);
  const auto deviations = motion.deviations();
  double reach = 0, moving_reach = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 offset = pose.at(patch.vertices[i]) - first;
    reach = std::max(reach, offset.cwiseAbs().maxCoeff());
    drawn_[i] = w_ * offset;
    const auto row = motion.row(patch.vertices[i]);
    double* to = &moved_[i * 2 * modes_];
    for (Index k = 0; k < modes_; ++k) {
      Vec3 d;
      for (int axis = 0; axis < 3; ++axis)
        d[axis] = (double{row[3 * k + axis]} - double{first_row[3 * k + axis]}) * deviations[k];
      moving_reach = std::max(moving_reach, d.cwiseAbs().maxCoeff());
      to[k] = w_.row(0).dot(d);
      to[modes_ + k] = w_.row(1).dot(d);
    }
  }
  draw_corners(drawing);
  double drawn_reach = 0, moved_reach = 0;
  for (const Eigen::Vector2d& d : drawn_) drawn_reach = std::max(drawn_reach, d.cwiseAbs().maxCoeff());
  for (const double m : moved_) moved_reach = std::max(moved_reach, std::abs(m));
  // R5: offsets and W times them, then differences and their products with the sides.
  still_error_ = w_sum_ * (0x1p-50 * (reach + pose.largest) + 2 * pose.rounding) + 0x1p-49 * drawn_reach;
  moving_error_ = w_sum_ * 0x1p-50 * moving_reach + 0x1p-49 * moved_reach;
}

// The square's corners have no substance: they move as the patch does on the whole, by least squares.
void ChartBall::draw_corners(const Drawing& drawing) {
  const std::size_t count = drawing.places.size();
  Eigen::Vector2d mean = Eigen::Vector2d::Zero(), shift = mean;
  for (std::size_t i = 0; i < count; ++i) {
    mean += places_[i] / static_cast<double>(count);
    shift += (drawn_[i] - places_[i]) / static_cast<double>(count);
  }
  Eigen::Matrix2d second = Eigen::Matrix2d::Zero();
  for (std::size_t i = 0; i < count; ++i) second += (places_[i] - mean) * (places_[i] - mean).transpose();
  const Eigen::Matrix2d inverse = second.inverse();
  Eigen::ArrayXd middle = Eigen::ArrayXd::Zero(2 * modes_), by_x = middle, by_y = middle;
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::Map<const Eigen::ArrayXd> moved(&moved_[i * 2 * modes_], 2 * modes_);
    const Eigen::Vector2d weight = inverse * (places_[i] - mean);
    middle += moved / static_cast<double>(count);
    by_x += moved * weight.x();
    by_y += moved * weight.y();
  }
  for (std::size_t i = count; i < places_.size(); ++i) {
    drawn_[i] = places_[i] + shift;
    Eigen::Map<Eigen::ArrayXd> moved(&moved_[i * 2 * modes_], 2 * modes_);
    moved = middle + by_x * (places_[i].x() - mean.x()) + by_y * (places_[i].y() - mean.y());
  }
}

double ChartBall::least_altitude(const Patch& patch, const Drawing& drawing) const {
  double least = kChartCorners[0][0];
  for (const auto* group : {&patch.triangles, &drawing.fillers}) {
    for (const auto& t : *group) {
      const Eigen::Vector2d a = places_[t[1]] - places_[t[0]], b = places_[t[2]] - places_[t[0]];
      const double longest = std::max({a.squaredNorm(), b.squaredNorm(), (a - b).squaredNorm()});
      least = std::min(least, (a.x() * b.y() - a.y() * b.x()) / std::sqrt(longest));
    }
  }
  return least * (1 - 0x1p-40);
}

// The radius of one triangle (R1), or `best` when it is not below.
double ChartBall::radius_of(const Corners& corners, double slack, double error, double best) {
  const auto [v0, v1, v2] = corners.v;
  const Eigen::Vector2d e1 = places_[v1] - places_[v0], e2 = places_[v2] - places_[v0];
  const double det = e1.x() * e2.y() - e1.y() * e2.x();
  const Eigen::Vector2d g1 = drawn_[v1] - drawn_[v0], g2 = drawn_[v2] - drawn_[v0];
  const Eigen::Vector2d to_x = (g1 * e2.y() - g2 * e1.y()) / det, to_y = (g2 * e1.x() - g1 * e2.x()) / det;
  const double mean = (to_x.x() + to_y.y()) / 2;
  const double uneven = std::hypot((to_x.x() - to_y.y()) / 2, (to_x.y() + to_y.x()) / 2);
  const double above = mean - uneven - slack;
  if (!(above > 0)) return 0;
  const auto moved = [&](std::uint32_t v, int row) {
    return Eigen::Map<const Eigen::ArrayXd>(&moved_[(std::size_t{v} * 2 + row) * modes_], modes_);
  };
  const double half = 0.5 / det;
  const double x1 = e1.x() * half, y1 = e1.y() * half, x2 = e2.x() * half, y2 = e2.y() * half;
  // Twice half the entries: a = (m1x y2 - m2x y1), d = (m2y x1 - m1y x2), b = (m2x x1 - m1x x2), c.
  h_ = (moved(v1, 0) - moved(v0, 0)) * y2 - (moved(v2, 0) - moved(v0, 0)) * y1;
  u2_ = (moved(v2, 1) - moved(v0, 1)) * x1 - (moved(v1, 1) - moved(v0, 1)) * x2;
  u1_ = h_ - u2_;
  h_ += u2_;
  u2_ = (moved(v2, 0) - moved(v0, 0)) * x1 - (moved(v1, 0) - moved(v0, 0)) * x2 +
        (moved(v1, 1) - moved(v0, 1)) * y2 - (moved(v2, 1) - moved(v0, 1)) * y1;
  const auto dot = [](const Eigen::ArrayXd& a, const Eigen::ArrayXd& b) {
    return a.matrix().dot(b.matrix());
  };
  const Gram gram{dot(h_, h_), dot(h_, u1_), dot(h_, u2_), dot(u1_, u1_), dot(u1_, u2_), dot(u2_, u2_)};
  const auto radius = [&](double square) { return above / (std::sqrt(square) * (1 + kSumError) + error); };
  return radius(gram.quick_bound()) >= best ? best : std::min(best, radius(gram.bound()));
}

double ChartBall::radius(const ReducedMotion& motion, const CentrePose& pose, const Patch& patch,
                         const Drawing& drawing, const Eigen::Vector3f& facing, double gap) {
  modes_ = motion.modes();
  places_.clear();
  for (const Place p : drawing.places) places_.emplace_back(p[0], p[1]);
  for (const Place p : kChartCorners) places_.emplace_back(p[0], p[1]);
  const double altitude = least_altitude(patch, drawing);
  if (!(altitude >= kLeastAltitude) || !pull_back(pose, patch, facing)) return 0;
  draw(motion, pose, patch, drawing);
  const double slack = gap * w_norm_ / altitude * (1 + kSumError) + 8 * still_error_ / altitude + kSumError;
  const double error = 8 * std::sqrt(static_cast<double>(modes_)) * moving_error_ / altitude;
  double best = 1e6;
  for (const auto* group : {&patch.triangles, &drawing.fillers}) {
    for (const auto& t : *group) {
      best = radius_of({{t[0], t[1], t[2]}}, slack, error, best);
      if (best == 0) return 0;
    }
  }
  return best * (1 - kRadiusMargin);
}

}  // namespace foldproof
