/// The patches of a hierarchy that may have charts.
#pragma once

#include <cstdint>
#include <memory>

#include "foldproof/bvh.h"

namespace foldproof::inline internal {

/// Some triangles of a mesh, with local vertex numbers.
struct Patch {
  std::vector<Index> vertices;                          ///< Numbers in the hierarchy's leaf order.
  std::vector<std::array<std::uint16_t, 3>> triangles;  ///< Indices into `vertices`.
};

/// Numbers the patches of a hierarchy that may have charts: the leaves below each node, and each two leaves
/// with a common vertex. Vertices at which more than kMaxLeavesAtVertex leaves meet do not count, or there
/// would be quadratically many. Immutable.
class PatchSlots {
 public:
  static constexpr Index kMaxLeavesAtVertex = 256;
  explicit PatchSlots(std::shared_ptr<const Hierarchy> hierarchy);

  const std::shared_ptr<const Hierarchy>& hierarchy() const { return hierarchy_; }
  Index count() const { return node_count() + static_cast<Index>(neighbor_.size()); }
  Index of_node(Index node) const { return node; }
  /// kNoIndex for equal leaves and for leaves without a common vertex that counts.
  Index of_leaves(Index leaf_a, Index leaf_b) const;
  bool is_pair(Index slot) const { return slot >= node_count(); }
  std::array<Index, 2> leaves_of(Index pair_slot) const {
    return {leaf_[pair_slot - node_count()], neighbor_[pair_slot - node_count()]};
  }
  /// Leaves with a vertex of this one that counts, ascending.
  std::span<const Index> neighbors(Index leaf) const {
    return std::span(neighbor_).subspan(begin_[leaf], begin_[leaf + 1] - begin_[leaf]);
  }
  Index triangle_count(Index slot) const;

 private:
  Index node_count() const { return static_cast<Index>(hierarchy_->nodes().size()); }
  std::shared_ptr<const Hierarchy> hierarchy_;
  std::vector<Index> begin_, neighbor_;  // per leaf, its neighbors
  std::vector<Index> leaf_;              // per entry of neighbor_: the leaf it is a neighbor of
};

/// Reads patches. Scratch: one per thread.
class PatchReader {
 public:
  explicit PatchReader(const PatchSlots& slots);
  /// Replaces `out` by the patch of a slot.
  void read(Index slot, Patch& out);
  /// Adds a leaf to the patch of the last read().
  void add_leaf(Index leaf, Patch& out);

 private:
  void add_leaves(Index begin, Index end, Patch& out);
  const PatchSlots& slots_;
  // Per vertex: its number in the patch that read it last, and which patch that was.
  std::vector<std::uint16_t> local_number_;
  std::vector<std::uint32_t> last_patch_;
  std::uint32_t patch_ = 0;
};

}  // namespace foldproof::inline internal
