// What crosses in a frame, from the frame before and the step between, against a static query of the frame.
#include <gtest/gtest.h>

#include <algorithm>

#include "base/rounds.h"
#include "contacts/scenes.h"
#include "oracle/data.h"

namespace foldproof {
namespace {

using namespace oracle;

// Every frame of an animation, against a checker of its own. Counts the crossings.
void expect_followed(const Animation& animation, const StepSettings& settings, std::size_t& crossings) {
  const Found found = contacts_of(animation, settings);
  StepSettings plain = settings;
  plain.certificates = false;
  StepChecker fresh(hierarchies(animation, 16));
  for (std::size_t k = 0; k < animation.poses.size(); ++k) {
    StaticResult expected, got;
    ASSERT_TRUE(fresh.check_static(spans(animation.poses[k]), plain, expected));
    got.crossings = found.crossings[k];
    ASSERT_EQ(got.crossings.size(), expected.crossings.size()) << "frame " << k;
    ASSERT_NO_FATAL_FAILURE(expect_same(got, expected)) << "frame " << k;
    crossings += expected.crossings.size();
  }
}

class GeneratedAnimations : public ::testing::TestWithParam<AnimationFamily> {};

TEST_P(GeneratedAnimations, CrossAsStaticQueriesSay) {
  Rng rng(11);
  const Animation animation = GetParam().make(rng);
  std::size_t crossings = 0;
  for (const double thickness : {0.02, 0.0}) {
    if (thickness == 0 && testing::kShare > 1) break;
    StepSettings settings;
    settings.thickness = thickness;
    ASSERT_NO_FATAL_FAILURE(expect_followed(animation, settings, crossings));
  }
  EXPECT_GT(crossings, 50u);
}

INSTANTIATE_TEST_SUITE_P(Families, GeneratedAnimations,
                         ::testing::ValuesIn(generated_animations().begin(), generated_animations().end()),
                         [](const auto& info) { return info.param.name; });

class MeshFamilies : public ::testing::TestWithParam<MeshFamily> {};

// Small animations of several meshes, on a grid too, where triangles touch, are degenerate and lie on each
// other.
TEST_P(MeshFamilies, CrossAsStaticQueriesSay) {
  Rng rng(12);
  std::size_t crossings = 0;
  for (int round = 0; round < testing::rounds(24); ++round) {
    Animation animation;
    const int objects = 1 + round % 3;
    std::vector<Mesh> meshes;
    for (int i = 0; i < objects; ++i) {
      meshes.push_back(GetParam().make(rng));
      animation.topologies.push_back(meshes.back().topology());
    }
    const double grid = round % 2 ? 0.125 : 0.0;
    for (int k = 0; k < 5; ++k) {
      auto& poses = animation.poses.emplace_back();
      for (const Mesh& mesh : meshes) poses.push_back(deformed(mesh.positions, 0.3, grid, rng));
    }
    StepSettings settings;
    settings.within = round % 5 != 4 || objects == 1;
    settings.between = round % 7 != 6;
    ASSERT_NO_FATAL_FAILURE(expect_followed(animation, settings, crossings)) << "round " << round;
  }
  EXPECT_GT(crossings, 50u);
}

INSTANTIATE_TEST_SUITE_P(Families, MeshFamilies,
                         ::testing::ValuesIn(mesh_families().begin(), mesh_families().end()),
                         [](const auto& info) { return info.param.name; });

class RealCrossings : public ::testing::TestWithParam<const char*> {};

TEST_P(RealCrossings, CrossAsStaticQueriesSay) {
  const auto data = data_directory();
  if (!data) GTEST_SKIP() << kNoData;
  const auto motion = open_real_motion(*data, GetParam());
  Animation animation;
  animation.topologies.push_back(motion->topology());
  const Index frames = all_frames() ? motion->frame_count() : std::min<Index>(8, motion->frame_count());
  for (Index k = 0; k < frames; ++k) {
    auto& pose = animation.poses.emplace_back(1);
    pose[0].resize(3 * std::size_t{motion->topology().vertex_count()});
    ASSERT_TRUE(motion->read_frame(k, pose[0]));
  }
  std::size_t crossings = 0;
  expect_followed(animation, {}, crossings);
}

INSTANTIATE_TEST_SUITE_P(Motions, RealCrossings,
                         ::testing::Values("samba", "rumba", "hand_anim", "rod_twist", "cloth_funnel"),
                         [](const auto& info) { return std::string(info.param); });

// Two spheres; the second moves along x.
class CutLists : public ::testing::Test {
 protected:
  const Mesh mesh = unit_sphere(6);
  const std::vector<Topology> topologies{mesh.topology(), mesh.topology()};
  std::vector<Pose> at(double x) const { return {mesh.positions, placed(mesh, 1, {x, 0, 0})}; }
  StepChecker checker{hierarchies({topologies, {at(3)}}, 16)};
  ContactFinder finder = ContactFinder::make({&topologies[0], &topologies[1]}).value();
  StaticResult first, last;
  StepResult step;
};

TEST_F(CutLists, WhatCrossesIsNotKnownUntilItIsSaid) {
  ASSERT_TRUE(checker.check_static(spans(at(3)), {}, first));
  finder.start(0, spans(at(3)), first);
  EXPECT_TRUE(finder.is_known());
  // All but one: what is left out may have joined the others.
  ASSERT_TRUE(checker.check(spans(at(3)), spans(at(1.5)), {}, step));
  StepSettings few;
  few.max_listed = std::max(step.vertex_face_count, step.edge_edge_count) - 1;
  ASSERT_TRUE(checker.check(spans(at(3)), spans(at(1.5)), few, step));
  ASSERT_GT(step.count(), 20u);
  finder.step(0, 1, spans(at(3)), spans(at(1.5)), step);
  EXPECT_FALSE(finder.is_known());
  EXPECT_TRUE(finder.crossings().empty());

  ASSERT_TRUE(checker.check(spans(at(1.5)), spans(at(1.4)), few, step));
  ASSERT_TRUE(checker.check_static(spans(at(1.4)), {}, last));
  finder.step(1, 2, spans(at(1.5)), spans(at(1.4)), step, &last);
  EXPECT_TRUE(finder.is_known());
  EXPECT_EQ(finder.crossings().size(), last.crossing_count);
  const auto contacts = finder.finish();
  ASSERT_EQ(contacts.size(), 1u);
  EXPECT_FALSE(contacts[0].healed);
  EXPECT_FALSE(contacts[0].from_start);
  ASSERT_EQ(contacts[0].frames.size(), 1u);
  EXPECT_EQ(contacts[0].frames[0].time, 2);
}

}  // namespace
}  // namespace foldproof
