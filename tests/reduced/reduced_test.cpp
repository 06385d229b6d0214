// Reduced queries compared with StepChecker on the meshes reconstructed from the same coordinates: the same
// pairs with bit-equal times.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <cstdlib>
#include <string>

#include "certificate/library.h"
#include "check/same_collisions.h"
#include "foldproof/check.h"
#include "oracle/data.h"
#include "reduced/shapes.h"

namespace foldproof::testing {
namespace {

using ShapePointer = std::shared_ptr<const ReducedShape>;

ShapePointer shape_of(const ReducedMesh& mesh, const ReducedSettings& settings = {},
                      std::size_t extra_centers = 0) {
  const auto motion = mesh.motion();
  std::vector<ReducedCenter> centers{{std::vector<double>(motion->modes(), 0.0)}};
  std::mt19937 random(3);
  for (std::size_t k = 0; k < extra_centers; ++k) {
    centers.push_back({random_direction(*motion, random)});
    for (double& c : centers.back().p) c *= 1.5;
  }
  return std::make_shared<const ReducedShape>(ReducedShape::build(motion, centers, settings).value());
}

std::vector<ReducedChecker::Object> objects_of(const std::vector<ShapePointer>& shapes) {
  return {shapes.begin(), shapes.end()};
}

// Coordinates and poses of all objects at both ends of a step.
struct Step {
  std::vector<std::vector<double>> p0, p1;
  std::vector<ReducedPose> start, end;
};

Step random_step(const std::vector<ShapePointer>& shapes, double distance, double length,
                 std::mt19937& random) {
  Step step;
  for (const ShapePointer& shape : shapes) {
    auto p = random_direction(*shape->motion(), random), q = random_direction(*shape->motion(), random);
    for (std::size_t k = 0; k < p.size(); ++k) {
      p[k] *= distance;
      q[k] = p[k] + length * q[k];
    }
    step.p0.push_back(p);
    step.p1.push_back(q);
  }
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    step.start.push_back({step.p0[i]});
    step.end.push_back({step.p1[i]});
  }
  return step;
}

// Runs both checkers and returns the reduced one's answer.
StepResult expect_same_answer(const std::vector<ShapePointer>& shapes, const Step& step,
                              StepSettings settings) {
  ReducedChecker reduced(objects_of(shapes));
  StepResult answer, expected;
  const auto done = reduced.check(step.start, step.end, settings, answer);
  EXPECT_TRUE(done) << (done ? "" : done.error().line());
  std::vector<Object> objects;
  std::vector<std::vector<double>> x0, x1;
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    const ReducedMotion& motion = *shapes[i]->motion();
    objects.push_back(motion.hierarchy());
    for (auto* x : {&x0, &x1})
      x->emplace_back(3 * std::size_t{motion.hierarchy()->topology().vertex_count()});
    pose_vertices(motion, step.start[i], x0.back());
    pose_vertices(motion, step.end[i], x1.back());
  }
  settings.tolerance = answer.tolerance;
  StepChecker checker(objects);
  const std::vector<std::span<const double>> from(x0.begin(), x0.end()), to(x1.begin(), x1.end());
  EXPECT_TRUE(checker.check(from, to, settings, expected));
  EXPECT_EQ(answer.tolerance, expected.tolerance);
  expect_same_collisions(answer, expected);
  EXPECT_EQ(answer.earliest_toi, expected.earliest_toi);
  return answer;
}

std::size_t pairs_in(const StepResult& answer) { return answer.vertex_face.size() + answer.edge_edge.size(); }

TEST(ReducedChecker, AnswersAsStepCheckerWithinOneObject) {
  std::size_t hits = 0, clean = 0;
  std::uint64_t with_balls = 0, with_boxes = 0;
  for (const auto& mesh : {bending_tube(16, 40, 0.6), waving_cloth(16)}) {
    for (const std::size_t extra_centers : {0, 2}) {
      const std::vector<ShapePointer> shapes{shape_of(mesh, {}, extra_centers)};
      std::mt19937 random(21);
      for (const double distance : {0.5, 2.0, 6.0, 80.0}) {
        for (int round = 0; round < 4; ++round) {
          const Step step = random_step(shapes, distance, 0.4 * distance, random);
          const StepResult answer = expect_same_answer(shapes, step, {});
          hits += pairs_in(answer);
          clean += answer.clean();
          StepSettings without;
          without.certificates = false;
          StepResult by_boxes;
          ASSERT_TRUE(ReducedChecker(objects_of(shapes)).check(step.start, step.end, without, by_boxes));
          expect_same_collisions(by_boxes, answer);
          with_balls += answer.work.leaf_pairs;
          with_boxes += by_boxes.work.leaf_pairs;
        }
      }
    }
  }
  EXPECT_GT(hits, 0u);
  EXPECT_GT(clean, 0u);
  EXPECT_LT(with_balls, with_boxes);
}

