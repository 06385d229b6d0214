#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/plain_arithmetic.h"
#include "base/try.h"
#include "bvh/split.h"

namespace foldproof {
namespace {

Result<void> check_positions(const Topology& topology, std::span<const double> positions) {
  if (positions.size() != 3 * std::size_t{topology.vertex_count()}) {
    return fail(ErrorCode::InvalidArgument, "positions",
                fmt::format("{} numbers for {} vertices", positions.size(), topology.vertex_count()),
                "give three coordinates per vertex");
  }
  for (std::size_t i = 0; i < positions.size(); ++i) {
    if (!std::isfinite(positions[i])) {
      return fail(ErrorCode::NonFinite, fmt::format("vertex {}", i / 3),
                  "has a coordinate that is not finite", "repair the positions");
    }
  }
  return {};
}

// One that is built has some 700 levels at most, as each half has at least 1/32 of the triangles (split.cpp).
constexpr Index kMaxLevels = 1024;

bool is_shallow(std::span<const Hierarchy::Node> nodes) {
  std::vector<Index> level(nodes.size());
  for (Index id = 0; id < nodes.size(); ++id) {
    if (level[id] == kMaxLevels) return false;
    if (!nodes[id].is_leaf()) level[id + 1] = level[nodes[id].right] = level[id] + 1;
  }
  return true;
}

// Appends what describes a hierarchy to Hierarchy::from_parts.
void append_parts(const Hierarchy& tree, Index first_triangle, std::vector<Index>& triangle_ids,
                  std::vector<Index>& leaf_sizes) {
  for (const Index id : tree.triangle_ids()) triangle_ids.push_back(first_triangle + id);
  const auto leaves = tree.leaves();
  for (const Hierarchy::Node& node : tree.nodes()) {
    const Index leaf = node.leaf_begin;
    leaf_sizes.push_back(node.is_leaf() ? leaves[leaf + 1].triangles - leaves[leaf].triangles : 0);
  }
}

// Faces, lines and points have trees of their own below common nodes, because a leaf with an element that has
// no area gets no chart.
Result<Hierarchy> build_joined(Topology all, std::span<const double> positions,
                               const HierarchySettings& settings) {
  std::vector<Index> triangle_ids, leaf_sizes;
  const auto triangles = all.triangles();
  const Index faces = all.face_count(), lines = all.line_count();
  std::vector<std::span<const Triangle>> parts{triangles.first(faces), triangles.subspan(faces, lines),
                                               triangles.subspan(faces + lines)};
  std::erase_if(parts, [](const auto& part) { return part.empty(); });
  for (const auto& part : parts) {
    if (part.data() != parts.back().data()) leaf_sizes.push_back(0);
    auto topology = FOLDPROOF_TRY(Topology::make(all.vertex_count(), {part.begin(), part.end()}));
    const auto tree = FOLDPROOF_TRY(Hierarchy::build(std::move(topology), positions, settings));
    append_parts(tree, static_cast<Index>(part.data() - triangles.data()), triangle_ids, leaf_sizes);
  }
  return Hierarchy::from_parts(std::move(all), std::move(triangle_ids), leaf_sizes);
}

}  // namespace

Result<Hierarchy> Hierarchy::build(Topology topology, std::span<const double> positions,
                                   const HierarchySettings& settings) {
  const PlainArithmetic plain;
  const auto count = static_cast<Index>(topology.triangles().size());
  if (count == 0)
    return fail(ErrorCode::InvalidMesh, "mesh", "has no triangles", "give a mesh with at least one face");
  FOLDPROOF_TRY(check_positions(topology, positions));
  if (topology.element(0) != topology.element(count - 1))
    return build_joined(std::move(topology), positions, settings);
  Hierarchy tree;
  tree.topology_ = std::move(topology);
  SplitSurface split =
      split_surface(tree.topology_, positions, std::clamp<Index>(settings.leaf_triangles, 1, count));
  tree.triangle_ids_ = std::move(split.triangle_ids);
  tree.build_nodes(split.leaf_sizes);
  tree.assign_owners();
  return tree;
}

Result<Hierarchy> Hierarchy::from_parts(Topology topology, std::vector<Index> triangle_ids,
                                        std::span<const Index> leaf_sizes) {
  const std::size_t count = topology.triangles().size();
  std::vector<bool> seen(count, false);
  bool permutation = triangle_ids.size() == count;
  for (std::size_t k = 0; permutation && k < count; ++k) {
    permutation = triangle_ids[k] < count && !seen[triangle_ids[k]];
    if (permutation) seen[triangle_ids[k]] = true;
  }
  if (!permutation)
    return fail(ErrorCode::InvalidMesh, "triangle order", "does not name every triangle once",
                "build it again");
  Hierarchy tree;
  tree.topology_ = std::move(topology);
  tree.triangle_ids_ = std::move(triangle_ids);
  if (!tree.build_nodes(leaf_sizes))
    return fail(ErrorCode::InvalidMesh, "nodes", "do not form a tree over the triangles", "build it again");
  if (!tree.elements_are_apart())
    return fail(ErrorCode::InvalidMesh, "leaves", "mix faces, lines and points", "build it again");
  if (!is_shallow(tree.nodes_))
    return fail(ErrorCode::LimitExceeded, "nodes", fmt::format("have more than {} levels", kMaxLevels),
                "build it again");
  tree.assign_owners();
  return tree;
}

// Makes nodes and leaves from the number of triangles per node in depth-first order. Returns false when they
// do not form a tree.
bool Hierarchy::build_nodes(std::span<const Index> leaf_sizes) {
  const std::size_t count = topology_.triangles().size();
  std::size_t triangles_before = 0;
  std::vector<Index> open;  // inner nodes whose right child is still to come
  for (Index id = 0; id < leaf_sizes.size(); ++id) {
    if (id > 0 &&
        nodes_[id - 1].leaf_begin != leaves_.size()) {  // the previous node is a leaf, not the parent
      if (open.empty()) return false;
      nodes_[open.back()].right = id;
      open.pop_back();
    }
    Node node;
    node.leaf_begin = static_cast<Index>(leaves_.size());
    nodes_.push_back(node);
    if (leaf_sizes[id] == 0) {
      open.push_back(id);
      continue;
    }
    if (leaf_sizes[id] > count - triangles_before) return false;
    leaves_.push_back({static_cast<Index>(triangles_before), 0, 0});
    triangles_before += leaf_sizes[id];
  }
  if (nodes_.empty() || !open.empty() || triangles_before != count || leaf_sizes.back() == 0) return false;
  leaves_.push_back({static_cast<Index>(count), 0, 0});
  compute_leaf_ranges();
  return true;
}

bool Hierarchy::elements_are_apart() const {
  for (Index leaf = 0; leaf < leaf_count(); ++leaf) {
    for (Index k = leaves_[leaf].triangles; k < leaves_[leaf + 1].triangles; ++k) {
      if (topology_.element(triangle_ids_[k]) != element(leaf)) return false;
    }
  }
  return true;
}

// Children follow their parents, so one backward sweep sees every child before its parent.
void Hierarchy::compute_leaf_ranges() {
  for (std::size_t i = nodes_.size(); i-- > 0;) {
    Node& node = nodes_[i];
    node.leaf_end = node.is_leaf() ? node.leaf_begin + 1 : nodes_[node.right].leaf_end;
  }
}

void Hierarchy::assign_owners() {
  std::vector<Index> leaf_order(topology_.vertex_count(), kNoIndex);
  std::vector<bool> edge_owned(topology_.edges().size(), false);
  const auto all_triangles = topology_.triangles();
  const auto sides = topology_.triangle_edges();
  triangles_.reserve(all_triangles.size());
  for (Index leaf = 0; leaf < leaf_count(); ++leaf) {
    leaves_[leaf].edges = static_cast<Index>(edge_ids_.size());
    leaves_[leaf].vertices = static_cast<Index>(vertex_ids_.size());
    for (Index k = leaves_[leaf].triangles; k < leaves_[leaf + 1].triangles; ++k) {
      const Index id = triangle_ids_[k];
      Triangle local;
      for (int c = 0; c < 3; ++c) {
        Index& vertex = leaf_order[all_triangles[id][c]];
        if (vertex == kNoIndex) {
          vertex = static_cast<Index>(vertex_ids_.size());
          vertex_ids_.push_back(all_triangles[id][c]);
        }
        local[c] = vertex;
        const Index edge = sides[id][c];
        if (edge != kNoIndex && !edge_owned[edge]) {
          edge_owned[edge] = true;
          edge_ids_.push_back(edge);
        }
      }
      triangles_.push_back(local);
    }
  }
  leaves_.back().edges = static_cast<Index>(edge_ids_.size());
  leaves_.back().vertices = static_cast<Index>(vertex_ids_.size());
  edges_.reserve(edge_ids_.size());
  for (const Index id : edge_ids_) {
    const Edge& edge = topology_.edges()[id];
    edges_.push_back({leaf_order[edge[0]], leaf_order[edge[1]]});
  }
}

}  // namespace foldproof
