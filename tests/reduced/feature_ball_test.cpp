// Balls of leaves from their features: leaves that bend too far for a chart, folds, fans and needles.
#include <gtest/gtest.h>

#include "reduced/features.h"

namespace foldproof::testing {
namespace {

// A mesh whose mean is `rest`. Its modes bend, stretch and shake it, each by about `amount` of its size.
ReducedMesh shaken(Topology topology, std::vector<double> rest, double amount) {
  std::mt19937 random(17);
  std::normal_distribution<double> normal(0, 1);
  constexpr int kModes = 5;
  const auto count = static_cast<Eigen::Index>(rest.size());
  ReducedMesh mesh{std::move(topology), rest, {}};
  mesh.subspace.mean = Eigen::Map<const Eigen::VectorXd>(rest.data(), count);
  mesh.subspace.basis.resize(count, kModes);
  for (int k = 0; k < kModes; ++k) {
    Eigen::Matrix3d linear, bend;
    for (Eigen::Index i = 0; i < 9; ++i) {
      linear(i) = normal(random);
      bend(i) = normal(random);
    }
    for (Eigen::Index v = 0; v < count; v += 3) {
      const Eigen::Vector3d x = mesh.subspace.mean.segment<3>(v);
      Eigen::Vector3d own = linear * x + bend * x.cwiseAbs2();
      if (k == kModes - 1) own = 0.3 * Eigen::Vector3d(normal(random), normal(random), normal(random));
      mesh.subspace.basis.col(k).segment<3>(v) = own;
    }
    mesh.subspace.basis.col(k).normalize();
  }
  mesh.subspace.basis = mesh.subspace.basis.cast<float>().cast<double>().eval();
  mesh.subspace.deviations =
      Eigen::VectorXd::Constant(kModes, amount * std::sqrt(static_cast<double>(count) / 3));
  return mesh;
}

// A strip of two rows that rolls up by one and a half turns.
ReducedMesh roll() {
  std::vector<double> rest;
  for (int j = 0; j <= 2; ++j) {
    for (int i = 0; i <= 12; ++i) {
      const double angle = 3 * std::numbers::pi * i / 12, r = 1 - 0.04 * i;
      rest.insert(rest.end(), {r * std::cos(angle), 0.4 * j, r * std::sin(angle)});
    }
  }
  return shaken(grid(12, 2, false), rest, 0.05);
}

// A sheet folded sharply along every line, like a bellows.
ReducedMesh bellows() {
  std::vector<double> rest;
  for (int j = 0; j <= 3; ++j) {
    for (int i = 0; i <= 6; ++i) rest.insert(rest.end(), {0.1 * i, 0.5 * j, i % 2 ? 1.0 : 0.0});
  }
  return shaken(grid(6, 3, false), rest, 0.02);
}

// Triangles around one vertex that go up and down, like a paper filter; `narrow` needles among them.
ReducedMesh fan(bool narrow) {
  constexpr Index kSides = 12;
  std::vector<double> rest{0, 0, 0};
  std::vector<Triangle> triangles;
  for (Index i = 0; i < kSides; ++i) {
    const double angle = 2 * std::numbers::pi * (i - (narrow && i % 3 == 2 ? 0.9 : 0.0)) / kSides;
    rest.insert(rest.end(), {std::cos(angle), std::sin(angle), i % 2 ? 0.8 : -0.8});
    triangles.push_back({0, 1 + i, 1 + (i + 1) % kSides});
  }
  return shaken(Topology::make(kSides + 1, triangles).value(), rest, 0.05);
}

class FeatureBalls : public ::testing::TestWithParam<const char*> {
 protected:
  ReducedMesh mesh() const {
    const std::string name = GetParam();
    return name == "roll" ? roll() : name == "bellows" ? bellows() : fan(name == "needles");
  }
  // Every leaf with itself and every two, for several sizes of leaves; the largest holds the whole mesh.
  template <class Visit>
  void each_pair(Visit visit) const {
    for (const Index leaf_triangles : {4, 12, 64}) {
      const auto motion = mesh().motion(leaf_triangles);
      BallSetup setup(motion);
      std::vector<Index> leaves;
      for (Index n = 0; n < motion->hierarchy()->nodes().size(); ++n) {
        if (motion->hierarchy()->nodes()[n].is_leaf()) leaves.push_back(n);
      }
      for (std::size_t i = 0; i < leaves.size(); ++i) {
        for (std::size_t j = i; j < leaves.size(); ++j) visit(setup, NodePairIds{leaves[i], leaves[j]});
      }
    }
  }
};

TEST_P(FeatureBalls, ProveEveryPairOfLeavesThatDoesNotTouch) {
  each_pair([](BallSetup& setup, NodePairIds pair) {
    EXPECT_GT(setup.balls.feature_radius(pair, 0, 0, 1e6), 0.01) << pair[0] << " " << pair[1];
  });
}

TEST_P(FeatureBalls, StepsInsideAreFree) {
  std::mt19937 random(41);
  each_pair([&](BallSetup& setup, NodePairIds pair) {
    const double radius = setup.balls.feature_radius(pair, 0, 0, 1e6);
    const Features features(*setup.motion, pair);
    for (int k = 0; k < 6; ++k) {
      const auto p0 = scaled(random_direction(*setup.motion, random), radius);
      const auto p1 = scaled(random_direction(*setup.motion, random), radius);
      ASSERT_FALSE(features.touch(p0, p1)) << pair[0] << " " << pair[1] << " radius " << radius;
      ASSERT_GT(features.distance(p0), setup.input.gap);
    }
  });
}

TEST_P(FeatureBalls, SearchFindsContactOnlyWhereBallsAreTooLarge) {
  std::mt19937 random(42);
  int tried = 0, found_when_wrong = 0;
  each_pair([&](BallSetup& setup, NodePairIds pair) {
    const double radius = setup.balls.feature_radius(pair, 0, 0, 1e6);
    if (radius > 20 || tried > 30) return;
    ++tried;
    EXPECT_FALSE(search_finds_contact(*setup.motion, pair, radius, 60, random)) << pair[0] << " " << pair[1];
    found_when_wrong += search_finds_contact(*setup.motion, pair, 5 * radius, 60, random);
  });
  EXPECT_GT(tried, 3);
  EXPECT_GE(found_when_wrong, tried / 2);
}

// No pair of features is forgotten: the leaves' radius is the smallest of those of their pairs of features.
TEST_P(FeatureBalls, AreTheSmallestOverAllPairsOfFeatures) {
  each_pair([](BallSetup& setup, NodePairIds pair) {
    const CenterPose& pose = setup.poses[0];
    double smallest = 1e6;
    PlaneBall plane;
    Features(*setup.motion, pair).any([&](const std::array<Index, 4>& v, bool edges) {
      FourPoints x;
      for (std::size_t k = 0; k < 4; ++k) x[k] = pose.at(v[k]);
      const Vec3 direction = (edges ? edge_edge_closest : vertex_face_closest)(x).difference;
      const std::size_t first = edges ? 2 : 1;
      const TwoSets sets{std::span(v).first(first), std::span(v).subspan(first), direction};
      smallest = std::min(smallest, plane.radius(*setup.motion, pose, sets, setup.input.gap, 1e6));
      return false;
    });
    const double radius = setup.balls.feature_radius(pair, 0, 0, 1e6);
    EXPECT_GE(radius, smallest * (1 - 1e-9));
    EXPECT_LE(radius, smallest * 1.5 + 1e-9);  // boxes may beat a plane, rarely and not by much
  });
}

TEST_P(FeatureBalls, StopAtTheKnownAndAtTheLargestRadius) {
  each_pair([](BallSetup& setup, NodePairIds pair) {
    const double radius = setup.balls.feature_radius(pair, 0, 0, 1e6);
    EXPECT_EQ(setup.balls.feature_radius(pair, 0, 0, radius / 2), radius / 2);
    EXPECT_LE(setup.balls.feature_radius(pair, 0, 2 * radius, 1e6), 2 * radius);
  });
}

INSTANTIATE_TEST_SUITE_P(Meshes, FeatureBalls, ::testing::Values("roll", "bellows", "fan", "needles"),
                         [](const auto& info) { return std::string(info.param); });

}  // namespace
}  // namespace foldproof::testing
