/// How the nodes of a hierarchy move as a whole: a point that is linear in p, and bounds of the distances of
/// the node's vertices from it.
#pragma once

#include "reduced/pose.h"

namespace foldproof::inline internal {

/// All vertices of a node's triangles, in `out`, each once, as indices in leaf order: first those that other
/// nodes own, then the run that this node owns.
void node_vertices(const ReducedMotion& motion, const Hierarchy::Node& node, std::vector<Index>& out);

/// For every node a point o(p) = mean + basis p, and bounds that hold at every p (R2). With q = p - center,
/// |x_v - o| <= extent + |q| growth along an axis, and |x_v - o|^2 <= radius^2 + 2 |q| cross + |q|^2
/// spread^2.
struct NodeMotions {
  struct Point {
    std::array<double, 3> mean;
    std::array<float, 3> growth;  ///< Per axis.
    float spread;
  };
  /// The bounds that depend on the center.
  struct AtCenter {
    std::array<float, 3> extent;
    float radius, cross;
  };
  Index modes = 0;
  std::vector<Point> points;
  std::vector<float> basis;                      ///< [node][mode][axis]
  std::vector<std::vector<AtCenter>> at_center;  ///< [center][node]

  NodeMotions(const ReducedMotion& motion, std::span<const CenterPose> poses);

  std::span<const float> row(Index node) const {
    return std::span(basis).subspan(std::size_t{node} * modes * 3, std::size_t{modes} * 3);
  }
  /// A node's point at p; the same sum as ReducedMotion::vertex.
  Vec3 at(Index node, std::span<const double> p) const;

 private:
  void find_points(const ReducedMotion& motion);
  void measure(const ReducedMotion& motion, std::span<const CenterPose> poses, Index node,
               std::vector<Index>& scratch);
};

/// A radius around a center within which the bounding spheres of two nodes stay farther apart than `gap`
/// (R2), at most `max_radius`. 0: none. `p`: of the center. `deviations`: of the motion.
double radius_by_spheres(const NodeMotions& nodes, Index a, Index b, Index center, std::span<const double> p,
                         std::span<const double> deviations, double gap, double max_radius);

}  // namespace foldproof::internal
