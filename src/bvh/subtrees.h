/// A hierarchy cut into subtrees of about equal weight, which threads work on.
#pragma once

#include <algorithm>
#include <vector>

#include "base/typed_index.h"
#include "foldproof/bvh.h"

namespace foldproof::inline internal {

inline Index leaf_count(const Hierarchy::Node& node) { return node.leaf_end - node.leaf_begin; }
/// The node after all those below one, itself included.
inline NodeIndex end_below(std::span<const Hierarchy::Node> nodes, NodeIndex node) {
  return NodeIndex(node + 2 * leaf_count(nodes[node]) - 1);
}

/// The largest nodes with at most so many leaves.
struct Subtrees {
  Subtrees(const Hierarchy& hierarchy, Index max_leaves_of_each) : max_leaves(max_leaves_of_each) {
    const auto nodes = hierarchy.nodes();
    for (NodeIndex node; node < nodes.size();) {
      const bool is_root = leaf_count(nodes[node]) <= max_leaves;
      (is_root ? roots : top).push_back(node);
      node = is_root ? end_below(nodes, node) : NodeIndex(node + 1);
    }
  }
  /// The row of the first root that is not before a node.
  Index first_from(Index node) const {
    return static_cast<Index>(std::ranges::lower_bound(roots, node) - roots.begin());
  }

  Index max_leaves;
  std::vector<NodeIndex> roots;  ///< Ascending. Together they have all leaves.
  std::vector<NodeIndex> top;    ///< The nodes above them, ascending, so parents first.
};

}  // namespace foldproof::inline internal
