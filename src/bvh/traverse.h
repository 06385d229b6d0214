/// BVH traversal: which pairs of leaves come near each other, and which pairs of their features.
#pragma once

#include <array>

#include "bvh/kinetic_bvh.h"

namespace foldproof::inline internal {

struct NodePair {
  Index a, b;  ///< Nodes, or leaves in results. a == b within one object: the pair of a node with itself.
};

/// Two features, as indices in leaf order of their objects.
struct CandidatePair {
  Index a, b;
};

/// What is traversed: one object with itself (a == b), or two objects.
struct Traversal {
  const KineticBvh* a;
  const KineticBvh* b;
  float margin;  ///< See separation_margin.
};

/// Which pairs of nodes a traversal visits. Others are as good as separated for ever: they are in no front.
class NodeFilter {
 public:
  virtual ~NodeFilter() = default;
  virtual bool visits(NodePair nodes) const = 0;
};

/// What a traversal finds; appended to. Reuse it: its buffers are kept.
struct TraversalResult {
  std::vector<NodePair> leaf_pairs;
  std::uint64_t node_tests = 0;
  const NodeFilter* filter = nullptr;  ///< Null: all pairs are visited.
  /// If not null: receives the separated pairs at which the traversal stopped. Together with the pairs of
  /// leaves they cover all pairs below the starts, so the next step may start from them.
  std::vector<NodePair>* front = nullptr;
};

inline Index leaf_count(const Hierarchy::Node& node) { return node.leaf_end - node.leaf_begin; }

/// Pushes the pairs of children of a node, not a leaf, that is paired with itself.
inline void push_self_children(std::span<const Hierarchy::Node> nodes, Index self,
                               std::vector<NodePair>& children) {
  const Index left = self + 1, right = nodes[self].right;
  children.push_back({left, right});
  children.push_back({right, right});
  children.push_back({left, left});
}

/// Pushes the children of a pair of nodes that are not both leaves. The node with more leaves is split.
inline void push_children(std::span<const Hierarchy::Node> nodes_a, std::span<const Hierarchy::Node> nodes_b,
                          NodePair pair, std::vector<NodePair>& children) {
  const Hierarchy::Node &a = nodes_a[pair.a], &b = nodes_b[pair.b];
  if (leaf_count(a) >= leaf_count(b)) {
    children.push_back({a.right, pair.b});
    children.push_back({pair.a + 1, pair.b});
  } else {
    children.push_back({pair.a, b.right});
    children.push_back({pair.a, pair.b + 1});
  }
}

/// Swaps a level of a descent with the next one. Both get the larger capacity, so that a later descent like
/// this one allocates nothing, whichever of the two it begins with.
template <class T>
void swap_levels(std::vector<T>& level, std::vector<T>& next) {
  level.swap(next);
  const std::size_t capacity = std::max(level.capacity(), next.capacity());
  level.reserve(capacity);
  next.reserve(capacity);
}

/// Depth-first traversal from the pair of nodes `start`, which are different or of two objects, down to nodes
/// with at most so many leaves. Appends the pairs of these nodes that are not separated to `out.leaf_pairs`,
/// as nodes. `stack` is scratch.
void find_subtree_pairs(const Traversal& traversal, NodePair start, Index max_leaves,
                        std::vector<NodePair>& stack, TraversalResult& out);

/// Depth-first traversal from each start in turn. `stack` is scratch. The order of `out` depends on the input
/// only.
void traverse(const Traversal& traversal, std::span<const NodePair> starts, std::vector<NodePair>& stack,
              TraversalResult& out);
inline void traverse(const Traversal& traversal, NodePair start, std::vector<NodePair>& stack,
                     TraversalResult& out) {
  traverse(traversal, {&start, 1}, stack, out);
}

/// Tests the boxes of pairs of leaves: one byte per pair, 1 where they are separated, else 0.
void test_leaves(const Traversal& traversal, std::span<const NodePair> leaves,
                 std::vector<std::uint8_t>& separated);

/// What `a` and `b` of a pair of features are.
enum class FeaturePair : std::uint8_t { VertexFace, FaceVertex, EdgeEdge };
inline constexpr std::array kFeaturePairs{FeaturePair::VertexFace, FeaturePair::FaceVertex,
                                          FeaturePair::EdgeEdge};

/// A value for each of them.
template <class T>
struct PerKind : std::array<T, kFeaturePairs.size()> {
  using Array = std::array<T, kFeaturePairs.size()>;
  T& operator[](FeaturePair kind) { return Array::operator[](static_cast<std::size_t>(kind)); }
  const T& operator[](FeaturePair kind) const { return Array::operator[](static_cast<std::size_t>(kind)); }
};

/// Feature pairs whose kinetic boxes are not separated, as indices in leaf order of their objects. Pairs that
/// share a vertex are left out. Within one object no pair is FaceVertex.
struct CandidateBuffer : PerKind<std::vector<CandidatePair>> {
  void clear() {
    for (auto& list : *this) list.clear();
  }
};

/// Whether vertices of a leaf of `vertices` are tested against the triangles of a leaf of `triangles`. Other
/// vertices than points need no test against a line or point: they have edges, and those who are on a line or
/// point are tested against their faces (docs/soundness.md, V2). Where faces name a vertex twice, their
/// vertices are tested against lines (KineticBvh::has_thin_faces).
inline bool tests_vertices(Element vertices, Element triangles) {
  return triangles == Element::Face || vertices == Element::Point;
}

/// Tests vertices against faces and edges against edges of two leaves whose features have been filled, or of
/// a leaf with itself.
void find_candidates(const Traversal& traversal, NodePair leaves, CandidateBuffer& out);

/// When the boxes of two features are not separated: [begin, end] in units of 1 / kUnits of the motion.
struct ContactInterval {
  static constexpr int kUnits = 254;
  std::uint8_t begin, end;
  static constexpr ContactInterval none() { return {1, 0}; }
  bool is_empty() const { return begin > end; }
};

/// Computes the contact interval of each of the candidates, which are of one kind.
void find_contact_intervals(const Traversal& traversal, FeaturePair kind,
                            std::span<const CandidatePair> pairs, ContactInterval* out);

/// Prefetches what find_candidates will read.
void prefetch_features(const Traversal& traversal, NodePair leaves);

/// Adds the pairs of faces whose boxes are not separated, those with common vertices too, for static queries.
void find_face_pairs(const Traversal& traversal, NodePair leaves, std::vector<CandidatePair>& out);

}  // namespace foldproof::inline internal
