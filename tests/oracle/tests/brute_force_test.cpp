// Brute force leaves out pairs whose swept boxes are apart. None of them collides.
#include "oracle/brute_force.h"

#include <gtest/gtest.h>

namespace foldproof::oracle {
namespace {

// Triangles with vertices of their own, somewhere in a box, that move by less than its size.
Scene scattered(int triangles, double scale, Rng& rng) {
  Scene scene;
  for (int object = 0; object < 2; ++object) {
    std::vector<Triangle> faces;
    auto& x0 = scene.x0.emplace_back();
    auto& x1 = scene.x1.emplace_back();
    for (Index i = 0; i < Index(triangles); ++i) {
      faces.push_back({3 * i, 3 * i + 1, 3 * i + 2});
      std::array<double, 3> center, way;
      for (double& c : center) c = uniform(rng, 0, 3);
      for (double& w : way) w = uniform(rng, -0.5, 0.5);
      for (std::size_t k = 0; k < 9; ++k) {
        x0.push_back(scale * (center[k % 3] + uniform(rng, -0.5, 0.5)));
        x1.push_back(x0.back() + scale * way[k % 3]);
      }
    }
    scene.topologies.push_back(Topology::make(Index(3 * triangles), std::move(faces)).value());
  }
  return scene;
}

TEST(BruteForce, LeavesOutNoPairThatCollides) {
  Rng rng(5);
  std::size_t collisions = 0, pairs = 0;
  for (const double scale : {0x1p-400, 1.0, 0x1p400}) {
    for (const double distance : {0.0, 0.05, 0.5}) {
      const Scene scene = scattered(12, scale, rng);
      StepSettings settings;
      settings.within = false;
      settings.thickness = scale * distance;
      const double tolerance = scale * 0x1p-20;
      CcdSettings ccd;
      ccd.thickness = settings.thickness;
      ccd.tolerance = tolerance;
      const StepResult found = brute_force_step(scene, settings, tolerance);
      std::size_t expected = 0;
      const auto count = [&](const auto& pair, auto ask) {
        const PairPoints p = points_of(pair, scene);
        expected += ask(p.x0, p.x1, ccd).answer != Answer::Separated;
        ++pairs;
      };
      for (const auto& [a, b] : {std::pair<Index, Index>{0, 1}, {1, 0}}) {
        for (Index v = 0; v < 36; ++v) {
          for (Index f = 0; f < 12; ++f)
            count(VertexFaceCollision{a, v, b, f, 1, Answer::Separated}, vertex_face_ccd);
        }
      }
      for (const Edge& e : scene.topologies[0].edges()) {
        for (const Edge& g : scene.topologies[1].edges())
          count(EdgeEdgeCollision{0, e, 1, g, 1, Answer::Separated}, edge_edge_ccd);
      }
      EXPECT_EQ(found.count(), expected) << scale << ", " << distance;
      collisions += expected;
    }
  }
  EXPECT_GT(collisions, 500u);
  EXPECT_LT(collisions, pairs / 2);
}

}  // namespace
}  // namespace foldproof::oracle
