/// Which labels occur where, so that a filter of labels can tell of whole nodes that their pairs are ignored.
#pragma once

#include <algorithm>
#include <map>
#include <vector>

#include "foldproof/bvh.h"

namespace foldproof::inline internal {

/// Sets of labels, each stored once, by number.
class LabelSets {
 public:
  /// The number of the set with these labels, which may repeat, in any order.
  Index add(std::vector<Index> labels) {
    std::ranges::sort(labels);
    labels.erase(std::unique(labels.begin(), labels.end()), labels.end());
    const auto [at, is_new] = numbers_.try_emplace(std::move(labels), static_cast<Index>(sets_.size()));
    if (is_new) sets_.push_back(at->first);
    return at->second;
  }
  const std::vector<Index>& operator[](Index set) const { return sets_[set]; }

 private:
  std::map<std::vector<Index>, Index> numbers_;
  std::vector<std::vector<Index>> sets_;
};

/// Calls visit(vertex id) for each corner of a leaf's triangles.
template <class Visit>
void for_each_corner(const Hierarchy& hierarchy, Index leaf, Visit visit) {
  for (Index k = hierarchy.leaves()[leaf].triangles; k < hierarchy.leaves()[leaf + 1].triangles; ++k) {
    for (const Index v : hierarchy.topology().triangles()[hierarchy.triangle_ids()[k]]) visit(v);
  }
}

/// The labels below each node of a hierarchy, or that they are many.
class NodeLabels {
 public:
  NodeLabels() = default;
  /// `add_labels(leaf, labels)` appends the labels of everything that a leaf owns.
  template <class AddLabels>
  NodeLabels(const Hierarchy& hierarchy, AddLabels add_labels) : set_of_node_(hierarchy.nodes().size()) {
    const auto nodes = hierarchy.nodes();
    std::vector<Index> labels;
    for (std::size_t n = nodes.size(); n-- > 0;) {
      labels.clear();
      bool many = false;
      if (nodes[n].is_leaf()) {
        add_labels(nodes[n].leaf_begin, labels);
      } else {
        for (const std::size_t child : {n + 1, std::size_t{nodes[n].right}}) {
          many |= set_of_node_[child] == kMany;
          if (!many) labels.insert(labels.end(), of(child).begin(), of(child).end());
        }
      }
      set_of_node_[n] = many ? kMany : sets_.add(labels);
      if (!many && of(n).size() > kMaxLabels) set_of_node_[n] = kMany;
    }
  }
  bool empty() const { return set_of_node_.empty(); }

  /// Whether `allows` a label below one node with one below the other, or there are too many to ask.
  template <class Allows>
  bool any(Index node_a, Index node_b, const Allows& allows) const {
    return any(*this, node_a, *this, node_b, allows);
  }
  template <class Allows>
  static bool any(const NodeLabels& a, Index node_a, const NodeLabels& b, Index node_b,
                  const Allows& allows) {
    if (a.set_of_node_[node_a] == kMany || b.set_of_node_[node_b] == kMany) return true;
    return any(a.of(node_a), b.of(node_b), allows);
  }
  template <class Allows>
  bool any_with(Index node, Index label, const Allows& allows) const {
    return set_of_node_[node] == kMany || any(of(node), std::span(&label, 1), allows);
  }
  template <class Allows>
  static bool any(std::span<const Index> a, std::span<const Index> b, const Allows& allows) {
    return std::ranges::any_of(
        a, [&](Index i) { return std::ranges::any_of(b, [&](Index k) { return allows(i, k); }); });
  }

 private:
  // A node with more is near the root, where a pair of nodes is rarely ignored.
  static constexpr std::size_t kMaxLabels = 16;
  static constexpr Index kMany = kNoIndex;
  std::span<const Index> of(std::size_t node) const { return sets_[set_of_node_[node]]; }

  LabelSets sets_;
  std::vector<Index> set_of_node_;
};

}  // namespace foldproof::inline internal
