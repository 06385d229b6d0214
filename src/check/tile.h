/// Tiles: what a traversal works on, and what it remembers from step to step.
#pragma once

#include <bit>
#include <compare>

#include "certificate/separating_plane.h"
#include "check/leaf_pairs.h"

namespace foldproof::inline internal {

/// Swaps two buffers. Both get the larger capacity, so that what fits one of them later allocates nothing.
template <class T>
void swap_buffers(std::vector<T>& a, std::vector<T>& b) {
  a.swap(b);
  const std::size_t capacity = std::max(a.capacity(), b.capacity());
  a.reserve(capacity);
  b.reserve(capacity);
}

/// Where a traversal stopped, and the next one resumes. Together it covers all pairs of leaves of the tile.
struct Front {
  /// The part below a pair of nodes: from these indices up to those of the next segment.
  struct Segment {
    NodeIndex node;  ///< Whose children are the pair; of a tile of two subtrees: 0.
    std::size_t pairs, near;
  };
  std::vector<Segment> segments;   ///< Ascending by node.
  std::vector<NodePair> pairs;     ///< Separated nodes.
  std::vector<NearLeafPair> near;  ///< Leaves that came near since the segment was made anew.
  void clear() {
    segments.clear();
    pairs.clear();
    near.clear();
  }
};

/// The history of planes between two leaves.
struct CachedPlane {
  PlaneNormal normal{};                     ///< The last one that separated them.
  std::uint8_t back_off = 0, failures = 0;  ///< Steps until the next test; failures in a row.
};

/// Planes by a hash of their leaves. Pairs that share an entry cost time only.
class PlaneTable {
 public:
  /// Makes room for so many pairs.
  void reserve(std::size_t pairs) {
    const std::size_t old = planes_.size(), wanted = std::bit_ceil(kEntriesPerPair * pairs);
    if (pairs == 0 || wanted <= old) return;
    planes_.resize(wanted);
    // The low bits of a hash chose an old entry.
    for (std::size_t i = old; old > 0 && i < wanted; ++i) planes_[i] = planes_[i - old];
  }
  CachedPlane& at(std::uint64_t hash) { return planes_[hash & (planes_.size() - 1)]; }

 private:
  static constexpr std::size_t kEntriesPerPair = 4;
  std::vector<CachedPlane> planes_;
};

/// The pairs of leaves of two subtrees, of one object or two, or within one subtree.
struct Tile {
  struct Key {
    Index object_a, object_b;
    NodeIndex a, b;  ///< The subtrees' roots; the same: within it.
    auto operator<=>(const Key&) const = default;
    bool is_self() const { return object_a == object_b && a == b; }
  };
  explicit Tile(const Key& of) : key(of) {}
  void begin_step() {
    remaining.clear();
    requests.clear();
    node_tests = plane_pairs = 0;
  }

  Key key;
  std::size_t last_step = 0;
  Front front;
  PlaneTable planes;

  // Of the present step:
  std::vector<LeafPair> remaining;  ///< Leaves whose features are to be tested.
  std::vector<SlotIndex> requests;  ///< Slots of such leaves that want a chart.
  std::size_t node_tests = 0;
  std::size_t plane_pairs = 0;  ///< Near leaves without a common vertex.
};

}  // namespace foldproof::inline internal
