/// BVH traversal: which pairs of leaves come near each other, and which pairs of their features.
#pragma once

#include <array>

#include "bvh/kinetic_bvh.h"

namespace foldproof::inline internal {

/// Within one object a == b is the pair of a node, or of a leaf, with itself.
struct NodePair {
  NodeIndex a, b;
};
struct LeafPair {
  LeafIndex a, b;
};

/// The nodes of two objects, or of one (`within`), of which a node may be paired with itself.
struct NodePairs {
  std::span<const Hierarchy::Node> a, b;
  bool within;
  bool is_self(NodePair pair) const { return within && pair.a == pair.b; }
  bool are_leaves(NodePair pair) const { return a[pair.a].is_leaf() && b[pair.b].is_leaf(); }
  LeafPair leaves(NodePair pair) const {
    return {LeafIndex(a[pair.a].leaf_begin), LeafIndex(b[pair.b].leaf_begin)};
  }
};

/// The two children of a node that is no leaf.
inline NodePair children_of(std::span<const Hierarchy::Node> nodes, NodeIndex node) {
  return {NodeIndex(node + 1), NodeIndex(nodes[node].right)};
}

/// Pushes the pairs of children of a pair that are not two leaves. Of two nodes the one with more leaves is
/// split.
inline void push_children(const NodePairs& nodes, NodePair pair, std::vector<NodePair>& stack) {
  if (nodes.is_self(pair)) {
    const auto [left, right] = children_of(nodes.a, pair.a);
    stack.push_back({left, right});
    stack.push_back({right, right});
    stack.push_back({left, left});
  } else if (leaf_count(nodes.a[pair.a]) >= leaf_count(nodes.b[pair.b])) {
    const auto [left, right] = children_of(nodes.a, pair.a);
    stack.push_back({right, pair.b});
    stack.push_back({left, pair.b});
  } else {
    const auto [left, right] = children_of(nodes.b, pair.b);
    stack.push_back({pair.a, right});
    stack.push_back({pair.a, left});
  }
}

/// Traverses pairs of nodes depth first until the stack is empty. `visit(NodePair)` returns whether to go on
/// with the pairs of their children; not for two leaves, which have none. Inline, because each instruction
/// set has a `visit` of its own.
template <class Visit>
[[gnu::always_inline]] inline void traverse_pairs(const NodePairs& nodes, std::vector<NodePair>& stack,
                                                  Visit visit) {
  while (!stack.empty()) {
    const NodePair pair = stack.back();
    stack.pop_back();
    if (visit(pair)) push_children(nodes, pair, stack);
  }
}

/// Two features, as indices in leaf order of their objects.
struct CandidatePair {
  FeatureIndex a, b;
};

/// What is traversed: one object with itself (a == b), or two objects.
struct Traversal {
  const KineticBvh* a;
  const KineticBvh* b;
  float margin;  ///< See separation_margin.
  NodePairs nodes() const { return {a->hierarchy->nodes(), b->hierarchy->nodes(), a == b}; }
};

/// Which pairs of nodes a traversal visits. Others are as good as separated for ever: they are in no front.
class NodeFilter {
 public:
  virtual ~NodeFilter() = default;
  virtual bool visits(NodePair nodes) const = 0;
};

/// What separates nodes whose boxes are not separated.
class NodeCertificate {
 public:
  virtual ~NodeCertificate() = default;
  virtual bool separates(NodePair nodes) = 0;
};

/// What a traversal finds; appended to. Reuse it: its buffers are kept.
struct TraversalResult {
  std::vector<LeafPair> leaf_pairs;
  std::vector<NodePair> subtree_pairs;  ///< Of find_subtree_pairs.
  std::uint64_t node_tests = 0;
  const NodeFilter* filter = nullptr;      ///< Null: all pairs are visited.
  NodeCertificate* certificate = nullptr;  ///< Null: only boxes separate nodes.
  /// If not null: receives the separated pairs at which the traversal stopped. Together with the pairs of
  /// leaves they cover all pairs below the starts, so the next step may start from them.
  std::vector<NodePair>* front = nullptr;
};

/// Depth-first traversal from the pair of nodes `start`, which are different or of two objects, down to nodes
/// with at most so many leaves. Appends the pairs of these nodes that are not separated to
/// `out.subtree_pairs`. `stack` is scratch.
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
void test_leaf_boxes(const Traversal& traversal, std::span<const LeafPair> leaves,
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
void find_candidates(const Traversal& traversal, LeafPair leaves, CandidateBuffer& out);

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
void prefetch_features(const Traversal& traversal, LeafPair leaves);

/// Adds the pairs of faces whose boxes are not separated, those with common vertices too, for static queries.
void find_face_pairs(const Traversal& traversal, LeafPair leaves, std::vector<CandidatePair>& out);

}  // namespace foldproof::inline internal
