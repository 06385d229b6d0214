// What training proves and reports about a mesh.
#include <gmock/gmock.h>

#include "base/callers.h"
#include "bvh/meshes.h"
#include "foldproof/check.h"
#include "io/support.h"
#include "model/cylinder.h"

namespace foldproof::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::vector<Index> references_of(const Model& model) {
  std::vector<Index> references;
  for (Index k = 0; k < model.poses.size(); ++k) {
    if (model.poses[k].reference) references.push_back(k);
  }
  return references;
}

std::string bytes_of_file(const Model& model) {
  const ScratchDirectory files;
  EXPECT_TRUE(save_model(model, files.path("a.model")));
  return read_bytes(files.path("a.model"));
}

/// Collisions of the tube between two angles, with and without charts; with them in `work`.
std::array<StepResult, 2> with_and_without(const Model& model, double from_angle, double to_angle) {
  const auto x0 = bent(kTube.around, kTube.along, from_angle), x1 = bent(kTube.around, kTube.along, to_angle);
  const std::span<const double> from[] = {x0}, to[] = {x1};
  std::array<StepResult, 2> results;
  EXPECT_TRUE(StepChecker({model.object()}).check(from, to, {}, results[0]));
  EXPECT_TRUE(StepChecker({model.hierarchy()}).check(from, to, {.certificates = false}, results[1]));
  return results;
}

TEST(Train, ABendingTubeIsMostlyProven) {
  const auto motion = bending_tube(kTube, {0, 0.5, 1, 1.5, 2, 2.5, 3});
  const Model model = trained(*motion);
  EXPECT_THAT(references_of(model), ElementsAre(0, 1, 2, 3, 4, 5, 6));
  for (const TrainedPose& pose : model.poses) EXPECT_GT(pose.proven, 0.97) << pose.name;
  // In steps between poses that it was not trained on.
  for (const double angle : {0.25, 1.25, 2.75}) {
    const auto [on, off] = with_and_without(model, angle, angle + 0.05);
    EXPECT_LT(on.work.leaf_pairs, off.work.leaf_pairs / 20) << angle;
    EXPECT_TRUE(on.clean());
    EXPECT_TRUE(off.clean());
  }
}

TEST(Train, AModelDoesNotChangeTheAnswer) {
  const Model model = trained(*bending_tube(kTube, {0, 3, 6}));
  const auto [on, off] = with_and_without(model, 5, 8);
  EXPECT_GT(on.work.certificate_passes, 50u);
  ASSERT_GT(off.edge_edge.size(), 50u);
  ASSERT_EQ(on.edge_edge.size(), off.edge_edge.size());
  ASSERT_EQ(on.vertex_face.size(), off.vertex_face.size());
  for (std::size_t k = 0; k < on.edge_edge.size(); ++k) EXPECT_EQ(on.edge_edge[k].toi, off.edge_edge[k].toi);
}

TEST(Train, BuildsChartsInRandomPosesOfTheSubspace) {
  const auto motion = bending_tube(kTube, {-2.5, 0, 2.5});
  TrainSettings settings;
  const Model few = *train_model(all_poses(*motion), settings);
  settings.random_poses = 12;
  const Model more = *train_model(all_poses(*motion), settings);
  ASSERT_EQ(more.poses.size(), 15u);
  EXPECT_EQ(more.poses[3].name, "random pose 1 of 12");
  EXPECT_EQ(summarize(more).references, 15u);
  EXPECT_GT(more.chart_count(), few.chart_count());
  for (const TrainedPose& pose : more.poses) EXPECT_GT(pose.proven, 0.9) << pose.name;
  const auto [on, off] = with_and_without(more, 5, 8);
  ASSERT_GT(off.edge_edge.size(), 50u);
  EXPECT_EQ(on.edge_edge.size(), off.edge_edge.size());
  EXPECT_EQ(on.vertex_face.size(), off.vertex_face.size());
  EXPECT_EQ(bytes_of_file(more), bytes_of_file(*train_model(all_poses(*motion), settings)));
}

TEST(Train, TheModelIsTheSameForAnyNumberOfThreads) {
  if (!has_threads()) GTEST_SKIP() << "there is one thread";
  const auto motion = bending_tube(kTube, {0, 1, 2, 3});
  std::vector<std::string> models;
  TrainSettings settings{.references = 3};
  settings.learning.subspace = SubspaceKind::KernelPca;
  for (const int threads : {1, 2, 7}) {
    with_threads(threads, [&] {
      const Model model = trained(*motion, settings);
      EXPECT_TRUE(model.learned) << model.not_learned;
      models.push_back(bytes_of_file(model));
    });
  }
  EXPECT_EQ(models[0], models[1]);
  EXPECT_EQ(models[0], models[2]);
}

