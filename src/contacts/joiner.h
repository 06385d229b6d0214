/// Joins what collides in a step, or crosses in a frame, into groups: connected on both surfaces.
#pragma once

#include "contacts/surfaces.h"

namespace foldproof::inline internal {

/// A contact's number, and whether its sides are those of the element in reverse order.
struct Label {
  Index number = 0;  ///< 0: none.
  bool reversed = false;
};

/// Elements are pairs of features, one per side: a vertex and a face, two edges, two triangles. A pair of
/// vertices, one of each side, is a key of the element. Elements are connected that have a key in common; and
/// those of a vertex and a face each whose keys (u, w) and (v, w) have neighbors u and v, the vertices.
/// Memory of the last slice of time joins what continues: what has a key in common with it, or else what has
/// a key with a vertex in common, where the other two vertices are neighbors.
class Joiner {
 public:
  explicit Joiner(const Surfaces& surfaces) : surfaces_(surfaces) {}

  /// Begins a slice. What end() labeled in the last one is remembered.
  void begin(std::size_t element_count);
  /// Adds the next element by the vertices of its two features, global ids, each once. Two triangles may have
  /// vertices in common.
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
  /// Ends the adding of elements: called once in a slice.
  const Groups& find_groups();
  const Groups& groups() const { return groups_; }
  /// Ends the slice: labels of the groups, for the next one.
  void end(std::span<const Label> labels);

 private:
  // Of a key's two vertices, the smaller is the first.
  struct Entry {
    std::uint64_t key = 0;
    Label label;                      // of the last slice
    Index element = 0;                // in this slice: the first element that has the key
    bool reversed = false;            // the element has the key's second vertex on its first side
    std::array<bool, 2> is_vertex{};  // per vertex: that of an element of a vertex and a face
  };
  struct Map {
    std::vector<Entry> entries;
    std::vector<Index> slots;        // a hash table of entries, at most half full; kNoIndex: free
    Index& slot(std::uint64_t key);  // the key's slot, or the free one where it goes
    const Entry* find(std::uint64_t key) const;
    void make_room(std::size_t count);  // for so many more
    void clear();
  };
  struct Link {
    Index parent;
    bool reversed;
  };

  void fetch_keys();
  void add_key(std::uint64_t key, bool reversed, std::array<bool, 2> is_vertex);
  Link find_root(Index element);
  void join(Index a, Index b, bool reversed);
  void join_neighbors();
  void continue_neighbors();
  void list_groups();

  const Surfaces& surfaces_;
  Map now_, before_;
  std::vector<Link> links_;  // union-find over the elements
  std::vector<std::uint8_t> folded_;
  std::vector<std::pair<Index, Label>> found_;  // labels of the last slice, per element
  // Of the newest element; whether its sides are in reverse order.
  std::vector<std::pair<std::uint64_t, bool>> keys_;
  Groups groups_;
};

}  // namespace foldproof::inline internal
