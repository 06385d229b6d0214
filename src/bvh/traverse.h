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
  /// Where given: the pairs at which the traversal stopped, apart or leaves, are appended. Together they
  /// cover what was started from, so that the next step may start from them.
  std::vector<NodePair>* front = nullptr;
};

/// Replaces every pair in `front` by what lies one level below it; pairs that are apart vanish, pairs of
/// leaves go to `out`. Used to cut the traversal into tasks. `scratch` is overwritten.
void descend_once(const Traversal& traversal, std::vector<NodePair>& front, std::vector<NodePair>& scratch,
                  TraversalResult& out);

/// Follows a pair down to the leaves. `stack` is scratch. Order of `out` depends on the input only.
void traverse(const Traversal& traversal, NodePair start, std::vector<NodePair>& stack, TraversalResult& out);

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

/// Tests faces against faces, for static queries.
void find_face_pairs(const Traversal& traversal, NodePair leaves, CandidateBuffer& out);

}  // namespace foldproof
