// Many objects that share one mesh: the same answer as when all of them are one mesh, without tests of
// objects that are far from each other.
#include <gtest/gtest.h>

#include <random>

#include "check/same_collisions.h"
#include "check/sweep_and_prune.h"
#include "foldproof/check.h"
#include "foldproof/model.h"

namespace foldproof {
namespace {

using testing::expect_same_collisions;
using Positions3 = std::vector<double>;

constexpr Index kBodies = 2000;

/// An icosahedron.
struct Body {
  std::vector<Triangle> triangles{{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                                  {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                                  {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                                  {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
  Positions3 x;
  Body() {
    const double g = 1.618;
    for (const Vec3& v :
         {Vec3(-1, g, 0), Vec3(1, g, 0), Vec3(-1, -g, 0), Vec3(1, -g, 0), Vec3(0, -1, g), Vec3(0, 1, g),
          Vec3(0, -1, -g), Vec3(0, 1, -g), Vec3(g, 0, -1), Vec3(g, 0, 1), Vec3(-g, 0, -1), Vec3(-g, 0, 1)})
      x.insert(x.end(), v.begin(), v.end());
  }
  Index vertices() const { return static_cast<Index>(x.size() / 3); }
};

/// The body in its one pose, to train on.
struct BodyMotion : Motion {
  Body body;
  Topology mesh = Topology::make(body.vertices(), body.triangles).value();
  const std::string& name() const override { return name_; }
  const Topology& topology() const override { return mesh; }
  Index frame_count() const override { return 1; }
  Result<void> read_frame(Index, std::span<double> out) override {
    std::ranges::copy(body.x, out.begin());
    return {};
  }

 private:
  std::string name_ = "body";
};

/// All bodies at both ends of a step: near the points of a grid, each with a motion of its own.
struct Crowd {
  Body body;
  std::vector<Positions3> x0, x1;
  explicit Crowd(unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> number(-1, 1);
    for (Index i = 0; i < kBodies; ++i) {
      const Index column = i % 13, row = i / 13 % 13, layer = i / 169;
      const Vec3 cell(column, row, layer);
      const Vec3 at = 4.6 * cell + 0.8 * Vec3(number(random), number(random), number(random));
      const Vec3 by = 0.8 * Vec3(number(random), number(random), number(random));
      auto &from = x0.emplace_back(body.x), &to = x1.emplace_back(body.x);
      for (std::size_t k = 0; k < from.size(); ++k) {
        from[k] += at[k % 3];
        to[k] = from[k] + by[k % 3] + 0.05 * number(random);
      }
    }
  }

  /// All bodies share a hierarchy and, with `with_model`, a chart library.
  StepResult as_objects(const Model& model, bool with_model, bool certificates) const {
    StepChecker checker(std::vector(kBodies, with_model ? model.object() : Object(model.hierarchy())));
    const std::vector<std::span<const double>> from(x0.begin(), x0.end()), to(x1.begin(), x1.end());
    StepResult answer;
    for (int k = 0; k < 3; ++k) {  // charts and planes are used from the second step on
      EXPECT_TRUE(checker.check(from, to, {.certificates = certificates, .look_ahead = false}, answer));
    }
    return answer;
  }

  StepResult as_one_mesh() const {
    std::vector<Triangle> triangles;
    Positions3 from, to;
    for (Index i = 0; i < kBodies; ++i) {
      const Index first = i * body.vertices();
      for (const Triangle& t : body.triangles)
        triangles.push_back({first + t[0], first + t[1], first + t[2]});
      from.insert(from.end(), x0[i].begin(), x0[i].end());
      to.insert(to.end(), x1[i].begin(), x1[i].end());
    }
    auto mesh = Topology::make(kBodies * body.vertices(), triangles);
    StepChecker checker({std::make_shared<const Hierarchy>(Hierarchy::build(mesh.value(), from).value())});
    const std::span<const double> begin[] = {from}, end[] = {to};
    StepResult answer;
    EXPECT_TRUE(checker.check(begin, end, {}, answer));
    const Index v = body.vertices(), f = static_cast<Index>(body.triangles.size());
    for (VertexFaceCollision& c : answer.vertex_face)
      c = {c.vertex / v, c.vertex % v, c.face / f, c.face % f, c.toi, c.answer};
    for (EdgeEdgeCollision& c : answer.edge_edge) {
      c = {c.a[0] / v, {c.a[0] % v, c.a[1] % v}, c.b[0] / v, {c.b[0] % v, c.b[1] % v}, c.toi, c.answer};
    }
    return answer;
  }
};

TEST(Instances, AnswerAsOneMesh) {
  const Crowd crowd(5);
  const StepResult whole = crowd.as_one_mesh();
  EXPECT_GT(whole.vertex_face.size() + whole.edge_edge.size(), 1000u);
  BodyMotion motion;
  const TrainPose poses[] = {{&motion, 0}};
  const auto model = train_model(poses, {.learn = false});
  ASSERT_TRUE(model) << model.error().line();
  for (const auto& [with_model, certificates] : {std::pair(true, true), {false, true}, {false, false}}) {
    const StepResult answer = crowd.as_objects(*model, with_model, certificates);
    expect_same_collisions(answer, whole);
    EXPECT_LT(answer.work.node_tests, 100'000u);  // of two million pairs of bodies
    EXPECT_EQ(answer.work.certificate_passes > 0, certificates);
  }
}

TEST(SweepAndPrune, FindsEveryPairThatIsNear) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> number(0, 1);
  SweepAndPrune sweep;
  for (const Index count : {0, 1, 2, 40, 200}) {
    std::vector<SweptBox> boxes(count);
    for (SweptBox& box : boxes) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        box.low[axis] = number(random);
        box.high[axis] = box.low[axis] + 0.2 * number(random);
      }
    }
    std::vector<SweepAndPrune::Pair> expected;
    for (Index a = 0; a < count; ++a) {
      for (Index b = a + 1; b < count; ++b) {
        bool separated = false;
        for (std::size_t axis = 0; axis < 3; ++axis) {
          separated |= boxes[b].low[axis] - boxes[a].high[axis] > 0.1;
          separated |= boxes[a].low[axis] - boxes[b].high[axis] > 0.1;
        }
        if (!separated) expected.push_back({a, b});
      }
    }
    const auto found = sweep.pairs(boxes, 0.1);
    EXPECT_TRUE(std::ranges::equal(found, expected)) << count << " boxes";
  }
}

}  // namespace
}  // namespace foldproof
