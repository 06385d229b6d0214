/// For tests of single stages of the pipeline: which pairs of leaves a stage should pass on, by brute force.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <vector>

#include "check/motion.h"
#include "oracle/brute_force.h"

namespace foldproof::oracle {

/// Two leaves, each as object and leaf, the smaller first.
using Leaves = std::array<std::array<Index, 2>, 2>;

inline Leaves leaves_of(Index object_a, Index leaf_a, Index object_b, Index leaf_b) {
  return {std::min(std::array{object_a, leaf_a}, std::array{object_b, leaf_b}),
          std::max(std::array{object_a, leaf_a}, std::array{object_b, leaf_b})};
}
inline Leaves leaves_of(const TraversalTask& task, LeafPair leaves) {
  return leaves_of(task.object_a, leaves.a, task.object_b, leaves.b);
}

/// The box of a leaf's triangles at both ends of the step.
struct MovingBox {
  double low[2][3], high[2][3];
};

inline MovingBox moving_box(const Hierarchy& hierarchy, Index leaf, std::span<const double> x0,
                            std::span<const double> x1) {
  MovingBox box;
  for (int end = 0; end < 2; ++end) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      std::vector<double> all;
      for (Index t = hierarchy.leaves()[leaf].triangles; t < hierarchy.leaves()[leaf + 1].triangles; ++t) {
        for (const Index v : hierarchy.topology().triangles()[hierarchy.triangle_ids()[t]])
          all.push_back((end == 0 ? x0 : x1)[3 * std::size_t{v} + axis]);
      }
      box.low[end][axis] = std::ranges::min(all);
      box.high[end][axis] = std::ranges::max(all);
    }
  }
  return box;
}

/// The largest gap that one side of the boxes keeps during the whole step; negative where they overlap.
inline double gap_between(const MovingBox& a, const MovingBox& b) {
  double gap = -std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    gap = std::max({gap, std::min(b.low[0][axis] - a.high[0][axis], b.low[1][axis] - a.high[1][axis]),
                    std::min(a.low[0][axis] - b.high[0][axis], a.low[1][axis] - b.high[1][axis])});
  }
  return gap;
}

/// All pairs of leaves whose moving boxes come within a distance, a leaf with itself included.
inline std::set<Leaves> near_leaves(const Scene& scene, std::span<const Object> objects,
                                    const StepSettings& settings, double distance) {
  std::vector<std::pair<std::array<Index, 2>, MovingBox>> all;
  for (Index i = 0; i < objects.size(); ++i) {
    const Hierarchy& hierarchy = *objects[i].hierarchy();
    for (Index leaf = 0; leaf < hierarchy.leaf_count(); ++leaf)
      all.push_back({{i, leaf}, moving_box(hierarchy, leaf, scene.x0[i], scene.x1[i])});
  }
  std::set<Leaves> near;
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (std::size_t k = i; k < all.size(); ++k) {
      const auto& [a, box_a] = all[i];
      const auto& [b, box_b] = all[k];
      if (!(a[0] == b[0] ? settings.within : settings.between)) continue;
      if (a == b || gap_between(box_a, box_b) <= distance) near.insert({a, b});
    }
  }
  return near;
}

/// The leaf that owns each feature of a hierarchy, by the user's ids.
struct Owners {
  std::map<Index, Index> of_vertex, of_triangle;
  std::map<Edge, Index> of_edge;

  explicit Owners(const Hierarchy& hierarchy) {
    const auto leaves = hierarchy.leaves();
    for (Index leaf = 0; leaf < hierarchy.leaf_count(); ++leaf) {
      for (Index v = leaves[leaf].vertices; v < leaves[leaf + 1].vertices; ++v)
        of_vertex[hierarchy.vertex_ids()[v]] = leaf;
      for (Index t = leaves[leaf].triangles; t < leaves[leaf + 1].triangles; ++t)
        of_triangle[hierarchy.triangle_ids()[t]] = leaf;
      for (Index e = leaves[leaf].edges; e < leaves[leaf + 1].edges; ++e)
        of_edge[hierarchy.topology().edges()[hierarchy.edge_ids()[e]]] = leaf;
    }
  }
};

/// All pairs of leaves that own two features that collide.
inline std::set<Leaves> touching_leaves(const Scene& scene, std::span<const Object> objects,
                                        const StepSettings& settings, double tolerance) {
  std::vector<Owners> owners;
  for (const Object& object : objects) owners.emplace_back(*object.hierarchy());
  const StepResult found = brute_force_step(scene, settings, tolerance);
  std::set<Leaves> touching;
  for (const VertexFaceCollision& c : found.vertex_face) {
    touching.insert(leaves_of(c.vertex_object, owners[c.vertex_object].of_vertex.at(c.vertex), c.face_object,
                              owners[c.face_object].of_triangle.at(c.face)));
  }
  for (const EdgeEdgeCollision& c : found.edge_edge) {
    touching.insert(leaves_of(c.object_a, owners[c.object_a].of_edge.at(c.a), c.object_b,
                              owners[c.object_b].of_edge.at(c.b)));
  }
  return touching;
}

inline void add_object(Scene& scene, Topology topology, std::vector<double> x0, std::vector<double> x1) {
  scene.topologies.push_back(std::move(topology));
  scene.x0.push_back(std::move(x0));
  scene.x1.push_back(std::move(x1));
}

/// A strip of cells in a row, two triangles each, one wide. `point(u)` is {x, z} of the border at 0 <= u
/// <= 1.
inline Topology strip_topology(Index cells) {
  std::vector<Triangle> triangles;
  for (Index i = 0; i < cells; ++i) {
    triangles.push_back({2 * i, 2 * i + 1, 2 * i + 2});
    triangles.push_back({2 * i + 1, 2 * i + 3, 2 * i + 2});
  }
  return Topology::make(2 * cells + 2, std::move(triangles)).value();
}
template <class Point>
std::vector<double> strip(Index cells, Point point) {
  std::vector<double> x;
  for (Index i = 0; i <= cells; ++i) {
    const std::array<double, 2> p = point(double(i) / cells);
    for (const double y : {0.0, 1.0}) x.insert(x.end(), {p[0], y, p[1]});
  }
  return x;
}

/// A strip of cells that lies flat at the start of the step.
template <class Point>
void add_flat_strip(Scene& scene, Index cells, Point end) {
  const auto flat = [&](double u) { return std::array{cells * u, 0.0}; };
  add_object(scene, strip_topology(cells), strip(cells, flat), strip(cells, end));
}

}  // namespace foldproof::oracle
