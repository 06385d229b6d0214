/// Distinct triangles: copies, with the same vertices in the same order, are tested once, if a filter treats
/// them alike.
#pragma once

#include <memory>
#include <vector>

#include "foldproof/bvh.h"

namespace foldproof::inline internal {

/// A hierarchy with each ordered triple of vertices once per PairFilter::kind, and the copies of each
/// triangle.
///
/// What holds for a triangle holds for its copies, so queries skip them. Otherwise a polygon that repeats its
/// corners many times, cut into triangles, would make every pair of copies a candidate.
class DistinctTriangles {
 public:
  DistinctTriangles() = default;
  /// `kinds`: of each triangle; empty: all are alike. Cost: one pass; with copies also Hierarchy::from_parts.
  explicit DistinctTriangles(std::shared_ptr<const Hierarchy> all, std::span<const Index> kinds = {});

  /// Over the distinct triangles, in the order of their first copies; the user's hierarchy when there are no
  /// copies.
  const std::shared_ptr<const Hierarchy>& hierarchy() const { return hierarchy_; }
  bool has_copies() const { return !repeated_.empty(); }
  /// Distinct triangles that have several copies.
  std::span<const Index> repeated() const { return repeated_; }
  /// The user's triangles that are copies of a distinct one, itself included, ascending. Precondition:
  /// has_copies.
  std::span<const Index> copies(Index triangle) const {
    return std::span(ids_).subspan(first_[triangle], first_[triangle + 1] - first_[triangle]);
  }
  /// The user's node of a node of hierarchy(), with the same edges and vertices. Precondition: has_copies.
  Index node_id(Index node) const { return node_ids_[node]; }
  /// Replaces values per distinct triangle by values per triangle of the user. Precondition: has_copies.
  template <class T>
  void expand(std::vector<T>& values) const {
    std::vector<T> expanded(ids_.size());
    for (Index t = 0; t + 1 < first_.size(); ++t) {
      for (const Index id : copies(t)) expanded[id] = values[t];
    }
    values.swap(expanded);
  }

 private:
  bool find_copies(const Topology& topology, std::span<const Index> kinds);
  void drop_copies(const Hierarchy& all);

  std::shared_ptr<const Hierarchy> hierarchy_;
  std::vector<Index> first_, ids_;  // the copies of distinct triangle t: [first_[t], first_[t + 1]) of ids_
  std::vector<Index> repeated_;
  std::vector<Index> node_ids_;
};

/// Per object, which triangles are copies of others. Empty: there are none.
using DistinctObjects = std::span<const std::shared_ptr<const DistinctTriangles>>;

}  // namespace foldproof::inline internal
