/// Traversal: which pairs of leaves come near each other, and which pairs of their features.
#pragma once

#include "bvh/kinetic.h"

namespace foldproof {

struct NodePair {
  Index a, b;  ///< Nodes, or leaves once traversed. a == b within one object: the pair of a node with itself.
};

/// A part of the traversal of one object with itself (a == b) or of one object with another.
struct Traversal {
  const KineticTree* a;
  const KineticTree* b;
  float margin;  ///< See separation_margin.
};

/// What a traversal found. Reused: buffers are kept.
struct TraversalResult {
  std::vector<NodePair> leaf_pairs;
  std::uint64_t node_tests = 0;
  /// Where given: the pairs at which the traversal stopped, being apart, are appended. Together with the
  /// pairs of leaves they cover what was started from, so that the next step may start from them.
  std::vector<NodePair>* front = nullptr;
};

/// Pushes what lies below the pair of a node with itself, which is no leaf.
inline void push_below_self(std::span<const Hierarchy::Node> nodes, Index self,
                            std::vector<NodePair>& below) {
  const Index left = self + 1, right = nodes[self].right;
  below.push_back({left, right});
  below.push_back({right, right});
  below.push_back({left, left});
}

/// Pushes what lies below a pair of nodes that are not both leaves: the one with more leaves is split.
inline void push_below(std::span<const Hierarchy::Node> nodes_a, std::span<const Hierarchy::Node> nodes_b,
                       NodePair pair, std::vector<NodePair>& below) {
  const Hierarchy::Node &a = nodes_a[pair.a], &b = nodes_b[pair.b];
  if (a.leaf_end - a.leaf_begin >= b.leaf_end - b.leaf_begin) {
    below.push_back({a.right, pair.b});
    below.push_back({pair.a + 1, pair.b});
  } else {
    below.push_back({pair.a, b.right});
    below.push_back({pair.a, pair.b + 1});
  }
}

/// Replaces every pair in `front` by what lies one level below it; pairs that are apart vanish, pairs of
/// leaves go to `out`. Used to cut the traversal into tasks. `scratch` is overwritten.
void descend_once(const Traversal& traversal, std::vector<NodePair>& front, std::vector<NodePair>& scratch,
                  TraversalResult& out);

/// Follows pairs down to the leaves, one after the other. `stack` is scratch. Order of `out` depends on the
/// input only.
void traverse(const Traversal& traversal, std::span<const NodePair> starts, std::vector<NodePair>& stack,
              TraversalResult& out);
inline void traverse(const Traversal& traversal, NodePair start, std::vector<NodePair>& stack,
                     TraversalResult& out) {
  traverse(traversal, {&start, 1}, stack, out);
}

/// Whether the boxes of two leaves are apart: one byte per pair, 0 where they are not.
void test_leaves(const Traversal& traversal, std::span<const NodePair> leaves,
                 std::vector<std::uint8_t>& apart);

/// Feature pairs whose kinetic boxes are not apart, in leaf order of their objects. Vertex-face and edge-edge
/// pairs that share a vertex are left out.
struct CandidateBuffer {
  struct Pair {
    Index a, b;
  };
  std::vector<Pair> vertex_face;  ///< Vertex of a, face of b.
  std::vector<Pair>
      face_vertex;              ///< Face of a, vertex of b; empty within one object (all are in vertex_face).
  std::vector<Pair> edge_edge;  ///< Edge of a, edge of b.
  std::vector<Pair> face_face;  ///< Face of a, face of b; incident pairs included.
  void clear() {
    vertex_face.clear();
    face_face.clear();
    face_vertex.clear();
    edge_edge.clear();
  }
};

/// Tests vertices against faces and edges against edges of two leaves whose features have been filled, or of
/// a leaf with itself.
void find_candidates(const Traversal& traversal, NodePair leaves, CandidateBuffer& out);

/// When the boxes of two features are not apart: from `begin` to `end`, both included, in parts of the step.
struct Meeting {
  static constexpr int kParts = 254;
  std::uint8_t begin, end;
  static constexpr Meeting never() { return {1, 0}; }
  bool ever() const { return begin <= end; }
};

/// What `a` and `b` of a candidate are: see CandidateBuffer.
enum class FeaturePair : std::uint8_t { VertexFace, FaceVertex, EdgeEdge };

/// Meetings of candidates of one kind, one each.
void find_meetings(const Traversal& traversal, FeaturePair kind, std::span<const CandidateBuffer::Pair> pairs,
                   Meeting* out);

/// Asks the memory for what find_candidates will read.
void prefetch_features(const Traversal& traversal, NodePair leaves);

/// Tests faces against faces, for static queries.
void find_face_pairs(const Traversal& traversal, NodePair leaves, CandidateBuffer& out);

}  // namespace foldproof