TEST(ReducedChecker, TestsOnePairOfNodesInsideTheRootsBall) {
  const std::vector<ShapePointer> shapes{shape_of(bending_tube(32, 80, 0.4))};
  ASSERT_GT(shapes[0]->radius(0), 0.5);
  ASSERT_TRUE(shapes[0]->never_certified().empty());
  std::mt19937 random(22);
  const Step step = random_step(shapes, 0.4 * shapes[0]->radius(0), 0.1, random);
  StepSettings settings;
  settings.between = false;
  const StepResult answer = expect_same_answer(shapes, step, settings);
  EXPECT_EQ(answer.work.certificate_tests, 1u);
  EXPECT_EQ(answer.work.refits, 0u);
  EXPECT_EQ(answer.work.node_tests, 0u);
  EXPECT_EQ(answer.work.leaf_pairs, 0u);
}

// So far from all centers that no distance to them counts. Of the leaves that are never certified each pair
// is still listed once.
TEST(ReducedChecker, ListsPairsOnceFarFromAllCenters) {
  constexpr double kFar = 3e30;
  // Two triangles that cross all the time and move along x; a corner of the second moves down, too.
  ReducedMesh mesh{Topology::make(6, std::vector<Triangle>{{0, 1, 2}, {3, 4, 5}}).value(),
                   {-1, -1, 0, 1, -1, 0, 0, 1, 0, 0, 0, -1, 0.1, 0, 1, 0, 0.3, 1},
                   {}};
  mesh.subspace.mean = Eigen::Map<const Eigen::VectorXd>(mesh.rest.data(), 18);
  mesh.subspace.basis = Eigen::MatrixXd::Zero(18, 1);
  for (int v = 0; v < 6; ++v) mesh.subspace.basis(3 * v, 0) = 1 / kFar;
  mesh.subspace.basis(14, 0) = -2 / kFar;
  mesh.subspace.deviations = Eigen::VectorXd::Ones(1);
  const std::vector<ReducedCenter> centers{{{0.0}}, {{kFar}}};
  const std::vector<ShapePointer> shapes{
      std::make_shared<const ReducedShape>(ReducedShape::build(mesh.motion(), centers, {}).value())};
  ASSERT_FALSE(shapes[0]->never_certified().empty());
  Step step{{{0.0}}, {{kFar}}, {}, {}};
  step.start.push_back({step.p0[0]});
  step.end.push_back({step.p1[0]});
  EXPECT_GT(pairs_in(expect_same_answer(shapes, step, {})), 0u);
}

TEST(ReducedChecker, OverwritesEarlierAnswers) {
  ReducedChecker checker({});
  StepResult step;
  step.search_steps = 0;
  step.tolerance = 7;
  ASSERT_TRUE(checker.check({}, {}, {}, step));
  EXPECT_EQ(step.search_steps, 1);
  EXPECT_EQ(step.tolerance, 0);
}

TEST(ReducedChecker, AnswersWithThicknessUpToTheClearanceAndBeyond) {
  ReducedSettings settings;
  settings.clearance = 0.02;
  const std::vector<ShapePointer> shapes{shape_of(waving_cloth(16), settings)};
  std::mt19937 random(23);
  std::size_t hits = 0;
  for (const double thickness : {0.0, 0.01, 0.03}) {
    for (const double distance : {0.3, 1.0, 3.0, 5.0}) {
      const Step step = random_step(shapes, distance, 0.2, random);
      StepSettings query;
      query.thickness = thickness;
      const StepResult answer = expect_same_answer(shapes, step, query);
      hits += pairs_in(answer);
      EXPECT_EQ(answer.work.certificate_tests > 0, thickness < settings.clearance);
    }
  }
  EXPECT_GT(hits, 0u);
}

