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
  // A key of an element, of two vertices.
  struct Key {
    Index smaller, larger;
    Index element;  // the first that has it
    bool reversed;  // the larger vertex is on the element's first side
  };
  // The keys of a slice, each once, in the order in which they came.
  class Keys {
   public:
    void clear(std::size_t expected);
    std::span<const Key> all() const { return keys_; }
    const Key* find(Index u, Index w) const;   // null if there is none
    std::pair<Key, bool> add(const Key& key);  // the key that is there now, and whether it is new
    std::vector<Label> labels;                 // per element, once the slice has ended

   private:
    std::size_t slot_of(Index smaller, Index larger) const;
    void resize(std::size_t least);
    std::vector<Key> keys_;
    std::vector<Index> slots_;  // a hash table of their places; kNoIndex: free
    int shift_ = 0;
  };
  struct Link {
    Index parent;
    bool reversed;
  };
  // The last run that has keys of a vertex, and the element that has them.
  struct Seen {
    Index run = 0, element = 0;
  };
  struct VertexFace {
    Index face, vertex, element;
  };

  void add_apart(std::span<const Index> a, std::span<const Index> b, Index element);
  void add_key(Index u, Index w, Index element);
  Link find_root(Index element);
  void join(Index a, Index b, bool reversed);
  void join_neighbors();
  void continue_neighbors();
  void note(const Key& key, const Key& old, bool exchanged);
  void list_groups();

  const Surfaces& surfaces_;
  Keys now_, before_;
  std::vector<Index> run_of_;  // the first feature of the elements of the run
  Index run_ = 0;
  std::vector<Seen> seen_;  // per vertex
  std::vector<VertexFace> vertex_faces_;
  std::vector<Link> links_;  // union-find over the elements
  std::vector<std::uint8_t> folded_;
  std::vector<std::pair<Index, Label>> found_;  // labels of the last slice, per element
  std::vector<Index> place_;                    // per vertex: in vertex_faces_; right if that has it
  Groups groups_;
};

}  // namespace foldproof::inline internal
