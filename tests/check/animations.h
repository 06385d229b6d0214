/// Animations: motions of a few objects, and a comparison of two checkers on the same steps.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <span>
#include <vector>

#include "foldproof/check.h"
#include "oracle/brute_force.h"
#include "oracle/meshes.h"

namespace foldproof::oracle {

using Pose = std::vector<double>;

/// Some objects and their poses over time.
struct Animation {
  std::vector<Topology> topologies;
  std::vector<std::vector<Pose>> poses;  ///< By time, then by object.
};

inline std::vector<std::span<const double>> spans(const std::vector<Pose>& pose) {
  return {pose.begin(), pose.end()};
}

inline void expect_same(const StepResult& with, const StepResult& without) {
  ASSERT_TRUE(same_collisions(with, without));
  ASSERT_EQ(with.earliest_toi, without.earliest_toi);
  ASSERT_EQ(with.tolerance, without.tolerance);
  ASSERT_EQ(with.work.undecided, without.work.undecided);
}

inline void expect_same(const StaticResult& with, const StaticResult& without) {
  ASSERT_TRUE(same_crossings(with, without));
}

inline bool same_counts(const Work& a, const Work& b) {
  return a.refits == b.refits && a.node_tests == b.node_tests && a.certificate_tests == b.certificate_tests &&
         a.certificate_passes == b.certificate_passes && a.leaf_pairs == b.leaf_pairs &&
         a.candidates_vf == b.candidates_vf && a.candidates_ee == b.candidates_ee &&
         a.undecided == b.undecided;
}

struct Sums {
  std::uint64_t steps = 0, covered = 0, others = 0, passes = 0, pairs_with = 0, pairs_without = 0, hits = 0;
  // A search that looks ahead finds pairs for later steps as well, so its pairs are not compared; nor are
  // those of a long step that certificates cut into other stretches, each of which has pairs of its own.
  void add(const Work& with, const Work& without, std::size_t found, Index search_steps = 1) {
    ++steps;
    covered += search_steps == 0;
    passes += with.certificate_passes;
    hits += found;
    const bool cut_otherwise = with.refits != without.refits;
    others += cut_otherwise;
    if (search_steps == 1 && !cut_otherwise) {
      pairs_with += with.leaf_pairs;
      pairs_without += without.leaf_pairs;
      EXPECT_LE(with.leaf_pairs, without.leaf_pairs);
    }
    EXPECT_EQ(without.certificate_tests, 0u);
    EXPECT_EQ(without.certificate_passes, 0u);
  }
};

inline std::vector<Object> hierarchies(const Animation& animation, Index leaf_triangles) {
  Scene scene;
  scene.topologies = animation.topologies;
  scene.x0 = animation.poses[0];
  return scene.hierarchies(leaf_triangles);
}

/// The checkers of a comparison: one that uses certificates, and one that does not.
class Comparison {
 public:
  explicit Comparison(const std::vector<Object>& objects) : Comparison(objects, objects) {}
  Comparison(const std::vector<Object>& trained, const std::vector<Object>& untrained)
      : with_(trained), without_(untrained) {}

  void step(const std::vector<Pose>& from, const std::vector<Pose>& to, StepSettings settings) {
    StepResult with, without;
    const auto x0 = spans(from), x1 = spans(to);
    settings.certificates = true;
    ASSERT_TRUE(with_.check(x0, x1, settings, with));
    settings.certificates = false;
    ASSERT_TRUE(without_.check(x0, x1, settings, without));
    ASSERT_NO_FATAL_FAILURE(expect_same(with, without));
    sums.add(with.work, without.work, with.vertex_face.size() + with.edge_edge.size(), with.search_steps);
  }

  void pose(const std::vector<Pose>& pose) {
    StaticResult with, without;
    const auto x = spans(pose);
    StepSettings settings;
    settings.explain = true;  // uses certificates also where they do not pay
    ASSERT_TRUE(with_.check_static(x, settings, with));
    settings.certificates = false;
    ASSERT_TRUE(without_.check_static(x, settings, without));
    ASSERT_NO_FATAL_FAILURE(expect_same(with, without));
    statics.add(with.work, without.work, with.crossings.size());
  }

  Sums sums, statics;

 private:
  StepChecker with_, without_;
};

/// Generated animations.
struct AnimationFamily {
  const char* name;
  Animation (*make)(Rng& rng);
};
inline void PrintTo(const AnimationFamily& family, std::ostream* out) { *out << family.name; }

std::span<const AnimationFamily> generated_animations();

}  // namespace foldproof::oracle
