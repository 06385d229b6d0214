// The patches of a hierarchy and their contents.

#include <algorithm>
#include <utility>

#include "certificate/patch.h"

namespace foldproof::internal {

namespace {

// The leaves at each vertex, ascending: leaves[begin[v]] to leaves[end[v] - 1].
struct LeavesAtVertices {
  explicit LeavesAtVertices(const Hierarchy& h) : begin(h.vertex_ids().size() + 1, 0) {
    for (const Triangle& t : h.triangles()) {
      for (const Index v : t) ++begin[v + 1];
    }
    for (std::size_t v = 1; v < begin.size(); ++v) begin[v] += begin[v - 1];
    end.assign(begin.begin(), begin.end() - 1);
    leaves.resize(begin.back());
    for (Index leaf = 0; leaf < h.leaf_count(); ++leaf) {
      for (Index t = h.leaves()[leaf].triangles; t < h.leaves()[leaf + 1].triangles; ++t) {
        for (const Index v : h.triangles()[t]) {
          if (end[v] == begin[v] || leaves[end[v] - 1] != leaf) leaves[end[v]++] = leaf;
        }
      }
    }
  }
  std::span<const Index> at(Index v) const { return std::span(leaves).subspan(begin[v], end[v] - begin[v]); }

  std::vector<Index> begin, end, leaves;
};

}  // namespace

PatchSlots::PatchSlots(std::shared_ptr<const Hierarchy> hierarchy) : hierarchy_(std::move(hierarchy)) {
  const Hierarchy& h = *hierarchy_;
  const LeavesAtVertices leaves(h);
  // Fewer where even these would be more pairs than an Index numbers.
  std::size_t most = kMaxLeavesAtVertex;
  const auto pairs = [&] {
    std::uint64_t all = 0;
    for (Index v = 0; v < leaves.end.size(); ++v) {
      if (const std::uint64_t count = leaves.at(v).size(); count <= most) all += count * count;
    }
    return all;
  };
  while (pairs() > kNoIndex / 2) most /= 2;

  std::vector<Index> last_neighbor(h.leaf_count(), kNoIndex);  // of which leaf each was listed last
  begin_.push_back(0);
  for (Index leaf = 0; leaf < h.leaf_count(); ++leaf) {
    const auto first = static_cast<std::ptrdiff_t>(neighbor_.size());
    for (Index t = h.leaves()[leaf].triangles; t < h.leaves()[leaf + 1].triangles; ++t) {
      for (const Index v : h.triangles()[t]) {
        if (leaves.at(v).size() > most) continue;
        for (const Index other : leaves.at(v)) {
          if (other != leaf && std::exchange(last_neighbor[other], leaf) != leaf) neighbor_.push_back(other);
        }
      }
    }
    std::sort(neighbor_.begin() + first, neighbor_.end());
    leaf_.resize(neighbor_.size(), leaf);
    begin_.push_back(static_cast<Index>(neighbor_.size()));
  }
  neighbor_.shrink_to_fit();
  leaf_.shrink_to_fit();
}

Index PatchSlots::of_leaves(Index leaf_a, Index leaf_b) const {
  const auto [a, b] = std::minmax(leaf_a, leaf_b);
  // Neighbors ascend, and around a vertex of high valence there are many.
  const auto first = neighbor_.begin() + begin_[a], last = neighbor_.begin() + begin_[a + 1];
  const auto found = std::lower_bound(first, last, b);
  if (found == last || *found != b) return kNoIndex;
  return node_count() + static_cast<Index>(found - neighbor_.begin());
}

Index PatchSlots::triangle_count(Index slot) const {
  const auto leaves = hierarchy_->leaves();
  const auto count = [&](Index begin, Index end) { return leaves[end].triangles - leaves[begin].triangles; };
  if (is_pair(slot)) {
    const auto [a, b] = leaves_of(slot);
    return count(a, a + 1) + count(b, b + 1);
  }
  const Hierarchy::Node& node = hierarchy_->nodes()[slot];
  return count(node.leaf_begin, node.leaf_end);
}

PatchReader::PatchReader(const PatchSlots& slots)
    : slots_(slots),
      local_number_(slots.hierarchy()->vertex_ids().size()),
      last_patch_(slots.hierarchy()->vertex_ids().size(), 0) {}

void PatchReader::add_leaves(Index begin, Index end, Patch& out) {
  const Hierarchy& h = *slots_.hierarchy();
  for (Index t = h.leaves()[begin].triangles; t < h.leaves()[end].triangles; ++t) {
    auto& local = out.triangles.emplace_back();
    for (int k = 0; k < 3; ++k) {
      const Index v = h.triangles()[t][k];
      if (last_patch_[v] != patch_) {
        last_patch_[v] = patch_;
        local_number_[v] = static_cast<std::uint16_t>(out.vertices.size());
        out.vertices.push_back(v);
      }
      local[k] = local_number_[v];
    }
  }
}

void PatchReader::add_leaf(Index leaf, Patch& out) { add_leaves(leaf, leaf + 1, out); }

void PatchReader::read(Index slot, Patch& out) {
  out.vertices.clear();
  out.triangles.clear();
  if (++patch_ == 0) {  // after 2^32 patches
    std::fill(last_patch_.begin(), last_patch_.end(), 0u);
    patch_ = 1;
  }
  if (slots_.is_pair(slot)) {
    for (const Index leaf : slots_.leaves_of(slot)) add_leaf(leaf, out);
  } else {
    const Hierarchy::Node& node = slots_.hierarchy()->nodes()[slot];
    add_leaves(node.leaf_begin, node.leaf_end, out);
  }
}

}  // namespace foldproof::internal
