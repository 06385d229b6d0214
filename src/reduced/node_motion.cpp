#include "reduced/node_motion.h"

#include <algorithm>
#include <cmath>

#include "base/parallel.h"

namespace foldproof {

void internal::node_vertices(const ReducedMotion& motion, const Hierarchy::Node& node,
                             std::vector<Index>& out) {
  const auto leaves = motion.hierarchy()->leaves();
  const Index begin = leaves[node.leaf_begin].vertices, end = leaves[node.leaf_end].vertices;
  out.clear();
  for (Index leaf = node.leaf_begin; leaf < node.leaf_end; ++leaf) {
    for (const Index v : motion.leaf_vertices(leaf)) {
      if (v >= begin) break;  // they ascend; this node owns the rest
      out.push_back(v);
    }
  }
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
  for (Index v = begin; v < end; ++v) out.push_back(v);
}

NodeMotions::NodeMotions(const ReducedMotion& motion, std::span<const CenterPose> poses)
    : modes(motion.modes()), at_center(poses.size()) {
  const std::size_t count = motion.hierarchy()->nodes().size();
  points.resize(count);
  basis.resize(count * modes * 3);
  for (auto& of_center : at_center) of_center.resize(count);
  find_points(motion);
  PerThread<std::vector<Index>> scratch;
  parallel_for(std::size_t{0}, count,
               [&](std::size_t node) { measure(motion, poses, static_cast<Index>(node), scratch.local()); });
}

// The mean of the leaves' vertices; one that several leaves use counts for each. Any point would do.
void NodeMotions::find_points(const ReducedMotion& motion) {
  const Hierarchy& h = *motion.hierarchy();
  const auto nodes = h.nodes();
  const std::size_t width = 3 * (std::size_t{modes} + 1);
  std::vector<double> sums(nodes.size() * width, 0);
  std::vector<double> counts(nodes.size(), 0);
  const std::vector<double> zero(modes, 0);
  for (std::size_t i = nodes.size(); i-- > 0;) {
    double* sum = &sums[i * width];
    if (nodes[i].is_leaf()) {
      for (const Index v : motion.leaf_vertices(nodes[i].leaf_begin)) {
        double x[3];
        motion.vertex(v, zero, x);
        const auto row = motion.row(v);
        for (int axis = 0; axis < 3; ++axis) sum[axis] += x[axis];
        for (std::size_t k = 0; k < row.size(); ++k) sum[3 + k] += double{row[k]};
        ++counts[i];
      }
    } else {
      for (const std::size_t child : {i + 1, std::size_t{nodes[i].right}}) {
        for (std::size_t k = 0; k < width; ++k) sum[k] += sums[child * width + k];
        counts[i] += counts[child];
      }
    }
    for (int axis = 0; axis < 3; ++axis) points[i].mean[axis] = sum[axis] / counts[i];
    for (std::size_t k = 0; k < 3 * std::size_t{modes}; ++k)
      basis[i * 3 * modes + k] = static_cast<float>(sum[3 + k] / counts[i]);
  }
}

Vec3 NodeMotions::at(Index node, std::span<const double> p) const {
  const auto own = row(node);
  Vec3 x(points[node].mean[0], points[node].mean[1], points[node].mean[2]);
  for (Index k = 0; k < modes; ++k) {
    for (int axis = 0; axis < 3; ++axis) x[axis] += double{own[3 * k + axis]} * p[k];
  }
  return x;
}

void NodeMotions::measure(const ReducedMotion& motion, std::span<const CenterPose> poses, Index node,
                          std::vector<Index>& scratch) {
  node_vertices(motion, motion.hierarchy()->nodes()[node], scratch);
  const auto own = row(node);
  const auto deviations = motion.deviations();
  std::vector<Vec3> point_at;  // per center
  for (const CenterPose& pose : poses) point_at.push_back(at(node, pose.p));
  Vec3 growth = Vec3::Zero();
  double spread = 0;
  std::vector<double> radius(poses.size(), 0), cross(poses.size(), 0);
  std::vector<Vec3> extent(poses.size(), Vec3::Zero());
  std::vector<Vec3> offset(modes);
  for (const Index v : scratch) {
    const auto theirs = motion.row(v);
    Vec3 squares = Vec3::Zero();
    for (Index k = 0; k < modes; ++k) {
      for (int axis = 0; axis < 3; ++axis)
        offset[k][axis] = (double{theirs[3 * k + axis]} - double{own[3 * k + axis]}) * deviations[k];
      squares += offset[k].cwiseProduct(offset[k]);
    }
    growth = growth.cwiseMax(squares);
    spread = std::max(spread, squares[0] + squares[1] + squares[2]);
    for (std::size_t c = 0; c < poses.size(); ++c) {
      const Vec3 d = poses[c].at(v) - point_at[c];
      extent[c] = extent[c].cwiseMax(d.cwiseAbs());
      radius[c] = std::max(radius[c], d.squaredNorm());
      double square = 0;
      for (const Vec3& o : offset) square += o.dot(d) * o.dot(d);
      cross[c] = std::max(cross[c], square);
    }
  }
  Point& point = points[node];
  for (int axis = 0; axis < 3; ++axis)
    point.growth[axis] = round_up(std::sqrt(growth[axis]) * (1 + kSumError));
  point.spread = round_up(std::sqrt(spread) * (1 + kSumError));
  for (std::size_t c = 0; c < poses.size(); ++c) {
    const double rounding = 4 * poses[c].rounding;  // of the vertex and of the point
    AtCenter& out = at_center[c][node];
    for (int axis = 0; axis < 3; ++axis) out.extent[axis] = round_up(extent[c][axis] + rounding);
    out.radius = round_up(std::sqrt(radius[c]) * (1 + kSumError) + rounding);
    out.cross = round_up((std::sqrt(cross[c]) + rounding * point.spread) * (1 + kSumError));
  }
}

double internal::radius_by_spheres(const NodeMotions& nodes, Index a, Index b, Index center,
                                   std::span<const double> p, std::span<const double> deviations, double gap,
                                   double max_radius) {
  const Vec3 between = nodes.at(a, p) - nodes.at(b, p);
  const auto row_a = nodes.row(a), row_b = nodes.row(b);
  double approach = 0, size = 0;
  for (Index k = 0; k < nodes.modes; ++k) {
    Vec3 d;
    for (int axis = 0; axis < 3; ++axis)
      d[axis] = (double{row_a[3 * k + axis]} - double{row_b[3 * k + axis]}) * deviations[k];
    approach += d.dot(between) * d.dot(between);
    size += d.squaredNorm();
  }
  const double distance = between.norm();
  approach = std::sqrt(approach) + kSumError * distance * std::sqrt(size);
  const auto separated = [&](double rho) {
    const auto sphere_radius = [&](Index node) {
      const NodeMotions::AtCenter& bounds = nodes.at_center[center][node];
      const double spread = double{nodes.points[node].spread} * rho;
      return std::sqrt(double{bounds.radius} * bounds.radius + 2 * rho * bounds.cross + spread * spread);
    };
    // |between(q)|^2 >= |between|^2 - 2 rho |Sigma D^T between|.
    const double square = distance * distance - 2 * rho * approach;
    const double sum = sphere_radius(a) + sphere_radius(b) + gap;
    return square > 0 && std::sqrt(square) > sum * (1 + kSumError) + distance * kSumError;
  };
  if (!separated(0)) return 0;
  double low = 0, high = max_radius;
  if (separated(high)) return high;
  for (int round = 0; round < 24; ++round) {
    const double middle = (low + high) / 2;
    (separated(middle) ? low : high) = middle;
  }
  return low * (1 - kRadiusMargin);
}

}  // namespace foldproof