Eigen::Matrix3d random_rotation(std::mt19937& random) {
  std::normal_distribution<double> normal(0, 1);
  return Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random))
      .normalized()
      .toRotationMatrix();
}

TEST(ReducedChecker, AnswersForSeveralPlacedObjects) {
  const auto tube = shape_of(bending_tube(12, 30, 0.5)), cloth = shape_of(waving_cloth(12));
  const std::vector<ShapePointer> shapes{tube, cloth, cloth};
  std::mt19937 random(24);
  std::normal_distribution<double> normal(0, 1);
  std::size_t within = 0, between = 0;
  for (int round = 0; round < 12; ++round) {
    Step step = random_step(shapes, round % 3 + 0.5, 0.5, random);
    for (std::size_t i = 0; i < shapes.size(); ++i) {
      step.start[i].rotation = random_rotation(random);
      step.start[i].translation = Vec3(normal(random), normal(random), normal(random)) * 0.7;
      step.end[i].rotation = round % 2 ? random_rotation(random) : step.start[i].rotation;
      step.end[i].translation =
          step.start[i].translation + Vec3(normal(random), normal(random), normal(random)) * 0.2;
    }
    StepSettings settings;
    settings.earliest_only = round == 11;
    const StepResult answer = expect_same_answer(shapes, step, settings);
    for (const auto& c : answer.vertex_face) ++(c.vertex_object == c.face_object ? within : between);
    EXPECT_EQ(answer.work.certificate_tests > 0, round % 2 == 0) << "balls apply unless objects turn";
  }
  EXPECT_GT(within, 0u);
  EXPECT_GT(between, 0u);
}

TEST(ReducedChecker, RejectsChartsOfAnotherHierarchy) {
  const std::vector<ShapePointer> shapes{shape_of(waving_cloth(6))};
  std::mt19937 random(26);
  const Step step = random_step(shapes, 1, 0.1, random);
  const auto answers = [&](std::shared_ptr<const Hierarchy> hierarchy) {
    auto charts = std::make_shared<const ChartLibrary>(std::make_shared<const PatchSlots>(hierarchy));
    ReducedChecker checker({{shapes[0], charts}});
    StepResult answer;
    return checker.check(step.start, step.end, {}, answer).has_value();
  };
  EXPECT_TRUE(answers(shapes[0]->motion()->hierarchy()));
  EXPECT_FALSE(answers(waving_cloth(7).motion()->hierarchy()));
  EXPECT_FALSE(answers(std::make_shared<const Hierarchy>(*shapes[0]->motion()->hierarchy())));
}

TEST(ReducedChecker, RejectsInvalidInput) {
  const std::vector<ShapePointer> shapes{shape_of(waving_cloth(6))};
  ReducedChecker checker(objects_of(shapes));
  StepResult answer;
  std::mt19937 random(25);
  const Step good = random_step(shapes, 1, 0.1, random);
  ASSERT_TRUE(checker.check(good.start, good.end, {}, answer));
  const auto rejected = [&](const ReducedPose& pose) {
    const std::vector<ReducedPose> bad{pose};
    return !checker.check(good.start, bad, {}, answer) && !checker.check(bad, good.end, {}, answer);
  };
  ReducedPose pose = good.start[0];
  EXPECT_FALSE(rejected(pose));
  auto p = good.p0[0];
  p[0] = std::nan("");
  pose.p = p;
  EXPECT_TRUE(rejected(pose));
  p[0] = 1e300;
  EXPECT_TRUE(rejected(pose));
  pose = good.start[0];
  pose.p = pose.p.first(2);
  EXPECT_TRUE(rejected(pose));
  pose = good.start[0];
  pose.rotation(0, 0) = 1.1;
  EXPECT_TRUE(rejected(pose));
  for (int entry = 0; entry < 9; ++entry) {
    pose = good.start[0];
    pose.rotation(entry / 3, entry % 3) = std::nan("");
    EXPECT_TRUE(rejected(pose)) << entry;
  }
  pose = good.start[0];
  pose.translation[1] = INFINITY;
  EXPECT_TRUE(rejected(pose));
  EXPECT_FALSE(checker.check({}, {}, {}, answer));
  StepSettings settings;
  settings.thickness = -1;
  EXPECT_FALSE(checker.check(good.start, good.end, settings, answer));
}