TEST(Train, ReferencesAreThePosesThatDifferMost) {
  const auto motion = bending_tube(kTube, {0, 0.1, 0.2, 6, 6.1, 2.9, 0});
  EXPECT_THAT(references_of(trained(*motion, {.references = 1})), ElementsAre(0));
  EXPECT_THAT(references_of(trained(*motion, {.references = 2})), ElementsAre(0, 4));
  EXPECT_THAT(references_of(trained(*motion, {.references = 3})), ElementsAre(0, 4, 5));
  // The last pose only repeats the first.
  const auto all_but_one = references_of(trained(*motion, {.references = 99}));
  EXPECT_EQ(all_but_one.size(), 7u);  // all poses are references: none is chosen
  const auto repeats = bending_tube(kTube, {0, 2, 0, 2, 0});
  EXPECT_THAT(references_of(trained(*repeats, {.references = 4})), ElementsAre(0, 1));
}

TEST(Train, UsesSixteenReferencesByDefault) {
  std::vector<double> angles;
  for (int k = 0; k < 20; ++k) angles.push_back(0.1 * k);
  const auto motion = bending_tube(kSmallTube, angles);
  EXPECT_EQ(references_of(trained(*motion)).size(), 16u);
  EXPECT_EQ(references_of(trained(*motion, {.references = 18})).size(), 18u);
}

TEST(Train, MovingAndTurningTheMeshChangesNoReference) {
  const auto turned = [](double angle, double far) {
    std::vector<double> x = bent(kTube.around, kTube.along, angle);
    for (std::size_t i = 0; i < x.size(); i += 3) {
      std::swap(x[i], x[i + 1]);
      x[i + 2] = -x[i + 2] + far;
    }
    return x;
  };
  const auto motion = memory_motion("tube", tube(kTube.around, kTube.along),
                                    {bent(kTube.around, kTube.along, 0), turned(0, 100), turned(1, 50)});
  EXPECT_THAT(references_of(trained(*motion, {.references = 2})), ElementsAre(0, 2));
}

TEST(Train, StaysWithinItsSize) {
  for (const std::vector<double>& angles : {std::vector<double>{2}, {0, 1, 2, 3}}) {
    const auto motion = bending_tube(kTube, angles);
    const double triangles = 2.0 * kTube.around * kTube.along;
    EXPECT_LT(static_cast<double>(bytes_of_file(trained(*motion)).size()),
              120 * triangles * static_cast<double>(angles.size()));
  }
}

TEST(Train, SpareChartsStandInWhereLargeOnesFail) {
  // Charts of the straight tube only, tested in a tube that is bent a lot.
  const Model model = trained(*bending_tube(kTube, {0}));
  const auto [on, off] = with_and_without(model, 2.5, 2.55);
  EXPECT_LT(on.work.leaf_pairs, off.work.leaf_pairs / 4);
}

TEST(Train, OddMeshesAreFine) {
  for (const Mesh& mesh : {odd(), soup(40, 1), cloth(1)}) {
    const auto motion = memory_motion("odd", mesh.topology, {mesh.positions});
    const Model model = trained(*motion);
    const ScratchDirectory files;
    ASSERT_TRUE(save_model(model, files.path("a.model")));
    const auto read = load_model(files.path("a.model"));
    EXPECT_TRUE(read) << read.error().line();
  }
  const Mesh mesh = odd();
  const Model model = trained(*memory_motion("odd", mesh.topology, {mesh.positions}));
  ASSERT_EQ(model.hard_leaves.size(), 1u);
  EXPECT_EQ(model.hard_leaves[0].obstacle, Obstacle::TooCurved);
  EXPECT_EQ(model.poses[0].proven, 0);
}

TEST(Train, DegeneratePosesAreFine) {
  const std::size_t size = 3 * std::size_t{tube(8, 6).vertex_count()};
  std::vector<double> flat = bent(8, 6, 0), huge = flat;
  for (std::size_t i = 2; i < size; i += 3) flat[i] = 0;
  for (double& x : huge) x *= 2e307;
  const auto motion =
      memory_motion("tube", tube(8, 6), {bent(8, 6, 0), std::vector<double>(size, 1.0), flat, huge});
  const Model model = trained(*motion);
  EXPECT_EQ(model.poses[1].proven, 0);
  EXPECT_EQ(model.poses[3].proven, model.poses[0].proven);
}

