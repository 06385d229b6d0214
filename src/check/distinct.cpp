#include "check/distinct.h"

#include <algorithm>
#include <cassert>
#include <numeric>
#include <tuple>

namespace foldproof::internal {

DistinctTriangles::DistinctTriangles(std::shared_ptr<const Hierarchy> all, std::span<const Index> kinds)
    : hierarchy_(std::move(all)) {
  if (find_copies(hierarchy_->topology(), kinds)) drop_copies(*hierarchy_);
}

// Fills first_, ids_ and repeated_. Returns false, and leaves them empty, when there are no copies. Buckets
// triangles by their first vertex and sorts each bucket.
bool DistinctTriangles::find_copies(const Topology& topology, std::span<const Index> kinds) {
  const auto triangles = topology.triangles();
  std::vector<Index> end(topology.vertex_count() + std::size_t{1}, 0), order(triangles.size());
  for (const Triangle& t : triangles) ++end[t[0] + std::size_t{1}];
  std::partial_sum(end.begin(), end.end(), end.begin());
  // Before this, end[v] is where bucket v begins; after it, where it ends.
  for (Index i = 0; i < triangles.size(); ++i) order[end[triangles[i][0]]++] = i;
  // A line is no copy of a face that names a vertex twice, which meets more.
  const auto key = [&](Index t) {
    return std::tuple(triangles[t], topology.element(t), kinds.empty() ? 0 : kinds[t]);
  };
  const auto less = [&](Index a, Index b) { return std::pair(key(a), a) < std::pair(key(b), b); };
  bool any = false;
  std::ptrdiff_t begin = 0;
  for (Index v = 0; v < topology.vertex_count(); begin = end[v++]) {
    std::sort(order.begin() + begin, order.begin() + end[v], less);
    for (std::ptrdiff_t k = begin + 1; k < end[v]; ++k) any |= key(order[k]) == key(order[k - 1]);
  }
  if (!any) return false;

  std::vector<Index> original(triangles.size());  // of every triangle, its first copy
  for (std::size_t k = 0; k < order.size(); ++k) {
    const bool copy = k > 0 && key(order[k]) == key(order[k - 1]);
    original[order[k]] = copy ? original[order[k - 1]] : order[k];
  }
  std::vector<Index> count(triangles.size(), 0), number(triangles.size(), kNoIndex);
  for (const Index first : original) ++count[first];
  first_.assign(1, 0);
  for (Index i = 0; i < triangles.size(); ++i) {
    if (original[i] != i) continue;
    number[i] = static_cast<Index>(first_.size() - 1);
    if (count[i] > 1) repeated_.push_back(number[i]);
    first_.push_back(first_.back() + count[i]);
  }
  ids_.resize(triangles.size());
  std::vector<Index> next(first_.begin(), first_.end() - 1);
  for (Index i = 0; i < triangles.size(); ++i) ids_[next[number[original[i]]]++] = i;
  return true;
}

// Removes copies from the tree, and nodes that no longer own any triangle.
void DistinctTriangles::drop_copies(const Hierarchy& all) {
  const auto triangles = all.topology().triangles();
  std::vector<Triangle> faces;
  std::vector<Edge> lines;
  std::vector<Index> points, number(triangles.size());
  const auto count = static_cast<Index>(first_.size() - 1);
  for (Index t = 0; t < count; ++t) {
    const auto& [a, b, c] = triangles[ids_[first_[t]]];
    switch (all.topology().element(ids_[first_[t]])) {
      case Element::Face:
        faces.push_back({a, b, c});
        break;
      case Element::Line:
        lines.push_back({a, b});
        break;
      case Element::Point:
        points.push_back(a);
        break;
    }
    for (const Index id : copies(t)) number[id] = t;
  }
  // The first copy in leaf order stays in its leaf.
  const auto nodes = all.nodes();
  const auto leaves = all.leaves();
  std::vector<bool> placed(count, false);
  std::vector<Index> order, owned(nodes.size(), 0);  // owned: triangles that remain, per node
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    if (!nodes[n].is_leaf()) continue;
    const Index leaf = nodes[n].leaf_begin;
    for (Index k = leaves[leaf].triangles; k < leaves[leaf + 1].triangles; ++k) {
      const Index t = number[all.triangle_ids()[k]];
      if (placed[t]) continue;
      placed[t] = true;
      order.push_back(t);
      ++owned[n];
    }
  }
  for (std::size_t n = nodes.size(); n-- > 0;) {
    if (!nodes[n].is_leaf()) owned[n] = owned[n + 1] + owned[nodes[n].right];
  }
  std::vector<Index> leaf_sizes;
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    const bool leaf = nodes[n].is_leaf();
    if (leaf ? owned[n] == 0 : owned[n + 1] == 0 || owned[nodes[n].right] == 0) continue;
    leaf_sizes.push_back(leaf ? owned[n] : 0);
    node_ids_.push_back(static_cast<Index>(n));
  }
  auto topology = Topology::make(all.topology().vertex_count(), std::move(faces), lines, points);
  assert(topology);
  auto distinct_hierarchy = Hierarchy::from_parts(std::move(*topology), std::move(order), leaf_sizes);
  assert(distinct_hierarchy);
  hierarchy_ = std::make_shared<const Hierarchy>(std::move(*distinct_hierarchy));
}

}  // namespace foldproof::internal
