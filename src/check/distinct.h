/// Triangles that name the same vertices in the same order are looked at once.
#pragma once

#include <memory>
#include <vector>

#include "foldproof/bvh.h"

namespace foldproof {

/// A hierarchy over each ordered triple of vertices once, and the triangles that each stands for.
///
/// Whatever holds of a triangle holds of its copies, so queries need not look at them: a polygon that goes
/// round its corners many times, cut into triangles, would make every pair of them a query.
class DistinctTriangles {
 public:
  DistinctTriangles() = default;
  /// Cost: one pass, and for a hierarchy with copies what Hierarchy::from_parts takes.
  explicit DistinctTriangles(std::shared_ptr<const Hierarchy> all);

  /// Over the triangles that are left, numbered by their first copies; all of them when there are no copies.
  const std::shared_ptr<const Hierarchy>& hierarchy() const { return hierarchy_; }
  /// Whether any triangle stands for several.
  bool has_copies() const { return !repeated_.empty(); }
  /// Triangles of `hierarchy` that stand for several.
  std::span<const Index> repeated() const { return repeated_; }
  /// The user's triangles that one of `hierarchy` stands for, ascending. Precondition: has_copies.
  std::span<const Index> copies(Index triangle) const {
    return std::span(ids_).subspan(first_[triangle], first_[triangle + 1] - first_[triangle]);
  }
  /// Per triangle of the user, what is said of the one that stands for it. Precondition: has_copies.
  template <class T>
  void spread(std::vector<T>& of_distinct) const {
    std::vector<T> of_all(ids_.size());
    for (Index t = 0; t + 1 < first_.size(); ++t) {
      for (const Index id : copies(t)) of_all[id] = of_distinct[t];
    }
    of_distinct.swap(of_all);
  }

 private:
  bool find_copies(std::span<const Triangle> triangles, Index vertex_count);
  void drop_copies(const Hierarchy& all);

  std::shared_ptr<const Hierarchy> hierarchy_;
  std::vector<Index> first_, ids_;  // of each distinct triangle, [first_[t], first_[t + 1]) of ids_
  std::vector<Index> repeated_;
};

}  // namespace foldproof
