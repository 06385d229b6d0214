// Reduced queries far from every center, where vertices decide: the same answers as StepChecker on the
// reconstructed meshes, from no more pairs of leaves.
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "check/same_collisions.h"
#include "foldproof/check.h"
#include "foldproof/eigen.h"
#include "reduced/shapes.h"

namespace foldproof::testing {
namespace {

using ShapePointer = std::shared_ptr<const ReducedShape>;

ShapePointer shape_of(const ReducedMesh& mesh) {
  const auto motion = mesh.motion();
  return std::make_shared<const ReducedShape>(
      ReducedShape::build(motion, {{std::vector<double>(motion->modes(), 0.0)}}).value());
}

// An object at one end of a step.
struct Placement {
  std::vector<double> p;
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Vec3 translation = Vec3::Zero();
  ReducedPose pose() const { return {p, rotation, translation}; }
};

// Both checkers, reused from step to step.
class BothCheckers {
 public:
  explicit BothCheckers(const std::vector<ShapePointer>& shapes)
      : shapes_(shapes), reduced_({shapes.begin(), shapes.end()}), full_(hierarchies(shapes)) {}

  void step(const std::vector<Placement>& from, const std::vector<Placement>& to,
            StepSettings settings = {}) {
    std::vector<ReducedPose> start, end;
    std::vector<std::vector<double>> x0, x1;
    for (std::size_t i = 0; i < shapes_.size(); ++i) {
      const ReducedMotion& motion = *shapes_[i]->motion();
      start.push_back(from[i].pose());
      end.push_back(to[i].pose());
      for (auto* x : {&x0, &x1})
        x->emplace_back(3 * std::size_t{motion.hierarchy()->topology().vertex_count()});
      pose_vertices(motion, start.back(), x0.back());
      pose_vertices(motion, end.back(), x1.back());
    }
    ASSERT_TRUE(reduced_.check(start, end, settings, answer));
    settings.tolerance = answer.tolerance;
    settings.look_ahead = false;  // work is compared step by step
    const std::vector<std::span<const double>> x0s(x0.begin(), x0.end()), x1s(x1.begin(), x1.end());
    ASSERT_TRUE(full_.check(x0s, x1s, settings, expected));
    expect_same_collisions(answer, expected);
    EXPECT_EQ(answer.earliest_toi, expected.earliest_toi);
  }
  StepResult answer, expected;

 private:
  static std::vector<Object> hierarchies(const std::vector<ShapePointer>& shapes) {
    std::vector<Object> result;
    for (const ShapePointer& shape : shapes) result.push_back(shape->motion()->hierarchy());
    return result;
  }
  std::vector<ShapePointer> shapes_;
  ReducedChecker reduced_;
  StepChecker full_;
};

std::vector<double> moved(const ReducedMotion& motion, std::vector<double> p, double distance,
                          std::mt19937& random) {
  const auto q = random_direction(motion, random);
  for (std::size_t k = 0; k < p.size(); ++k) p[k] += distance * q[k];
  return p;
}

// Each step starts where the last one ended, so its vertices are reused.
TEST(ReducedChecker, FarFromEveryCenterTestsTheLeavesThatStepCheckerTests) {
  std::size_t hits = 0;
  for (const auto& mesh : {bending_tube(16, 60, 0.6), waving_cloth(20)}) {
    const ShapePointer shape = shape_of(mesh);
    const ReducedMotion& motion = *shape->motion();
    BothCheckers checkers({shape});
    std::mt19937 random(31);
    Placement at{moved(motion, std::vector<double>(motion.modes()), 40, random)};
    for (int k = 0; k < 8; ++k) {
      const Placement next{moved(motion, at.p, 2, random)};
      ASSERT_NO_FATAL_FAILURE(checkers.step({at}, {next}));
      EXPECT_EQ(checkers.answer.work.leaf_pairs, checkers.expected.work.leaf_pairs) << "step " << k;
      EXPECT_GT(checkers.answer.work.leaf_pairs, 0u);
      hits += checkers.answer.vertex_face.size() + checkers.answer.edge_edge.size();
      at = next;
    }
  }
  EXPECT_GT(hits, 0u);
}

// Back and forth between poses near a center, poses far from it, and poses in between. Steps start where the
// last one ended, or elsewhere, or with the same coordinates at another translation.
TEST(ReducedChecker, AnswersDoNotDependOnTheLastStep) {
  const auto tube = shape_of(bending_tube(12, 30, 0.5)), cloth = shape_of(waving_cloth(12));
  BothCheckers checkers({tube, cloth, cloth});
  const std::vector<ShapePointer> shapes{tube, cloth, cloth};
  std::mt19937 random(32);
  std::normal_distribution<double> normal(0, 1);
  const auto vector = [&] { return Vec3(normal(random), normal(random), normal(random)); };
  const double distances[] = {0.3, 40, 40, 2, 60, 0.3, 0.3, 60, 5, 40, 40, 40};
  std::vector<Placement> at(3);
  std::size_t within = 0, between = 0;
  for (int k = 0; k < 36; ++k) {
    std::vector<Placement> next(3);
    for (std::size_t i = 0; i < 3; ++i) {
      const ReducedMotion& motion = *shapes[i]->motion();
      const double distance = distances[(k + 4 * i) % std::size(distances)];
      const std::vector<double> origin(motion.modes());
      if (k % 3 == 0) at[i] = {moved(motion, origin, distance, random), at[i].rotation, 0.6 * vector()};
      if (k % 3 == 1) at[i].translation = 0.6 * vector();
      next[i] = {moved(motion, at[i].p, 0.1 * distance, random), at[i].rotation,
                 at[i].translation + 0.1 * vector()};
      if (k % 4 == 3)
        next[i].rotation = Eigen::AngleAxisd(normal(random), to_eigen(vector().normalized())).matrix();
    }
    StepSettings settings;
    settings.certificates = k % 5 != 4;
    ASSERT_NO_FATAL_FAILURE(checkers.step(at, next, settings)) << "step " << k;
    for (const auto& c : checkers.answer.vertex_face) ++(c.vertex_object == c.face_object ? within : between);
    at = next;
  }
  EXPECT_GT(within, 0u);
  EXPECT_GT(between, 0u);
}

// The third step starts where the first one ended, but the second one computed vertices leaf by leaf in
// between. The third must not reuse those as vertices of the first.
TEST(ReducedChecker, ReusesVerticesOnlyWhileTheyAreValid) {
  const ShapePointer shape = shape_of(bending_tube(16, 60, 0.6));
  const ReducedMotion& motion = *shape->motion();
  BothCheckers checkers({shape});
  std::mt19937 random(33);
  const std::vector<double> origin(motion.modes());
  bool any_leaves = false;
  for (int k = 0; k < 4; ++k) {
    const Placement a{moved(motion, origin, 40, random)}, b{moved(motion, a.p, 2, random)},
        c{moved(motion, b.p, 2, random)};
    ASSERT_NO_FATAL_FAILURE(checkers.step({a}, {b}));
    const Placement near{moved(motion, origin, shape->radius(0) * 1.1, random)},
        next{moved(motion, origin, shape->radius(0) * 1.1, random)};
    ASSERT_NO_FATAL_FAILURE(checkers.step({near}, {next}));
    any_leaves |= checkers.answer.work.leaf_pairs > 0;
    ASSERT_NO_FATAL_FAILURE(checkers.step({b}, {c}));
  }
  EXPECT_TRUE(any_leaves) << "no step in between tested leaves";
}

}  // namespace
}  // namespace foldproof::testing
