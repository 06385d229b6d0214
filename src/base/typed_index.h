/// Indices that cannot be mistaken for each other.
#pragma once

#include <concepts>

#include "foldproof/base.h"

namespace foldproof::inline internal {

/// An index of one kind of thing. It is a number where one is asked for; a number, or an index of another
/// kind, becomes one only where that is written.
template <class Kind>
class TypedIndex {
 public:
  constexpr TypedIndex() = default;
  constexpr explicit TypedIndex(std::integral auto index) : index_(static_cast<Index>(index)) {}
  template <class Other>
  TypedIndex(TypedIndex<Other>) = delete;
  constexpr operator Index() const { return index_; }

 private:
  Index index_ = 0;
};

using NodeIndex = TypedIndex<struct NodeKind>;        ///< Of Hierarchy::nodes.
using LeafIndex = TypedIndex<struct LeafKind>;        ///< Of Hierarchy::leaves.
using SlotIndex = TypedIndex<struct SlotKind>;        ///< Of PatchSlots.
using FeatureIndex = TypedIndex<struct FeatureKind>;  ///< Of a vertex, an edge or a triangle in leaf order.

}  // namespace foldproof::inline internal
