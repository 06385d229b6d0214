// Crossing triangles of the first frame and of poses, compared with the library's own answers.
#include "page/served.h"

namespace foldproof {
namespace {

using namespace foldproof::testing;
using ::testing::HasSubstr;
using ::testing::SizeIs;

/// What the library itself says of a frame.
StaticResult crossings_of(const std::vector<std::unique_ptr<Motion>>& motions, Index frame = 0) {
  std::vector<Object> objects;
  std::vector<std::vector<double>> frames;
  for (const auto& motion : motions) {
    frames.push_back(frame_of(*motion, frame));
    objects.push_back(
        std::make_shared<const Hierarchy>(*Hierarchy::build(motion->topology(), frame_of(*motion, 0))));
  }
  const std::vector<std::span<const double>> x(frames.begin(), frames.end());
  StaticResult result;
  EXPECT_TRUE(StepChecker(objects).check_static(x, {}, result));
  return result;
}

void expect_same_crossings(const Json& answer, const StaticResult& truth) {
  EXPECT_EQ(answer["total"], truth.crossing_count);
  ASSERT_THAT(answer["items"], SizeIs(truth.crossings.size()));
  for (std::size_t k = 0; k < truth.crossings.size(); ++k) {
    const TriangleCrossing& c = truth.crossings[k];
    const Json& item = answer["items"][k];
    EXPECT_EQ(item["kind"], "tt");
    EXPECT_EQ(item["answer"], "crossing");
    EXPECT_EQ(item["toi"], 0);
    EXPECT_EQ(item["object_a"], c.object_a);
    EXPECT_EQ(item["a"], Json::array({c.triangle_a}));
    EXPECT_EQ(item["object_b"], c.object_b);
    EXPECT_EQ(item["b"], Json::array({c.triangle_b}));
  }
}

TEST(PageCrossings, WhatCrossesFromTheStartIsToldThoughNoStepCollides) {
  const auto motions = sphere_pair(5);
  const StaticResult truth = crossings_of(motions);
  ASSERT_GT(truth.crossings.size(), 20u);
  Served served(page_of(sphere_pair(5)));
  const Json all = served.all_steps();
  EXPECT_EQ(all["start"]["frame"], 0);
  EXPECT_EQ(all["start"]["crossings"], truth.crossings.size());
  for (const Json& step : all["steps"])
    EXPECT_EQ(step["vertex_face"].get<int>() + step["edge_edge"].get<int>(), 0);
  const Json answer = served.json("/api/start/crossings");
  expect_same_crossings(answer, truth);
  // Both balls have a radius of about 1, so they cross halfway between their middles.
  for (const Json& item : answer["items"]) EXPECT_NEAR(item["point"][0], 0.5, 0.1);
  EXPECT_TRUE(served.json("/api/start/crossings?offset=3&limit=2")["items"] ==
              Json::array({answer["items"][3], answer["items"][4]}));
  served.json("/api/start/crossings?limit=1001", 400);
  // They stay inside each other: all that crosses, and more, is marked at both ends of every step.
  for (Index i = 0; i < 2; ++i) {
    const auto crossing = colliding_faces(motions[i]->topology(), i, truth);
    auto faces = served.numbers<std::uint8_t>("/api/steps/1/faces/" + std::to_string(i));
    faces.resize(faces.size() / 4);
    std::size_t more = 0;
    for (std::size_t t = 0; t < faces.size(); ++t) {
      EXPECT_TRUE(faces[t] == 6 || (faces[t] == 0 && crossing[t] == 0)) << t;
      more += faces[t] == 6 && crossing[t] == 0;
    }
    EXPECT_GT(more, 10u);
  }
  for (const Json& step : all["steps"]) {
    EXPECT_EQ(step["inside"][0], step["inside"][1]);
    EXPECT_GT(step["inside"][0], 40);
  }
}

TEST(PageCrossings, WhatIsNotListedOfTheStartIsCounted) {
  CheckSettings check;
  check.step.max_listed = 5;
  Served served(page_of(sphere_pair(2), check));
  const std::uint64_t count = crossings_of(sphere_pair(2)).crossing_count;
  const Json start = served.all_steps()["start"];
  EXPECT_EQ(start["crossings"], count);
  EXPECT_EQ(start["listed"], 5);
  const Json answer = served.json("/api/start/crossings?offset=3");
  EXPECT_EQ(answer["total"], count);
  EXPECT_THAT(answer["items"], SizeIs(2));
}

/// Two spheres in poses that are no motion: they overlap, are apart, and overlap less.
std::vector<std::unique_ptr<Motion>> sphere_poses() {
  return list(memory_motion("left", tube(16, 12), {sphere_at(0), sphere_at(0), sphere_at(5)}),
              memory_motion("right", tube(16, 12), {sphere_at(1, 0.07), sphere_at(9), sphere_at(6.5, 0.07)}));
}

TEST(PageCrossings, AStepOfAStaticCheckIsAPose) {
  CheckSettings check;
  check.poses = true;
  Served served(page_of(sphere_poses(), check));
  const Json scene = served.json("/api/scene");
  EXPECT_EQ(scene["steps"], 3);
  EXPECT_EQ(scene["settings"]["static"], true);
  const Json all = served.all_steps();
  EXPECT_EQ(all["state"], "done");
  EXPECT_EQ(all["total"], 3);
  EXPECT_TRUE(all["start"].is_null());
  EXPECT_THAT(served.json("/api/start/crossings", 404)["error"], HasSubstr("--static"));
  ASSERT_THAT(all["steps"], SizeIs(3));
  const auto motions = sphere_poses();
  for (Index k = 0; k < 3; ++k) {
    const StaticResult truth = crossings_of(motions, k);
    ASSERT_EQ(truth.crossing_count > 0, k != 1);
    const Json& step = all["steps"][k];
    EXPECT_EQ(step["frame"], k);
    EXPECT_EQ(step["next_frame"], k);
    EXPECT_EQ(step["crossings"], truth.crossing_count);
    EXPECT_EQ(step["listed"], truth.crossings.size());
    EXPECT_EQ(step["vertex_face"], 0);
    EXPECT_EQ(step["edge_edge"], 0);
    EXPECT_EQ(step["toi"], 0);
    EXPECT_NE(step["reasons"], Json(ReasonCounts{}));
    const std::string path = "/api/steps/" + std::to_string(k);
    expect_same_crossings(served.json(path + "/collisions"), truth);
    for (Index i = 0; i < 2; ++i) {
      auto faces = served.numbers<std::uint8_t>(path + "/faces/" + std::to_string(i));
      faces.resize(faces.size() / 4);
      const auto crossing = colliding_faces(motions[i]->topology(), i, truth);
      for (std::size_t t = 0; t < faces.size(); ++t)
        EXPECT_TRUE(faces[t] == 6 || (faces[t] == 0 && crossing[t] == 0)) << t;
      if (k == 1) {
        EXPECT_THAT(faces, ::testing::Each(0));
      }
    }
  }
  const Json contacts = served.json("/api/contacts");
  ASSERT_THAT(contacts["items"], SizeIs(2));
  EXPECT_EQ(contacts["items"][0]["worst"], 0);
  EXPECT_EQ(contacts["items"][1]["worst"], 2);
}

TEST(PageCrossings, AFreeStartIsToldToBeFree) {
  Served served(page_of(sphere_pair(3, 2.5)));
  EXPECT_EQ(served.all_steps()["start"]["crossings"], 0);
  EXPECT_THAT(served.json("/api/start/crossings")["items"], SizeIs(0));
  EXPECT_EQ(served.json("/api/steps")["steps"][0]["inside"], Json::array({0, 0}));
}

TEST(PageCrossings, StepsOnlyAsksNothingOfTheStart) {
  CheckSettings check;
  check.steps_only = true;
  Served served(page_of(sphere_pair(3), check));
  EXPECT_EQ(served.json("/api/scene")["settings"]["steps_only"], true);
  const Json all = served.all_steps();
  EXPECT_EQ(all["state"], "done");
  EXPECT_TRUE(all["start"].is_null());
  EXPECT_THAT(served.json("/api/start/crossings", 404)["error"], HasSubstr("--steps-only"));
  EXPECT_EQ(all["steps"][0]["inside"], Json::array({nullptr, nullptr}));
  EXPECT_EQ(all["verdict"]["kind"], "limited");
}

}  // namespace
}  // namespace foldproof
