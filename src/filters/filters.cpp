// Filters of vertices that do not move, of pairs that touch, and of several filters.

#include <fmt/format.h>

#include <algorithm>

#include "base/try.h"
#include "check/node_labels.h"
#include "filters/by_vertices.h"
#include "foldproof/filters.h"

namespace foldproof {
namespace {

// Tests the pairs all of whose vertices are fixed, or the others.
class FixedFilter final : public ByVertices {
 public:
  FixedFilter(std::span<const Object> objects, std::span<const std::vector<std::uint8_t>> fixed,
              bool tests_fixed)
      : ByVertices(objects), fixed_(fixed.begin(), fixed.end()), tests_fixed_(tests_fixed) {
    for (const Object& object : objects) {
      const Hierarchy& hierarchy = *object.hierarchy();
      const auto& of_vertex = fixed_[nodes_.size()];
      nodes_.emplace_back(hierarchy, [&](Index leaf, std::vector<Index>& labels) {
        for_each_corner(hierarchy, leaf, [&](Index v) { labels.push_back(of_vertex[v] != 0); });
      });
    }
  }

  bool nodes(Index object_a, Index node_a, Index object_b, Index node_b) const override {
    return NodeLabels::any(nodes_[object_a], node_a, nodes_[object_b], node_b,
                           [&](Index a, Index b) { return (a != 0 && b != 0) == tests_fixed_; });
  }

 private:
  bool tests(Index object_a, std::span<const Index> a, Index object_b,
             std::span<const Index> b) const override {
    return (moves(object_a, a) || moves(object_b, b)) != tests_fixed_;
  }
  bool moves(Index object, std::span<const Index> vertices) const {
    return std::ranges::any_of(vertices, [&](Index v) { return fixed_[object][v] == 0; });
  }

  std::vector<std::vector<std::uint8_t>> fixed_;  // per object and vertex
  bool tests_fixed_;
  std::vector<NodeLabels> nodes_;  // per object; 1 for fixed
};

// Pairs as their ids, in one order.
class TouchingFilter final : public PairFilter {
 public:
  TouchingFilter(const std::vector<Object>& objects, const StepResult& close, const StaticResult& crossing) {
    for (const Object& object : objects) hierarchies_.push_back(object.hierarchy());
    for (const auto& c : close.vertex_face)
      vertex_face_.push_back({c.vertex_object, c.vertex, c.face_object, c.face});
    for (const auto& c : close.edge_edge) edge_edge_.push_back(edges(c.object_a, c.a, c.object_b, c.b));
    for (const auto& c : crossing.crossings)
      crossings_.push_back(triangles(c.object_a, c.triangle_a, c.object_b, c.triangle_b));
    std::sort(vertex_face_.begin(), vertex_face_.end());
    std::sort(edge_edge_.begin(), edge_edge_.end());
    std::sort(crossings_.begin(), crossings_.end());
  }

  bool nodes(Index, Index, Index, Index) const override { return true; }
  bool vertex_face(Index vertex_object, Index vertex, Index face_object, Index face) const override {
    return !contains(vertex_face_, Ids{vertex_object, vertex, face_object, face});
  }
  bool edge_edge(Index object_a, const Edge& a, Index object_b, const Edge& b) const override {
    return !contains(edge_edge_, edges(object_a, a, object_b, b));
  }
  bool crossing(Index object_a, Index triangle_a, Index object_b, Index triangle_b) const override {
    if (contains(crossings_, triangles(object_a, triangle_a, object_b, triangle_b))) return false;
    const Triangle &a = triangle(object_a, triangle_a), &b = triangle(object_b, triangle_b);
    for (int i = 0; i < 3; ++i) {
      if (!vertex_face(object_a, a[i], object_b, triangle_b) ||
          !vertex_face(object_b, b[i], object_a, triangle_a))
        return false;
      for (int k = 0; k < 3; ++k) {
        if (!edge_edge(object_a, {a[i], a[(i + 1) % 3]}, object_b, {b[k], b[(k + 1) % 3]})) return false;
      }
    }
    return true;
  }