TEST(Train, ReportsProgress) {
  std::vector<double> parts;
  TrainHooks hooks;
  hooks.progress = [&](double part) { parts.push_back(part); };
  const auto motion = bending_tube(kSmallTube, {0, 1, 2, 3});
  ASSERT_TRUE(train_model(all_poses(*motion), {.references = 2}, hooks));
  EXPECT_EQ(parts.size(), 4u + 2u + 4u + 7u);  // the last: steps of learning
  EXPECT_TRUE(std::is_sorted(parts.begin(), parts.end()));
  EXPECT_EQ(parts.back(), 1);
}

std::string train_error(std::span<const TrainPose> poses, const TrainHooks& hooks = {}) {
  const auto model = train_model(poses, {}, hooks);
  return model ? "no error" : model.error().line();
}

TEST(Train, ErrorsNameWhatIsWrongWithPoses) {
  EXPECT_THAT(train_error({}), HasSubstr("poses: are none"));
  const auto one = bending_tube(kSmallTube, {0, 1}, "one.npz"), other = bending_tube(kTube, {0}, "two.obj");
  std::vector<TrainPose> poses = all_poses(*one);
  poses.push_back({other.get(), 0});
  EXPECT_EQ(
      train_error(poses),
      "two.obj: has other triangles than one.npz: 3072 over 1568 vertices instead of 192 over 108; train one "
      "model per mesh, with the same triangles in the same order in every pose");
  auto bad = bent(8, 6, 0);
  bad[7] = NAN;
  EXPECT_THAT(train_error(all_poses(*memory_motion("bad.npz", tube(8, 6), {bent(8, 6, 0), bad}))),
              HasSubstr("bad.npz, frame 1"));
  const std::atomic<bool> cancel = true;
  EXPECT_THAT(train_error(all_poses(*one), {.cancel = &cancel}), HasSubstr("training: was stopped"));
}

TEST(Train, RefusesMeshesThatWouldFillTheMemory) {
  std::vector<Triangle> fan;
  std::vector<double> x{0, 0, 0, 1, 0, 0};
  constexpr Index kBlades = 250000;
  for (Index k = 1; k <= kBlades; ++k) {
    fan.push_back({0, k, k + 1});
    x.insert(x.end(), {std::cos(1e-5 * k), std::sin(1e-5 * k), 0});
  }
  EXPECT_THAT(train_error(all_poses(*memory_motion("fan.obj", *Topology::make(kBlades + 2, fan), {x}))),
              HasSubstr("fan.obj: has vertices in which far too many triangles meet"));
  constexpr Index kLoose = 1100000;
  const auto loose = memory_motion("loose.obj", *Topology::make(kLoose, {{0, 1, 2}}),
                                   {std::vector<double>(3 * std::size_t{kLoose})});
  EXPECT_THAT(train_error(all_poses(*loose)),
              HasSubstr("loose.obj: has 1100000 vertices, but only 1 triangles"));
}

TEST(Summary, KappaOfAFlatSheetIsOne) {
  const Mesh mesh = cloth(12);
  const Model model = trained(*memory_motion("cloth", mesh.topology, {mesh.positions}));
  const ModelSummary summary = summarize(model);
  EXPECT_EQ(summary.references, 1u);
  EXPECT_EQ(summary.proven, 1);
  ASSERT_EQ(summary.levels[0].charts, 1u);
  EXPECT_EQ(summary.levels[0].charted, 1u);
  EXPECT_GE(summary.levels[0].kappa_max, 1);
  EXPECT_LT(summary.levels[0].kappa_max, 1 + 1e-12);
  Index nodes = 0;
  for (const ModelSummary::Level& level : summary.levels) nodes += level.slots;
  EXPECT_EQ(nodes, model.hierarchy()->nodes().size());
  EXPECT_GT(summary.pairs.slots, 10u);
}

TEST(Summary, KappaOfARoofIsThatOfItsSlope) {
  // Two squares at a right angle: each rises by 45 degrees towards the ridge.
  const auto roof = Topology::make(6, {{0, 1, 2}, {0, 2, 3}, {1, 4, 5}, {1, 5, 2}});
  const std::vector<double> x{-1, 0, 0, 0, 0, 1, 0, 1.4, 1, -1, 1.4, 0, 1, 0, 0, 1, 1.4, 0};
  const Model model = trained(*memory_motion("roof", *roof, {x}));
  const ModelSummary summary = summarize(model);
  ASSERT_EQ(summary.levels[0].charts, 1u);
  EXPECT_NEAR(summary.levels[0].kappa_max, std::sqrt(2), 1e-3);
}

}  // namespace
}  // namespace foldproof::testing
