// Reduced queries far from every centre, where vertices decide: the same answers as StepChecker on the
// rebuilt meshes, from no more pairs of leaves.
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "check/same_collisions.h"
#include "foldproof/check.h"
#include "reduced/shapes.h"

namespace foldproof::testing {
namespace {

using ShapePointer = std::shared_ptr<const ReducedShape>;

ShapePointer shape_of(const ReducedMesh& mesh) {
  const auto motion = mesh.motion();
  return std::make_shared<const ReducedShape>(
      ReducedShape::build(motion, {{std::vector<double>(motion->modes(), 0.0)}}).value());
}

// Where an object is at one end of a step.
struct Place {
  std::vector<double> p;
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Vec3 translation = Vec3::Zero();
  ReducedPose pose() const { return {p, rotation, translation}; }
};

// Both checkers, kept from step to step.
class Rivals {
 public:
  explicit Rivals(const std::vector<ShapePointer>& shapes)
      : shapes_(shapes), reduced_({shapes.begin(), shapes.end()}), full_(hierarchies(shapes)) {}

  void step(const std::vector<Place>& from, const std::vector<Place>& to, StepSettings settings = {}) {
    std::vector<ReducedPose> begin, end;
    std::vector<std::vector<double>> x0, x1;
    for (std::size_t i = 0; i < shapes_.size(); ++i) {
      const ReducedMotion& motion = *shapes_[i]->motion();
      begin.push_back(from[i].pose());
      end.push_back(to[i].pose());
      for (auto* x : {&x0, &x1})
        x->emplace_back(3 * std::size_t{motion.hierarchy()->topology().vertex_count()});
      place_vertices(motion, begin.back(), x0.back());
      place_vertices(motion, end.back(), x1.back());
    }
    ASSERT_TRUE(reduced_.check(begin, end, settings, answer));
    settings.tolerance = answer.tolerance;
    settings.ahead = false;  // work is compared step by step
    const std::vector<std::span<const double>> x0s(x0.begin(), x0.end()), x1s(x1.begin(), x1.end());
    ASSERT_TRUE(full_.check(x0s, x1s, settings, expected));
    expect_same(answer.vertex_face, expected.vertex_face);
    expect_same(answer.edge_edge, expected.edge_edge);
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

std::vector<double> moved(const ReducedMotion& motion, std::vector<double> p, double by,
                          std::mt19937& random) {
  const auto q = random_direction(motion, random);
  for (std::size_t k = 0; k < p.size(); ++k) p[k] += by * q[k];
  return p;
}

// The last pose is the next first one, so that vertices are taken over.
TEST(ReducedChecker, FarFromEveryCentreTestsTheLeavesThatStepCheckerTests) {
  std::size_t hits = 0;
  for (const auto& mesh : {bending_tube(16, 60, 0.6), waving_cloth(20)}) {
    const ShapePointer shape = shape_of(mesh);
    const ReducedMotion& motion = *shape->motion();
    Rivals rivals({shape});
    std::mt19937 random(31);
    Place at{moved(motion, std::vector<double>(motion.modes()), 40, random)};
    for (int k = 0; k < 8; ++k) {
      const Place next{moved(motion, at.p, 2, random)};
      ASSERT_NO_FATAL_FAILURE(rivals.step({at}, {next}));
      EXPECT_EQ(rivals.answer.work.leaf_pairs, rivals.expected.work.leaf_pairs) << "step " << k;
      EXPECT_GT(rivals.answer.work.leaf_pairs, 0u);
      hits += rivals.answer.vertex_face.size() + rivals.answer.edge_edge.size();
      at = next;
    }
  }
  EXPECT_GT(hits, 0u);
}

// To and fro between poses that balls prove, such that vertices decide, and what lies between; with steps
// that go on where the last one ended, others that do not, and others again whose coordinates go on but whose
// placement jumps.
TEST(ReducedChecker, AnswersAlikeWhereverTheLastStepWas) {
  const auto tube = shape_of(bending_tube(12, 30, 0.5)), cloth = shape_of(waving_cloth(12));
  Rivals rivals({tube, cloth, cloth});
  const std::vector<ShapePointer> shapes{tube, cloth, cloth};
  std::mt19937 random(32);
  std::normal_distribution<double> normal(0, 1);
  const auto vector = [&] { return Vec3(normal(random), normal(random), normal(random)); };
  const double distances[] = {0.3, 40, 40, 2, 60, 0.3, 0.3, 60, 5, 40, 40, 40};
  std::vector<Place> at(3);
  std::size_t within = 0, between = 0;
  for (int k = 0; k < 36; ++k) {
    std::vector<Place> next(3);
    for (std::size_t i = 0; i < 3; ++i) {
      const ReducedMotion& motion = *shapes[i]->motion();
      const double distance = distances[(k + 4 * i) % std::size(distances)];
      const std::vector<double> origin(motion.modes());
      if (k % 3 == 0) at[i] = {moved(motion, origin, distance, random), at[i].rotation, 0.6 * vector()};
      if (k % 3 == 1) at[i].translation = 0.6 * vector();
      next[i] = {moved(motion, at[i].p, 0.1 * distance, random), at[i].rotation,
                 at[i].translation + 0.1 * vector()};
      if (k % 4 == 3) next[i].rotation = Eigen::AngleAxisd(normal(random), vector().normalized()).matrix();
    }
    StepSettings settings;
    settings.certificates = k % 5 != 4;
    ASSERT_NO_FATAL_FAILURE(rivals.step(at, next, settings)) << "step " << k;
    for (const auto& c : rivals.answer.vertex_face) ++(c.vertex_object == c.face_object ? within : between);
    at = next;
  }
  EXPECT_GT(within, 0u);
  EXPECT_GT(between, 0u);
}

// Between two far steps, the second of which begins where the first ended, another one is looked at leaf by
// leaf: what it computed is not what the first one left.
TEST(ReducedChecker, TakesVerticesOverOnlyWhileTheyStand) {
  const ShapePointer shape = shape_of(bending_tube(16, 60, 0.6));
  const ReducedMotion& motion = *shape->motion();
  Rivals rivals({shape});
  std::mt19937 random(33);
  const std::vector<double> origin(motion.modes());
  bool some = false;
  for (int k = 0; k < 4; ++k) {
    const Place a{moved(motion, origin, 40, random)}, b{moved(motion, a.p, 2, random)},
        c{moved(motion, b.p, 2, random)};
    ASSERT_NO_FATAL_FAILURE(rivals.step({a}, {b}));
    const Place near{moved(motion, origin, shape->radius(0) * 1.1, random)},
        next{moved(motion, origin, shape->radius(0) * 1.1, random)};
    ASSERT_NO_FATAL_FAILURE(rivals.step({near}, {next}));
    some |= rivals.answer.work.leaf_pairs > 0;
    ASSERT_NO_FATAL_FAILURE(rivals.step({b}, {c}));
  }
  EXPECT_TRUE(some) << "no step in between looked at leaves";
}

}  // namespace
}  // namespace foldproof::testing
