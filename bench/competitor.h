/// What is measured beside foldproof: other software that finds candidate pairs.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "foldproof/mesh.h"

namespace foldproof::bench {

/// Ids of two features: vertex and face, or two edges (places in Topology::edges()), the smaller first.
struct Pair {
  Index a, b;
  auto operator<=>(const Pair&) const = default;
};

/// Pairs of features without a common vertex whose swept boxes overlap. Each pair once, in any order.
struct Candidates {
  std::vector<Pair> vertex_face, edge_edge;
  void clear() {
    vertex_face.clear();
    edge_edge.clear();
  }
};

/// One algorithm of one library. To add one: a file in bench/peers that defines a Peer and a RegisterPeer.
class Peer {
 public:
  virtual ~Peer() = default;
  /// Called once per scene, not timed: whatever depends on the triangles alone. `topology` outlives the peer.
  virtual void prepare(const Topology& topology) = 0;
  /// Not timed: from now on features count as near whose boxes come within this distance; 0 until it is
  /// called.
  virtual void inflate(double distance) = 0;
  /// The timed part: from positions (vertex_count x 3, row-major) to candidates, on one thread. The answer
  /// belongs to the peer and lasts until the next step, so its buffers are reused.
  virtual const Candidates& step(std::span<const double> x0, std::span<const double> x1) = 0;
};

/// How to make a peer. Variants of one family share a column, where the fastest of them on each row stands.
struct PeerEntry {
  std::string family;  ///< The library, one column: "Embree".
  std::string name;    ///< The variant, which begins with the family: "Embree features Morton".
  std::string version;
  std::function<std::unique_ptr<Peer>()> make;
};

/// All peers that were compiled in, sorted by family and name.
std::vector<PeerEntry> peers();

/// A file-scope variable of this type adds a peer.
struct RegisterPeer {
  explicit RegisterPeer(PeerEntry entry);
};

}  // namespace foldproof::bench
