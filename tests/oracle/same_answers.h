/// Whether two answers are the same.
#pragma once

#include <algorithm>
#include <array>
#include <cstring>
#include <vector>

#include "foldproof/check.h"

namespace foldproof::oracle {

/// Ids in lexicographic order, for sorting and comparing answers.
using PairKey = std::array<Index, 6>;
inline PairKey key(const VertexFaceCollision& p) {
  return {p.vertex_object, p.vertex, p.face_object, p.face, 0, 0};
}
inline PairKey key(const EdgeEdgeCollision& p) {
  return {p.object_a, p.a[0], p.a[1], p.object_b, p.b[0], p.b[1]};
}
inline PairKey key(const TriangleCrossing& p) {
  return {p.object_a, p.triangle_a, p.object_b, p.triangle_b, 0, 0};
}

/// The same pair with the same answer and bit-equal times.
template <class Collision>
bool same_collision(const Collision& a, const Collision& b) {
  return key(a) == key(b) && a.answer == b.answer && std::memcmp(&a.toi, &b.toi, sizeof a.toi) == 0;
}

/// The same collisions in the same order.
inline bool same_collisions(const StepResult& a, const StepResult& b) {
  return std::ranges::equal(a.vertex_face, b.vertex_face, same_collision<VertexFaceCollision>) &&
         std::ranges::equal(a.edge_edge, b.edge_edge, same_collision<EdgeEdgeCollision>);
}

inline bool same_crossings(const StaticResult& a, const StaticResult& b) {
  return std::ranges::equal(a.crossings, b.crossings,
                            [](const auto& p, const auto& q) { return key(p) == key(q); });
}

}  // namespace foldproof::oracle
