/// How the nodes of a hierarchy move as a whole: a point that moves linearly with p, and how far vertices are
/// from it.
#pragma once

#include "reduced/pose.h"

namespace foldproof {

/// The vertices of a node, places in leaf order: those that it owns follow each other; `out` gets them and
/// those of its triangles that others own, each once.
void node_vertices(const ReducedMotion& motion, const Hierarchy::Node& node, std::vector<Index>& out);

/// For every node a point o(p) = mean + basis p, and bounds that hold at every p, q = p - centre:
/// |x_v - o| along an axis <= extent + |q| grow; |x_v - o|^2 <= radius^2 + 2 |q| turn + |q|^2 spread^2 (R2).
struct NodeMotions {
  struct Point {
    std::array<double, 3> mean;
    std::array<float, 3> grow;  ///< Per axis.
    float spread;
  };
  struct Around {  ///< A node, seen from a centre.
    std::array<float, 3> extent;
    float radius, turn;
  };
  Index modes = 0;
  std::vector<Point> points;
  std::vector<float> basis;                 ///< [node][mode][axis]
  std::vector<std::vector<Around>> around;  ///< [centre][node]

  NodeMotions(const ReducedMotion& motion, std::span<const CentrePose> poses);

  std::span<const float> row(Index node) const {
    return std::span(basis).subspan(std::size_t{node} * modes * 3, std::size_t{modes} * 3);
  }
  /// Where a node's point is at p; the same sum as ReducedMotion::vertex.
  Vec3 at(Index node, std::span<const double> p) const;

 private:
  void place_points(const ReducedMotion& motion);
  void measure(const ReducedMotion& motion, std::span<const CentrePose> poses, Index node,
               std::vector<Index>& scratch);
};

/// A radius around a centre within which the balls around two nodes' vertices stay farther apart than `gap`
/// (R2). 0: none. `deviations` and `p`: of the motion, of the centre.
double balls_apart_radius(const NodeMotions& nodes, Index a, Index b, Index centre, std::span<const double> p,
                          std::span<const double> deviations, double gap, double most);

}  // namespace foldproof
