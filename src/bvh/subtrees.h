/// A hierarchy cut into subtrees of about equal weight, which threads work on.
#pragma once

#include <algorithm>
#include <vector>

#include "base/typed_index.h"
#include "foldproof/bvh.h"

namespace foldproof::inline internal {

struct Subtrees {
  Subtrees(const Hierarchy& hierarchy, Index max_leaves_of_each) : max_leaves(max_leaves_of_each) {
    const auto nodes = hierarchy.nodes();
    for (Index node = 0; node < nodes.size();) {
      const Index leaves = nodes[node].leaf_end - nodes[node].leaf_begin;
      (leaves <= max_leaves ? roots : top).push_back(NodeIndex(node));
      node += leaves <= max_leaves ? 2 * leaves - 1 : 1;
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
