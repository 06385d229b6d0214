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
/// vertices, one of each side, is a key of the element. Elements are connected that have a key in common; so
/// are two neighboring vertices with one face. Memory of the last slice of time joins what continues: what
/// has a key in common with it, or else what has a key of which one vertex is in common and the other a
/// neighbor.
class Joiner {
 public:
  explicit Joiner(const Surfaces& surfaces) : surfaces_(surfaces) {}

  /// Begins a slice. What end() labeled in the last one is remembered.
  void begin(std::size_t element_count);
  /// Adds the next element by the vertices of its two features, global ids, each once. Two triangles may have
  /// vertices in common.
  void add(std::span<const Index> a, std::span<const Index> b);
  /// The same for a vertex and a face, a triangle's global id.
  void add(Index vertex, Index face, const Triangle& corners);
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
  // A key of an element, of two vertices. The smaller one is the row that the key is in.
  struct Key {
    Index larger;
    Index element;
    bool reversed;  // the larger vertex is on the element's first side
  };
  // The keys of a slice, by rows. Rows are in the order in which their vertices came first.
  struct Keys {
    std::vector<Index> row_of;  // per vertex; right if that row has the vertex
    std::vector<Index> rows;    // their vertices
    std::vector<Index> begin;   // of keys, per row
    std::vector<Key> keys;
    std::vector<Label> labels;           // per element, once the slice has ended
    Index find_row(Index vertex) const;  // kNoIndex if there is none
  };
  struct Link {
    Index parent;
    bool reversed;
  };
  struct Unsorted {
    Index row;
    Key key;
  };
  struct VertexFace {
    Index face, vertex, element;
  };

  void add_key(Index u, Index w, Index element);
  void sort_keys();
  Link find_root(Index element);
  void join(Index a, Index b, bool reversed);
  void join_rows();
  void join_neighbors();
  void continue_neighbors();
  void note(Index element, const Label& label);
  void list_groups();

  const Surfaces& surfaces_;
  Keys now_, before_;
  std::vector<Unsorted> unsorted_;
  std::vector<VertexFace> vertex_faces_;
  std::vector<Link> links_;  // union-find over the elements
  std::vector<std::uint8_t> folded_;
  std::vector<std::pair<Index, Label>> found_;  // labels of the last slice, per element
  // Per vertex: the first key of the row that has it, for this slice and the last one; right if it has it.
  std::vector<Index> first_now_, first_before_;
  Groups groups_;
};

}  // namespace foldproof::inline internal
