/// Inside of StepChecker: what continuous and static queries share.
#pragma once

#include <chrono>

#include "query/scene.h"

namespace foldproof {

class Stopwatch {
 public:
  /// Milliseconds since the last call.
  double lap() {
    const auto now = std::chrono::steady_clock::now();
    const double ms = std::chrono::duration<double, std::milli>(now - last_).count();
    last_ = now;
    return ms;
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

inline Vec3 position(std::span<const double> x, Index vertex) {
  return Eigen::Map<const Vec3>(&x[3 * std::size_t{vertex}]);
}

/// Leaf pairs that one task tests, with what it finds. Reused.
struct Chunk {
  std::span<const LeafPairRef> pairs;
  /// Candidates stand pair after pair; `ends` says where each pair's end.
  CandidateBuffer candidates;
  struct Ends {
    std::size_t vertex_face, face_vertex, edge_edge;
  };
  std::vector<Ends> ends;
  std::vector<VertexFaceCollision> vertex_face;
  std::vector<EdgeEdgeCollision> edge_edge;
  std::vector<TriangleCrossing> crossings;
  std::uint64_t undecided = 0;
};

struct StepChecker::Impl {
  Scene scene;
  std::vector<Chunk> chunks;

  /// Hands out the scene's leaf pairs to chunks, a bounded number at a time, so that candidates take bounded
  /// memory. `round(count)` works on chunks [0, count).
  template <class Round>
  void in_rounds(Round round) {
    constexpr std::size_t kPairsPerChunk = 32, kChunksPerRound = 256;
    auto left = scene.leaf_pairs();
    while (!left.empty()) {
      std::size_t count = 0;
      for (; count < kChunksPerRound && !left.empty(); ++count) {
        if (count == chunks.size()) chunks.emplace_back();
        chunks[count].pairs = left.first(std::min(kPairsPerChunk, left.size()));
        left = left.subspan(chunks[count].pairs.size());
      }
      round(count);
    }
  }
};

}  // namespace foldproof