// Objects that share one shape, most of them far from each other.
TEST(ReducedChecker, AnswersForTwoThousandInstances) {
  const std::vector<ShapePointer> shapes(2000, shape_of(bending_tube(5, 6, 0.6)));
  std::mt19937 random(8);
  std::uniform_real_distribution<double> number(-1, 1);
  Step step = random_step(shapes, 0.3, 0.1, random);
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    const std::size_t column = i % 13, row = i / 13 % 13, layer = i / 169;
    const Vec3 cell(static_cast<double>(column), static_cast<double>(row), static_cast<double>(layer));
    const Eigen::Vector3d axis(number(random), number(random), number(random));
    step.start[i].rotation = Eigen::AngleAxisd(3 * number(random), axis.normalized()).toRotationMatrix();
    step.end[i].rotation = step.start[i].rotation;
    step.start[i].translation = 9.0 * cell + Vec3(number(random), number(random), number(random));
    step.end[i].translation =
        step.start[i].translation + 0.3 * Vec3(number(random), number(random), number(random));
  }
  const StepResult answer = expect_same_answer(shapes, step, {});
  EXPECT_GT(pairs_in(answer), 100u);
  EXPECT_LT(answer.work.node_tests, 100'000u);  // of two million pairs of objects
  fmt::print("{} collisions, {} node tests\n", pairs_in(answer), answer.work.node_tests);
}

// Single poses of real meshes: a subspace of their shapes, and steps between them.
class ReducedRealPoses : public ::testing::TestWithParam<const char*> {};

// From every pose to the next, and two short steps; only the first pose unless FOLDPROOF_ALL_FRAMES=1.
TEST_P(ReducedRealPoses, AnswerAsStepChecker) {
  const auto data = oracle::data_directory();
  if (!data) GTEST_SKIP() << oracle::kNoData;
  const bool every = oracle::all_frames();
  if (!every && GetParam() != std::string("horse_poses"))
    GTEST_SKIP() << "Building the balls takes long. Set FOLDPROOF_ALL_FRAMES=1 to run this test.";
  const auto motion = oracle::open_real_motion(*data, GetParam());
  const Index frames = motion->frame_count();
  std::vector<double> x(3 * std::size_t{motion->topology().vertex_count()});
  Eigen::MatrixXd samples(static_cast<Eigen::Index>(x.size()), frames);
  for (Index k = 0; k < frames; ++k) {
    ASSERT_TRUE(motion->read_frame(k, x));
    samples.col(k) = Eigen::Map<const Eigen::VectorXd>(x.data(), static_cast<Eigen::Index>(x.size()));
  }
  ReducedMesh mesh{motion->topology(), x, pca(samples, {.modes = 5}).value()};
  const std::vector<ShapePointer> shapes{shape_of(mesh)};
  std::size_t proven = 0, found = 0, steps = 0;
  for (Index k = 0; k + 1 < (every ? frames : 2); ++k) {
    const Eigen::VectorXd a = mesh.subspace.project(samples.col(k)),
                          b = mesh.subspace.project(samples.col(k + 1));
    const std::pair<Eigen::VectorXd, Eigen::VectorXd> ends[] = {
        {a, b}, {0.1 * a, 0.12 * a}, {a + 0.1 * (b - a), a + 0.2 * (b - a)}};
    for (const auto& [from, to] : ends) {
      Step step;
      step.p0.emplace_back(from.data(), from.data() + from.size());
      step.p1.emplace_back(to.data(), to.data() + to.size());
      step.start.push_back({step.p0[0]});
      step.end.push_back({step.p1[0]});
      const StepResult answer = expect_same_answer(shapes, step, {});
      ASSERT_FALSE(HasFailure()) << "pose " << k;
      proven += answer.work.certificate_passes;
      found += pairs_in(answer);
      ++steps;
    }
  }
  EXPECT_GT(proven, 0u);
  fmt::print("{:14} {:3} steps, {:7} collisions, all as on the reconstructed meshes; radius {:.3f}\n",
             GetParam(), steps, found, shapes[0]->radius(0));
}

INSTANTIATE_TEST_SUITE_P(Motions, ReducedRealPoses,
                         ::testing::Values("horse_poses", "lion_poses", "hand_poses", "hand_train",
                                           "elephant_poses"),
                         [](const auto& instance) { return std::string(instance.param); });

}  // namespace
}  // namespace foldproof::testing