 private:
  using Edges = std::array<Index, 6>;
  using Ids = std::array<Index, 4>;
  static Edges edges(Index object_a, const Edge& a, Index object_b, const Edge& b) {
    const auto [a0, a1] = std::minmax(a[0], a[1]);
    const auto [b0, b1] = std::minmax(b[0], b[1]);
    return std::min(Edges{object_a, a0, a1, object_b, b0, b1}, Edges{object_b, b0, b1, object_a, a0, a1});
  }
  template <class Pair>
  static bool contains(const std::vector<Pair>& pairs, const Pair& pair) {
    return std::binary_search(pairs.begin(), pairs.end(), pair);
  }
  static Ids triangles(Index object_a, Index a, Index object_b, Index b) {
    return std::min(Ids{object_a, a, object_b, b}, Ids{object_b, b, object_a, a});
  }
  const Triangle& triangle(Index object, Index triangle) const {
    return hierarchies_[object]->topology().triangles()[triangle];
  }

  std::vector<std::shared_ptr<const Hierarchy>> hierarchies_;
  std::vector<Ids> vertex_face_, crossings_;  // sorted
  std::vector<Edges> edge_edge_;
};

class AllFilters final : public PairFilter {
 public:
  explicit AllFilters(std::vector<std::shared_ptr<const PairFilter>> filters)
      : filters_(std::move(filters)) {}

  bool nodes(Index object_a, Index node_a, Index object_b, Index node_b) const override {
    return all([&](const PairFilter& f) { return f.nodes(object_a, node_a, object_b, node_b); });
  }
  bool vertex_face(Index vertex_object, Index vertex, Index face_object, Index face) const override {
    return all([&](const PairFilter& f) { return f.vertex_face(vertex_object, vertex, face_object, face); });
  }
  bool edge_edge(Index object_a, const Edge& a, Index object_b, const Edge& b) const override {
    return all([&](const PairFilter& f) { return f.edge_edge(object_a, a, object_b, b); });
  }
  bool crossing(Index object_a, Index triangle_a, Index object_b, Index triangle_b) const override {
    return all([&](const PairFilter& f) { return f.crossing(object_a, triangle_a, object_b, triangle_b); });
  }

 private:
  template <class Tests>
  bool all(Tests tests) const {
    return std::ranges::all_of(filters_, [&](const auto& filter) { return tests(*filter); });
  }
  std::vector<std::shared_ptr<const PairFilter>> filters_;
};

}  // namespace

Result<std::shared_ptr<const PairFilter>> ignore_fixed(std::span<const Object> objects,
                                                       std::span<const std::vector<std::uint8_t>> fixed) {
  if (fixed.size() != objects.size()) {
    return fail(ErrorCode::InvalidArgument, "fixed",
                fmt::format("is for {} objects instead of {}", fixed.size(), objects.size()),
                "give a list for each object");
  }
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const Index vertices = objects[i].hierarchy()->topology().vertex_count();
    if (fixed[i].size() == vertices) continue;
    return fail(ErrorCode::InvalidArgument, fmt::format("fixed of object {}", i),
                fmt::format("has {} numbers", fixed[i].size()),
                fmt::format("give one for each of the {} vertices", vertices));
  }
  return std::make_shared<const FixedFilter>(objects, fixed, false);
}

std::shared_ptr<const PairFilter> internal::ignore_all_but_fixed(
    std::span<const Object> objects, std::span<const std::vector<std::uint8_t>> fixed) {
  return std::make_shared<const FixedFilter>(objects, fixed, true);
}

Result<std::shared_ptr<const PairFilter>> ignore_touching(const std::vector<Object>& objects, Positions x,
                                                          double thickness) {
  StepChecker checker(objects);
  StepResult close;
  StaticResult crossing;
  FOLDPROOF_TRY(checker.check(x, x, {.thickness = thickness}, close));
  FOLDPROOF_TRY(checker.check_static(x, {}, crossing));
  if (!close.lists_all() || crossing.crossings.size() < crossing.crossing_count)
    return fail(ErrorCode::LimitExceeded, "pose", "has too many pairs that touch",
                "give a smaller thickness");
  return std::make_shared<const TouchingFilter>(objects, close, crossing);
}

std::shared_ptr<const PairFilter> ignore_all(std::vector<std::shared_ptr<const PairFilter>> filters) {
  return std::make_shared<const AllFilters>(std::move(filters));
}

}  // namespace foldproof
