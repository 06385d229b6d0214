// Balls of pairs of nodes against steps inside them, feature by feature; and a search that tries to break
// them.
#include <gtest/gtest.h>

#include "foldproof/ccd.h"
#include "reduced/pair_balls.h"
#include "reduced/shapes.h"

namespace foldproof::testing {
namespace {

// Everything that makes balls around the mean of one model.
struct Maker {
  explicit Maker(const ReducedMesh& mesh, double gap = 1e-7)
      : motion(mesh.motion()),
        slots(motion->hierarchy()),
        nodes(*motion, poses = {CentrePose(*motion, std::vector<double>(motion->modes(), 0.0))}),
        input{*motion, nodes, slots, poses, gap, 120'000},
        balls(input) {}

  std::shared_ptr<const ReducedMotion> motion;
  PatchSlots slots;
  std::vector<CentrePose> poses;
  NodeMotions nodes;
  BallInput input;
  PairBalls balls;
};

// Features of two nodes, or of one with itself.
class Features {
 public:
  Features(const ReducedMotion& motion, NodePairIds pair)
      : motion_(motion), h_(*motion.hierarchy()), pair_(pair) {}

  // Visits every vertex-face and edge-edge pair without a common vertex until the visitor says that it is
  // enough.
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
    double least = std::numeric_limits<double>::infinity();
    any([&](const std::array<Index, 4>& v, bool edges) {
      FourPoints x;
      for (int k = 0; k < 4; ++k) x[k] = at(v[k], p);
      least = std::min(least, (edges ? edge_edge_closest : vertex_face_closest)(x).distance);
      return false;
    });
    return least;
  }

 private:
  Vec3 at(Index place, std::span<const double> p) const {
    double x[3];
    motion_.vertex(place, p, x);
    return {x[0], x[1], x[2]};
  }
  const ReducedMotion& motion_;
  const Hierarchy& h_;
  NodePairIds pair_;
};

std::vector<double> scaled(std::vector<double> q, double by) {
  for (double& c : q) c *= by;
  return q;
}

// Climbs along the surface of the ball towards contact; true when the way from the centre there touches.
bool search_breaks(const ReducedMotion& motion, NodePairIds pair, double radius, int rounds,
                   std::mt19937& random) {
  const Features features(motion, pair);
  const std::vector<double> centre(motion.modes(), 0.0);
  auto best = random_direction(motion, random);
  double nearest = features.distance(scaled(best, radius));
  double stride = 1;
  for (int round = 0; round < rounds; ++round) {
    const auto step = random_direction(motion, random);
    std::vector<double> next(best.size());
    double square = 0;
    for (std::size_t k = 0; k < next.size(); ++k) {
      next[k] = best[k] + stride * step[k];
      square += std::pow(next[k] / motion.deviations()[k], 2);
    }
    next = scaled(next, 1 / std::sqrt(square));
    if (features.touch(centre, scaled(next, radius))) return true;
    const double distance = features.distance(scaled(next, radius));
    if (distance < nearest) {
      nearest = distance;
      best = next;
      stride = std::min(1.0, stride * 1.5);
    } else {
      stride = std::max(0.02, stride * 0.9);
    }
  }
  return false;
}

class Balls : public ::testing::TestWithParam<const char*> {
 protected:
  ReducedMesh mesh() const {
    return std::string(GetParam()) == "tube" ? bending_tube(12, 24, 0.5) : waving_cloth(14);
  }
};

// Pairs of nodes of all sizes: a random way down from the root with itself.
NodePairIds random_pair(const Hierarchy& h, std::mt19937& random) {
  const auto leaf_limit = std::size_t{1} << random() % 4;
  NodePairIds pair{0, 0};
  for (;;) {
    const auto &a = h.nodes()[pair[0]], &b = h.nodes()[pair[1]];
    const std::size_t size_a = a.leaf_end - a.leaf_begin, size_b = b.leaf_end - b.leaf_begin;
    if (std::max(size_a, size_b) <= leaf_limit) return pair;
    const Index larger = size_a >= size_b ? 0 : 1;
    const Index at = pair[larger], left = at + 1, right = h.nodes()[at].right;
    if (pair[0] == pair[1]) {
      const int way = static_cast<int>(random() % 3);
      pair = way == 0   ? NodePairIds{left, left}
             : way == 1 ? NodePairIds{right, right}
                        : NodePairIds{left, right};
    } else {
      pair[larger] = random() % 2 ? left : right;
    }
  }
}

TEST_P(Balls, StepsInsideAreFree) {
  Maker maker(mesh());
  std::mt19937 random(11);
  int with_ball = 0;
  for (int round = 0; round < 200; ++round) {
    const NodePairIds pair = random_pair(*maker.motion->hierarchy(), random);
    const double radius = maker.balls.radius(pair, 0, 1e6);
    if (radius == 0) continue;
    ++with_ball;
    // Balls of far pairs are too large to be shown wrong by any step.
    const Features features(*maker.motion, pair);
    for (int k = 0; k < 4; ++k) {
      const auto p0 = scaled(random_direction(*maker.motion, random), radius);
      const auto p1 = scaled(random_direction(*maker.motion, random), radius);
      ASSERT_FALSE(features.touch(p0, p1)) << pair[0] << " " << pair[1] << " radius " << radius;
    }
  }
  EXPECT_GT(with_ball, 100);
}

TEST_P(Balls, SearchBreaksNoneButFindsEachPlantedMistake) {
  Maker maker(mesh());
  std::mt19937 random(12);
  int tried = 0, broken_when_wrong = 0;
  for (int round = 0; round < 400 && tried < 12; ++round) {
    const NodePairIds pair = random_pair(*maker.motion->hierarchy(), random);
    const double radius = maker.balls.radius(pair, 0, 1e6);
    if (radius == 0 || radius > 8) continue;
    ++tried;
    EXPECT_FALSE(search_breaks(*maker.motion, pair, radius, 40, random)) << pair[0] << " " << pair[1];
    broken_when_wrong += search_breaks(*maker.motion, pair, 6 * radius, 40, random);
  }
  EXPECT_EQ(tried, 12);
  EXPECT_GE(broken_when_wrong, tried / 2);
}

// What is proven apart is proven farther apart than the gap.
TEST_P(Balls, KeepTheGap) {
  const double gap = 0.01;
  Maker maker(mesh(), gap), without(mesh());
  std::mt19937 random(13);
  int with_ball = 0;
  for (int round = 0; round < 200; ++round) {
    const NodePairIds pair = random_pair(*maker.motion->hierarchy(), random);
    const double radius = maker.balls.radius(pair, 0, 1e6);
    EXPECT_LE(radius, without.balls.radius(pair, 0, 1e6) * (1 + 1e-6));
    if (radius == 0) continue;
    ++with_ball;
    const Features features(*maker.motion, pair);
    for (int k = 0; k < 2; ++k) {
      const auto p = scaled(random_direction(*maker.motion, random), radius);
      ASSERT_GT(features.distance(p), gap) << pair[0] << " " << pair[1] << " radius " << radius;
    }
  }
  EXPECT_GT(with_ball, 50);
}

INSTANTIATE_TEST_SUITE_P(Models, Balls, ::testing::Values("tube", "cloth"),
                         [](const auto& info) { return std::string(info.param); });

}  // namespace
}  // namespace foldproof::testing
