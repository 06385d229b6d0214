#include "check/hubs.h"

#include <algorithm>
#include <iterator>
#include <numeric>
#include <utility>

#include "certificate/separating_plane.h"

namespace foldproof::internal {
namespace {

std::vector<Index> intersection(std::span<const Index> a, std::span<const Index> b) {
  std::vector<Index> both;
  std::set_intersection(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(both));
  return both;
}

std::vector<Index> merged(std::span<const Index> a, std::span<const Index> b) {
  std::vector<Index> all;
  std::set_union(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(all));
  return all;
}

// Vertices with many triangles, as indices in leaf order, ascending.
std::vector<Index> hubs_of(const Hierarchy& hierarchy) {
  std::vector<Index> triangles(hierarchy.vertex_ids().size()), hubs;
  for (const Triangle& t : hierarchy.triangles()) {
    for (const Index v : t) ++triangles[v];
  }
  for (Index v = 0; v < triangles.size(); ++v) {
    if (triangles[v] >= Hubs::kMinTriangles) hubs.push_back(v);
  }
  return hubs;
}

}  // namespace

// Children follow their parents, so one backward sweep sees every child before its parent.
Hubs::Hubs(const Hierarchy& hierarchy) {
  const std::vector<Index> hubs = hubs_of(hierarchy);
  if (hubs.empty()) return;
  const auto nodes = hierarchy.nodes();
  const auto leaves = hierarchy.leaves();
  const LeafVertexLists lists = list_leaf_vertices(hierarchy);
  row_.assign(nodes.size(), kNoIndex);
  for (std::size_t i = nodes.size(); i-- > 0;) {
    const auto& [right, leaf_begin, leaf_end] = nodes[i];
    Node node{{}, {}, leaves[leaf_begin].vertices, leaves[leaf_end].vertices};
    std::vector<Index> vertices;  // which include those that the node does not own
    if (nodes[i].is_leaf()) {
      const auto first = lists.vertices.begin() + lists.begin[leaf_begin],
                 last = lists.vertices.begin() + lists.begin[leaf_end];
      vertices.assign(first, last);
      node.hubs = intersection(vertices, hubs);
    } else if (row_[i + 1] != kNoIndex && row_[right] != kNoIndex) {
      const Node &a = nodes_[row_[i + 1]], &b = nodes_[row_[right]];
      node.hubs = intersection(a.hubs, b.hubs);
      if (!node.hubs.empty()) vertices = merged(a.before, b.before);
    }
    if (node.hubs.empty()) continue;
    // A vertex belongs to the first leaf that uses it.
    node.before.assign(vertices.begin(), std::ranges::lower_bound(vertices, node.first_vertex));
    row_[i] = static_cast<Index>(nodes_.size());
    nodes_.push_back(std::move(node));
  }
}

bool Hubs::have_common_hub(NodePair nodes) const {
  return is_around_hub(nodes.a) && is_around_hub(nodes.b) &&
         !intersection(nodes_[row_[nodes.a]].hubs, nodes_[row_[nodes.b]].hubs).empty();
}

void Hubs::list_vertices(NodeIndex node, std::vector<Index>& out) const {
  const Node& of = nodes_[row_[node]];
  out = of.before;
  const std::size_t owned = out.size();
  out.resize(owned + of.end_of_vertices - of.first_vertex);
  std::iota(out.begin() + static_cast<std::ptrdiff_t>(owned), out.end(), of.first_vertex);
}

void HubPlanes::begin(const Hubs& hubs, std::span<const MovingVertex> vertices, double gap) {
  hubs_ = &hubs;
  vertices_ = vertices;
  gap_ = gap;
}

// Returns false where there are too many common vertices, or where a node has no others.
bool HubPlanes::find_sides(NodePair nodes) {
  hubs_->list_vertices(nodes.a, all_a_);
  hubs_->list_vertices(nodes.b, all_b_);
  common_.clear();
  std::set_intersection(all_a_.begin(), all_a_.end(), all_b_.begin(), all_b_.end(),
                        std::back_inserter(common_));
  if (common_.size() > kMaxCommon) return false;
  const auto arrange = [&](const std::vector<Index>& all, std::vector<Index>& side) {
    side.assign(common_.begin(), common_.begin() + !common_.empty());
    std::set_difference(all.begin(), all.end(), common_.begin(), common_.end(), std::back_inserter(side));
    if (common_.size() == 2) side.push_back(common_.back());
    return all.size() > common_.size();
  };
  return arrange(all_a_, side_a_) && arrange(all_b_, side_b_);
}

// The vertices of one node only, with those of the common ones whose bits are set.
std::span<const Index> HubPlanes::part(const std::vector<Index>& side, unsigned given) const {
  const std::size_t skipped = !common_.empty() && (given & 1) == 0,
                    dropped = common_.size() == 2 && (given & 2) == 0;
  return std::span(side).subspan(skipped, side.size() - skipped - dropped);
}

// B3h: one plane for each way to give every common vertex to one of the nodes.
bool HubPlanes::separates(NodePair nodes) {
  if (!hubs_->is_around_hub(nodes.a) || !hubs_->is_around_hub(nodes.b) || !find_sides(nodes)) return false;
  PlaneNormal normal{};  // one plane is often near the next
  for (unsigned given = 0; given < 1u << common_.size(); ++given) {
    ++tests;
    if (!plane_separates(vertices_, part(side_a_, given), vertices_, part(side_b_, ~given), gap_, &normal))
      return false;
  }
  ++passes;
  return true;
}

}  // namespace foldproof::internal
