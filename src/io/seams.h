/// Vertices that become one, and what that makes of a mesh.
#pragma once

#include <algorithm>
#include <bit>

#include "foldproof/io.h"

namespace foldproof::io {

/// Sets of two or more vertices that were alike in all comparisons so far. Sorts: a file could be made to
/// defeat a hash. Memory: in proportion to the vertices.
class AlikeVertices {
 public:
  /// All vertices are alike.
  explicit AlikeVertices(Index vertices);

  /// What `==` says of finite numbers, and an order of all: -0 is 0.
  static std::uint64_t key(double x) { return std::bit_cast<std::uint64_t>(x + 0.0); }

  /// Divides each set by the keys of its vertices. `key`: a vertex to an array of n numbers. Cost: a sort,
  /// where not all keys of a set are the same.
  template <std::size_t n, class Key>
  void compare(const Key& key) {
    std::vector<std::pair<std::array<std::uint64_t, n>, Index>> set;
    std::vector<Index> members, ends;
    for (std::size_t s = 0, begin = 0; s < ends_.size(); begin = ends_[s++]) {
      set.clear();
      for (std::size_t i = begin; i < ends_[s]; ++i) set.emplace_back(key(members_[i]), members_[i]);
      const auto is_first = [&](const auto& entry) { return entry.first == set.front().first; };
      if (!std::ranges::all_of(set, is_first)) std::ranges::sort(set);
      for (std::size_t from = 0, to = 0; from < set.size(); from = to) {
        for (to = from; to < set.size() && set[to].first == set[from].first; ++to) {
        }
        if (to - from < 2) continue;
        for (std::size_t i = from; i < to; ++i) members.push_back(set[i].second);
        ends.push_back(static_cast<Index>(members.size()));
      }
    }
    members_.swap(members);
    ends_.swap(ends);
  }

  /// Of every vertex, the first one that is like it: itself, if none is.
  std::vector<Index> first() const;

 private:
  Index vertices_;
  std::vector<Index> members_, ends_;  // sets, one after the other; ascending within a set
};

/// Faces, lines and points of a mesh, with a value for each of them, in this order; or with none.
struct MeshElements {
  std::vector<Triangle> faces;
  std::vector<Edge> lines;
  std::vector<Index> points;
  std::vector<Index> values;

  /// Corners become the vertices that these have been merged into. A line whose ends become one is a point
  /// then.
  void merge(std::span<const Index> merged);
};

/// Faces that have the same three vertices as earlier ones.
struct Layers {
  std::uint64_t sides = 0;   ///< Of the same surface as one of these.
  std::uint64_t others = 0;  ///< Of other surfaces than all of these.
  std::uint64_t turned = 0;  ///< Of `others`, those in the opposite order.
};
/// `surfaces`: a number for the surface of each face; empty: all are different.
Layers count_layers(std::span<const Triangle> faces, Index vertices, std::span<const Index> surfaces);
/// Adds what was merged, and faces that lie on others, to the notes of a motion: a sentence each.
void add_notes(const Layers& layers, MotionInfo& info);

/// A number for each name: the same where they are equal, or differ only in words for a side, such as front
/// and back.
std::vector<Index> surfaces_by_name(std::span<const std::string> names);

}  // namespace foldproof::io
