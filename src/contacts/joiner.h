/// Joins what collides in a step, or crosses in a frame, into groups: connected on both surfaces.
#pragma once

#include "contacts/surfaces.h"

namespace foldproof::inline internal {

/// A contact's number, and whether its sides are those of the element in reverse order.
struct Label {
  Index number = 0;  ///< 0: none.
  bool reversed = false;
};

/// Elements are pairs of patches, one per side: the triangles around a colliding vertex, those with a
/// colliding edge, or one triangle. Two elements are connected when they have a vertex of the first side and
/// one of the second in common. Memory of the last slice of time joins what continues.
class Joiner {
 public:
  /// Begins a slice. What end() labeled in the last one is remembered.
  void begin(std::size_t element_count);
  /// Adds the next element by the vertices of its two sides, global ids, each once.
  void add(std::span<const Index> a, std::span<const Index> b);
  /// Groups of connected elements. Group ids count from 0 in the order of their first elements.
  struct Groups {
    std::vector<Index> group;  ///< Per element.
    std::vector<std::uint8_t>
        reversed;  ///< Per element: its sides are those of its group's in reverse order.
    /// Per group: labels of elements of the last slice that it continues, as seen from the group's sides. A
    /// number may be there several times.
    std::vector<std::vector<Label>> labels;
    std::vector<std::uint8_t> folded;  ///< Per group: its sides are one.
  };
  const Groups& groups();
  /// Ends the slice: labels of the groups, for the next one.
  void end(std::span<const Label> labels);
  /// Forgets the last slice.
  void clear();

 private:
  struct Entry {
    std::uint64_t key = 0;
    Label label;        // of the last slice
    Index element = 0;  // in this slice: the first element that has the key
    bool reversed = false;
  };
  struct Map {
    std::vector<Entry> entries;
    std::vector<Index> slots;           // a hash table of entries, at most half full; kNoIndex: free
    Index& slot(std::uint64_t key);     // the key's slot, or the free one where it goes
    void make_room(std::size_t count);  // for so many more
    void clear();
  };
  struct Link {
    Index parent;
    bool reversed;
  };

  void fetch_keys();
  void add_key(std::uint64_t key, bool reversed);
  Link find_root(Index element);
  void join(Index a, Index b, bool reversed);

  Map now_, before_;
  std::vector<Link> links_;  // union-find over the elements
  std::vector<std::uint8_t> folded_;
  std::vector<std::pair<Index, Label>> found_;  // labels of the last slice, per element
  std::vector<Index> only_a_, only_b_;
  std::vector<std::pair<std::uint64_t, bool>>
      keys_;  // of the newest element; whether its sides are in reverse order
  Groups groups_;
};

}  // namespace foldproof::inline internal
