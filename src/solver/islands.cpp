// Step sizes by islands (V3b): what collides on the way, directly or by others, goes one share of it.
#include <algorithm>
#include <numeric>

#include "base/plain_arithmetic.h"
#include "base/try.h"
#include "solver/contact_checker.h"

namespace foldproof {
namespace {

/// After so many rounds all that still moves goes one share.
constexpr int kManyRounds = 32;

/// Sets of vertices, each with its share of the step, that only grow.
class Islands {
 public:
  explicit Islands(std::size_t vertices) : parent_(vertices), share_(vertices, 1.0) {
    std::iota(parent_.begin(), parent_.end(), Index{0});
  }

  double share(Index vertex) { return share_[root(vertex)]; }

  /// The island of all of them has at most this share, and at most what each had.
  void join(std::span<const Index> vertices, double share) {
    const Index into = root(vertices[0]);
    for (const Index v : vertices) {
      const Index from = root(v);
      share = std::min(share, share_[from]);
      parent_[from] = into;
    }
    share_[into] = share;
  }

 private:
  Index root(Index v) {
    for (; parent_[v] != v; v = parent_[v]) parent_[v] = parent_[parent_[v]];
    return v;
  }

  std::vector<Index> parent_;
  std::vector<double> share_;  ///< Of roots.
};

/// The share of the vertices of a pair that collides at `time` of the steps of these shares. If they differ,
/// the least of them: if all go it, the pair is free until there, or it has collided before. Else it is
/// `before` of the way to the collision.
double share_of_pair(std::span<const Index> vertices, double time, std::span<const double> shares,
                     double before) {
  double least = 1, most = 0;
  for (const Index v : vertices) {
    least = std::min(least, shares[v]);
    most = std::max(most, shares[v]);
  }
  return least == most ? least * before * time : least;
}

}  // namespace

Result<void> ContactChecker::collision_free_step_sizes(std::span<const double> x0, std::span<const double> x1,
                                                       std::vector<double>& shares, double min_distance) {
  const PlainArithmetic plain;
  Impl& m = *impl_;
  m.start_call();
  FOLDPROOF_TRY(m.check_rescaling());
  FOLDPROOF_TRY(m.check_positions(x0, x1));
  StepSettings all = m.step_settings(min_distance);
  all.earliest_only = false;
  all.max_listed = ~std::uint64_t{0};
  const double before = m.settings.conservative_rescaling;
  const auto triangles = m.mesh->hierarchy()->topology().triangles();
  Islands islands(m.mesh->vertex_count());
  shares.assign(m.mesh->vertex_count(), 1.0);
  m.end_positions.assign(x1.begin(), x1.end());
  const auto at_rest = [&](Index v) { return position(x0, v) == position(x1, v); };
  for (int round = 0; round < 2 * kManyRounds; ++round) {
    FOLDPROOF_TRY(m.find_contacts(x0, m.end_positions, all, {min_distance}));
    bool moves = false;  // something that collides
    const auto join = [&](std::array<Index, 4> vertices, double time) {
      // What rests joins nothing: others may stop at it, too.
      const auto end = std::remove_if(vertices.begin(), vertices.end(), at_rest);
      if (end == vertices.begin()) return;
      const std::span<const Index> moving(vertices.begin(), end);
      for (const Index v : moving) moves = moves || shares[v] > 0;
      islands.join(moving, share_of_pair(moving, time, shares, before));
    };
    for (const VertexFaceCollision& hit : m.step.vertex_face) {
      const Triangle& face = triangles[hit.face];
      join({hit.vertex, face[0], face[1], face[2]}, hit.toi);
    }
    for (const EdgeEdgeCollision& hit : m.step.edge_edge)
      join({hit.a[0], hit.a[1], hit.b[0], hit.b[1]}, hit.toi);
    if (!moves) return {};
    for (Index v = 0; v < shares.size(); ++v) shares[v] = islands.share(v);
    if (round == kManyRounds) {
      double least = 1;
      for (const double share : shares) least = share > 0 ? std::min(least, share) : least;
      for (Index v = 0; v < shares.size(); ++v) {
        if (shares[v] > 0) islands.join({&v, 1}, shares[v] = least);
      }
    }
    step_towards(x0, x1, shares, m.end_positions);
  }
  shares.assign(shares.size(), 0.0);
  return {};
}

void step_towards(std::span<const double> x0, std::span<const double> x1, std::span<const double> shares,
                  std::span<double> out) {
  for (std::size_t v = 0; v < shares.size(); ++v)
    step_towards(x0.subspan(3 * v, 3), x1.subspan(3 * v, 3), shares[v], out.subspan(3 * v, 3));
}

}  // namespace foldproof
