#include "reduced/chart_ball.h"

#include <Eigen/Dense>
#include <cmath>
#include <numbers>

#include "foldproof/eigen.h"

namespace foldproof::internal {
namespace {

// The rounding bounds assume this (R5), as for charts of whole steps.
constexpr double kMinAltitude = 4;

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

// Gram matrix of (h, u1, u2), and upper bounds of the largest square of |h - w . u| over unit vectors w (R1).
struct Gram {
  double hh, hx, hy, xx, xy, yy;

  double quick_bound() const {
    const double mean = (xx + yy) / 2, amplitude = std::hypot((xx - yy) / 2, xy);
    return hh + 2 * std::hypot(hx, hy) + mean + amplitude;
  }
  double bound() const {
    static const DirectionTable directions = make_directions();
    double largest = 0;
    for (const Eigen::Vector2d& w : directions) {
      const double x = w.x(), y = w.y();
      largest = std::max(largest, hh - 2 * (x * hx + y * hy) + x * x * xx + 2 * x * y * xy + y * y * yy);
    }
    // Between two directions: a bound of the second derivative of this trigonometric polynomial.
    constexpr double kStep = 2 * std::numbers::pi / kDirections;
    const double curvature = 2 * std::hypot(hx, hy) + 4 * std::hypot((xx - yy) / 2, xy);
    return std::min(quick_bound(), largest + kStep * kStep / 8 * curvature);
  }
};

}  // namespace

// S2 without heights: the chart was built in this pose, so W^T x are its uvs again, but for their rounding.
// Any W is valid.
bool ChartBall::pull_back(const CenterPose& pose, const Patch& patch, const Eigen::Vector3f& facing) {
  const Eigen::Vector3d normal = facing.cast<double>().normalized();
  const Eigen::Vector3d along = normal.unitOrthogonal(), across = normal.cross(along);
  const auto count = static_cast<double>(patch.vertices.size());
  const Vec3 first = pose.at(patch.vertices[0]);
  Eigen::Vector2d mean_x = Eigen::Vector2d::Zero(), mean_y = mean_x;
  Eigen::Matrix2d xx = Eigen::Matrix2d::Zero(), yx = xx;
  for (std::size_t i = 0; i < patch.vertices.size(); ++i) {
    const Eigen::Vector3d d = to_eigen(pose.at(patch.vertices[i]) - first);
    const Eigen::Vector2d x(d.dot(along), d.dot(across));
    mean_x += x / count;
    mean_y += uvs_[i] / count;
    xx += x * x.transpose();
    yx += uvs_[i] * x.transpose();
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

void ChartBall::map_vertices(const ReducedMotion& motion, const CenterPose& pose, const Patch& patch,
                             const UvMap& uv_map) {
  const std::size_t count = patch.vertices.size(), all = count + kChartCorners.size();
  mapped_.resize(all);
  moved_.resize(all * 2 * modes_);
  const Vec3 first = pose.at(patch.vertices[0]);
  const auto first_row = motion.row(patch.vertices[0]);
  const auto deviations = motion.deviations();
  double extent = 0, moving_extent = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::Vector3d offset = to_eigen(pose.at(patch.vertices[i]) - first);
    extent = std::max(extent, offset.cwiseAbs().maxCoeff());
    mapped_[i] = w_ * offset;
    const auto row = motion.row(patch.vertices[i]);
    double* to = &moved_[i * 2 * modes_];
    for (Index k = 0; k < modes_; ++k) {
      Eigen::Vector3d d;
      for (int axis = 0; axis < 3; ++axis)
        d[axis] = (double{row[3 * k + axis]} - double{first_row[3 * k + axis]}) * deviations[k];
      moving_extent = std::max(moving_extent, d.cwiseAbs().maxCoeff());
      to[k] = w_.row(0).dot(d);
      to[modes_ + k] = w_.row(1).dot(d);
    }
  }
  map_corners(uv_map);
  double mapped_extent = 0, moved_extent = 0;
  for (const Eigen::Vector2d& d : mapped_) mapped_extent = std::max(mapped_extent, d.cwiseAbs().maxCoeff());
  for (const double m : moved_) moved_extent = std::max(moved_extent, std::abs(m));
  // R5: offsets and W times them, then differences and their products with the edges.
  mapped_error_ =
      w_sum_ * (0x1p-50 * (extent + pose.max_coordinate) + 2 * pose.rounding) + 0x1p-49 * mapped_extent;
  moved_error_ = w_sum_ * 0x1p-50 * moving_extent + 0x1p-49 * moved_extent;
}

// The square's corners may move in any way. They follow the patch as a whole, by least squares.
void ChartBall::map_corners(const UvMap& uv_map) {
  const std::size_t count = uv_map.uvs.size();
  Eigen::Vector2d mean = Eigen::Vector2d::Zero(), shift = mean;
  for (std::size_t i = 0; i < count; ++i) {
    mean += uvs_[i] / static_cast<double>(count);
    shift += (mapped_[i] - uvs_[i]) / static_cast<double>(count);
  }
  Eigen::Matrix2d second = Eigen::Matrix2d::Zero();
  for (std::size_t i = 0; i < count; ++i) second += (uvs_[i] - mean) * (uvs_[i] - mean).transpose();
  const Eigen::Matrix2d inverse = second.inverse();
  Eigen::ArrayXd mean_moved = Eigen::ArrayXd::Zero(2 * modes_), by_x = mean_moved, by_y = mean_moved;
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::Map<const Eigen::ArrayXd> moved(&moved_[i * 2 * modes_], 2 * modes_);
    const Eigen::Vector2d weight = inverse * (uvs_[i] - mean);
    mean_moved += moved / static_cast<double>(count);
    by_x += moved * weight.x();
    by_y += moved * weight.y();
  }
  for (std::size_t i = count; i < uvs_.size(); ++i) {
    mapped_[i] = uvs_[i] + shift;
    Eigen::Map<Eigen::ArrayXd> moved(&moved_[i * 2 * modes_], 2 * modes_);
    moved = mean_moved + by_x * (uvs_[i].x() - mean.x()) + by_y * (uvs_[i].y() - mean.y());
  }
}

double ChartBall::min_altitude(const Patch& patch, const UvMap& uv_map) const {
  double smallest = kChartCorners[0][0];
  for (const auto* group : {&patch.triangles, &uv_map.scaffold}) {
    for (const auto& t : *group) {
      const Eigen::Vector2d a = uvs_[t[1]] - uvs_[t[0]], b = uvs_[t[2]] - uvs_[t[0]];
      const double longest = std::max({a.squaredNorm(), b.squaredNorm(), (a - b).squaredNorm()});
      smallest = std::min(smallest, (a.x() * b.y() - a.y() * b.x()) / std::sqrt(longest));
    }
  }
  return smallest * (1 - 0x1p-40);
}

// The radius of one triangle (R1), or `best` when it is not below.
double ChartBall::triangle_radius(const std::array<std::uint16_t, 3>& triangle, double lambda, double error,
                                  double best) {
  const auto [v0, v1, v2] = triangle;
  const Eigen::Vector2d e1 = uvs_[v1] - uvs_[v0], e2 = uvs_[v2] - uvs_[v0];
  const double det = e1.x() * e2.y() - e1.y() * e2.x();
  const Eigen::Vector2d g1 = mapped_[v1] - mapped_[v0], g2 = mapped_[v2] - mapped_[v0];
  const Eigen::Vector2d to_x = (g1 * e2.y() - g2 * e1.y()) / det, to_y = (g2 * e1.x() - g1 * e2.x()) / det;
  const double mean = (to_x.x() + to_y.y()) / 2;
  const double difference = std::hypot((to_x.x() - to_y.y()) / 2, (to_x.y() + to_y.x()) / 2);
  const double margin = mean - difference - lambda;
  if (!(margin > 0)) return 0;
  const auto moved = [&](std::size_t v, int row) {
    return Eigen::Map<const Eigen::ArrayXd>(&moved_[(v * 2 + row) * modes_], modes_);
  };
  const double half = 0.5 / det;
  const double x1 = e1.x() * half, y1 = e1.y() * half, x2 = e2.x() * half, y2 = e2.y() * half;
  // h = (a + d) / 2, u1 = (a - d) / 2 and u2 = (b + c) / 2, with a = m1x y2 - m2x y1, d = m2y x1 - m1y x2,
  // b = m2x x1 - m1x x2 and c = m1y y2 - m2y y1.
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
  const auto radius = [&](double square) { return margin / (std::sqrt(square) * (1 + kSumError) + error); };
  if (radius(gram.quick_bound()) >= best) return best;
  const double found = radius(gram.bound());
  return found > 0 ? std::min(best, found) : 0;  // 0 also for what is not a number
}

double ChartBall::radius(const ReducedMotion& motion, const CenterPose& pose, const Patch& patch,
                         const UvMap& uv_map, const Eigen::Vector3f& facing, double gap) {
  modes_ = motion.modes();
  uvs_.clear();
  for (const Uv p : uv_map.uvs) uvs_.emplace_back(p[0], p[1]);
  for (const Uv p : kChartCorners) uvs_.emplace_back(p[0], p[1]);
  const double altitude = min_altitude(patch, uv_map);
  if (!(altitude >= kMinAltitude) || !pull_back(pose, patch, facing)) return 0;
  map_vertices(motion, pose, patch, uv_map);
  const double lambda = gap * w_norm_ / altitude * (1 + kSumError) + 8 * mapped_error_ / altitude + kSumError;
  const double error = 8 * std::sqrt(static_cast<double>(modes_)) * moved_error_ / altitude;
  double best = 1e6;
  for (const auto* group : {&patch.triangles, &uv_map.scaffold}) {
    for (const auto& t : *group) {
      best = triangle_radius(t, lambda, error, best);
      if (best == 0) return 0;
    }
  }
  return best * (1 - kRadiusMargin);
}

}  // namespace foldproof::internal
