/// Pairs of nodes feature by feature, and a search for contact within a ball.
#pragma once

#include "foldproof/ccd.h"
#include "reduced/pair_balls.h"
#include "reduced/shapes.h"

namespace foldproof::testing {

// All that balls around the mean of one model are computed from.
struct BallSetup {
  explicit BallSetup(const ReducedMesh& mesh, double gap = 1e-7) : BallSetup(mesh.motion(), gap) {}
  explicit BallSetup(std::shared_ptr<const ReducedMotion> m, double gap = 1e-7)
      : motion(std::move(m)),
        slots(motion->hierarchy()),
        nodes(*motion, poses = {CenterPose(*motion, std::vector<double>(motion->modes(), 0.0))}),
        input{*motion, nodes, slots, poses, gap, 120'000},
        balls(input) {}

  std::shared_ptr<const ReducedMotion> motion;
  PatchSlots slots;
  std::vector<CenterPose> poses;
  NodeMotions nodes;
  BallInput input;
  PairBalls balls;
};

// Features of two nodes, or of one with itself.
class Features {
 public:
  Features(const ReducedMotion& motion, NodePairIds pair)
      : motion_(motion), h_(*motion.hierarchy()), pair_(pair) {}

  // Visits vertex-face and edge-edge pairs without a common vertex until the visitor returns true.
  template <class Visit>
  bool any(Visit visit) const {
    for (const auto& [a, b] : {std::pair(pair_[0], pair_[1]), std::pair(pair_[1], pair_[0])}) {
      const auto& from = h_.nodes()[a];
      const auto& to = h_.nodes()[b];
      for (Index v = h_.leaves()[from.leaf_begin].vertices; v < h_.leaves()[from.leaf_end].vertices; ++v) {
        for (Index t = h_.leaves()[to.leaf_begin].triangles; t < h_.leaves()[to.leaf_end].triangles; ++t) {
          const Triangle& f = h_.triangles()[t];
          if (v != f[0] && v != f[1] && v != f[2] && visit({v, f[0], f[1], f[2]}, false)) return true;
        }
      }
      for (Index e = h_.leaves()[from.leaf_begin].edges; e < h_.leaves()[from.leaf_end].edges; ++e) {
        for (Index g = h_.leaves()[to.leaf_begin].edges; g < h_.leaves()[to.leaf_end].edges; ++g) {
          const Edge &x = h_.edges()[e], &y = h_.edges()[g];
          if (x[0] == y[0] || x[0] == y[1] || x[1] == y[0] || x[1] == y[1]) continue;
          if (visit({x[0], x[1], y[0], y[1]}, true)) return true;
        }
      }
      if (pair_[0] == pair_[1]) break;
    }
    return false;
  }

  bool touch(std::span<const double> p0, std::span<const double> p1) const {
    return any([&](const std::array<Index, 4>& v, bool edges) {
      FourPoints x0, x1;
      for (int k = 0; k < 4; ++k) {
        x0[k] = at(v[k], p0);
        x1[k] = at(v[k], p1);
      }
      return (edges ? edge_edge_ccd : vertex_face_ccd)(x0, x1, {}).answer != Answer::Separated;
    });
  }

  double distance(std::span<const double> p) const {
    double smallest = std::numeric_limits<double>::infinity();
    any([&](const std::array<Index, 4>& v, bool edges) {
      FourPoints x;
      for (int k = 0; k < 4; ++k) x[k] = at(v[k], p);
      smallest = std::min(smallest, (edges ? edge_edge_closest : vertex_face_closest)(x).distance);
      return false;
    });
    return smallest;
  }

 private:
  Vec3 at(Index v, std::span<const double> p) const {
    double x[3];
    motion_.vertex(v, p, x);
    return {x[0], x[1], x[2]};
  }
  const ReducedMotion& motion_;
  const Hierarchy& h_;
  NodePairIds pair_;
};

inline std::vector<double> scaled(std::vector<double> q, double factor) {
  for (double& c : q) c *= factor;
  return q;
}

// Moves on the surface of the ball towards contact. True when a step from the center to the surface touches.
inline bool search_finds_contact(const ReducedMotion& motion, NodePairIds pair, double radius, int rounds,
                                 std::mt19937& random) {
  const Features features(motion, pair);
  const std::vector<double> center(motion.modes(), 0.0);
  auto best = random_direction(motion, random);
  double nearest = features.distance(scaled(best, radius));
  double step_size = 1;
  for (int round = 0; round < rounds; ++round) {
    const auto step = random_direction(motion, random);
    std::vector<double> next(best.size());
    double square = 0;
    for (std::size_t k = 0; k < next.size(); ++k) {
      next[k] = best[k] + step_size * step[k];
      square += std::pow(next[k] / motion.deviations()[k], 2);
    }
    next = scaled(next, 1 / std::sqrt(square));
    if (features.touch(center, scaled(next, radius))) return true;
    const double distance = features.distance(scaled(next, radius));
    if (distance < nearest) {
      nearest = distance;
      best = next;
      step_size = std::min(1.0, step_size * 1.5);
    } else {
      step_size = std::max(0.02, step_size * 0.9);
    }
  }
  return false;
}

}  // namespace foldproof::testing
