// The page's data, compared with the library's own answers.
#include <malloc.h>

#include <algorithm>
#include <map>

#include "foldproof/reduced.h"
#include "page/served.h"

namespace foldproof {
namespace {

using namespace foldproof::testing;
using ::testing::HasSubstr;
using ::testing::SizeIs;

/// As positions are sent: relative to the scene's center.
std::vector<float> single(const std::vector<double>& x, const Json& scene) {
  std::vector<float> floats;
  for (std::size_t k = 0; k < x.size(); ++k)
    floats.push_back(static_cast<float>(x[k] - scene["center"][k % 3].get<double>()));
  return floats;
}

/// The library's own answers for the steps of motions.
class Truth {
 public:
  explicit Truth(std::vector<std::unique_ptr<Motion>> motions) : motions_(std::move(motions)) {
    std::vector<Object> objects;
    for (const auto& motion : motions_) {
      objects.push_back(
          std::make_shared<const Hierarchy>(*Hierarchy::build(motion->topology(), frame_of(*motion, 0))));
    }
    objects_ = objects;
    checker_.emplace(std::move(objects));
  }

  /// The step from frame `k`. Call it for the steps in order.
  const StepResult& step(Index k) {
    x0_.clear();
    x1_.clear();
    for (const auto& motion : motions_) {
      x0_.push_back(frame_of(*motion, k));
      x1_.push_back(frame_of(*motion, k + 1));
    }
    const std::vector<std::span<const double>> from(x0_.begin(), x0_.end()), to(x1_.begin(), x1_.end());
    if (k == 0) {  // as a check begins: its charts serve the steps
      StaticResult crossings;
      EXPECT_TRUE(checker_->check_static(from, {}, crossings));
    }
    EXPECT_TRUE(checker_->check(from, to, {.explain = true}, result_));
    return result_;
  }
  Vec3 at(Index object, Index vertex, double t) const {
    const std::size_t k = 3 * std::size_t{vertex};
    Vec3 x;
    for (std::size_t axis = 0; axis < 3; ++axis)
      x[axis] = std::lerp(x0_[object][k + axis], x1_[object][k + axis], t);
    return x;
  }
  Motion& motion(Index object) { return *motions_[object]; }
  const Hierarchy& hierarchy(Index object) const { return *objects_[object].hierarchy(); }

 private:
  std::vector<std::unique_ptr<Motion>> motions_;
  std::vector<Object> objects_;
  std::optional<StepChecker> checker_;
  StepResult result_;
  std::vector<std::vector<double>> x0_, x1_;
};

/// The tube, and a second one that crosses its path.
std::vector<std::unique_ptr<Motion>> two_tubes() {
  std::vector<std::vector<double>> frames;
  for (int k = 0; k < 8; ++k) {
    std::vector<double> x = bent(10, 12, 0.4);
    for (std::size_t i = 2; i < x.size(); i += 3) x[i] += 2 - 0.5 * k;
    frames.push_back(std::move(x));
  }
  return list(colliding_tube(), memory_motion("bar", tube(10, 12), std::move(frames)));
}

TEST(PageAnswers, TheSceneDescribesItsObjects) {
  CheckSettings check;
  check.frames = *parse_frame_range("1:8:2");
  check.substeps = 3;
  check.step.thickness = 0.25;
  Served served(page_of(two_tubes(), check));
  const Json scene = served.json("/api/scene");
  EXPECT_EQ(scene["program"], "foldproof");
  EXPECT_EQ(scene["version"], version());
  EXPECT_EQ(scene["title"], "tube and 1 more");
  EXPECT_EQ(scene["frames"], 4);
  EXPECT_EQ(scene["frame_numbers"], Json({1, 3, 5, 7}));
  EXPECT_EQ(scene["fps"], 24);
  EXPECT_EQ(scene["substeps"], 3);
  EXPECT_EQ(scene["steps"], 9);
  EXPECT_EQ(scene["settings"]["thickness"], 0.25);
  EXPECT_EQ(scene["settings"]["mode"], "proven");
  EXPECT_THAT(scene["reasons"], SizeIs(kReasonNames.size()));
  ASSERT_THAT(scene["objects"], SizeIs(2));
  EXPECT_EQ(scene["objects"][0]["name"], "tube");
  EXPECT_EQ(scene["objects"][0]["triangles"], 24 * 30 * 2);
  EXPECT_EQ(scene["objects"][1]["vertices"], 130);
  EXPECT_TRUE(scene["objects"][1]["model"].is_null());
  Vec3 low = Vec3::Constant(1e9), high = -low;
  for (const auto& motion : two_tubes()) {
    const std::vector<double> x = frame_of(*motion, 1);
    for (std::size_t k = 0; k < x.size(); ++k) {
      auto& l = low[k % 3];
      auto& h = high[k % 3];
      l = std::min(l, x[k]);
      h = std::max(h, x[k]);
    }
  }
  EXPECT_EQ(scene["low"], Json({low.x(), low.y(), low.z()}));
  EXPECT_EQ(scene["high"], Json({high.x(), high.y(), high.z()}));
}

TEST(PageAnswers, FramesAndTrianglesAreThoseOfTheMotions) {
  CheckSettings check;
  check.frames = *parse_frame_range("::3");
  Served served(page_of(two_tubes(), check));
  const auto motions = two_tubes();
  for (std::size_t i = 0; i < motions.size(); ++i) {
    const std::string object = "/api/objects/" + std::to_string(i);
    std::vector<Index> triangles;
    for (const Triangle& t : motions[i]->topology().triangles())
      triangles.insert(triangles.end(), t.begin(), t.end());
    EXPECT_EQ(served.numbers<Index>(object + "/triangles"), triangles);
    for (const Index k : {2, 0, 1})
      EXPECT_EQ(served.numbers<float>(object + "/frames/" + std::to_string(k)),
                single(frame_of(*motions[i], 3 * k), served.json("/api/scene")));
  }
}

void expect_same(const Json& answer, const StepResult& step, Index number) {
  EXPECT_EQ(answer["number"], number);
  EXPECT_EQ(answer["frame"], number);
  EXPECT_EQ(answer["next_frame"], number + 1);
  EXPECT_EQ(answer["substep"], 0);
  EXPECT_EQ(answer["vertex_face"], step.vertex_face.size());
  EXPECT_EQ(answer["edge_edge"], step.edge_edge.size());
  EXPECT_EQ(answer["undecided"], step.work.undecided);
  EXPECT_EQ(answer["toi"], step.earliest_toi);
  EXPECT_EQ(answer["tolerance"], step.tolerance);
  EXPECT_EQ(answer["node_tests"], step.work.node_tests);
  EXPECT_EQ(answer["certificate_tests"], step.work.certificate_tests);
  EXPECT_EQ(answer["certificate_passes"], step.work.certificate_passes);
  EXPECT_EQ(answer["leaf_pairs"], step.work.leaf_pairs);
  EXPECT_EQ(answer["candidates"], step.work.candidates_vf + step.work.candidates_ee);
  EXPECT_EQ(answer["reasons"], Json(step.explanation.leaf_pairs));
  EXPECT_GT(answer["ms"]["total"], 0);
}

/// The distance of a point from a vertex, an edge or a face.
double distance(const Vec3& point, const std::vector<Vec3>& corners) {
  return vertex_face_closest({point, corners.front(), corners[corners.size() / 2], corners.back()}).distance;
}

/// Expects the same collisions, sorted by time of impact, with points where the features meet.
void expect_same_collisions(const Json& by_time, const StepResult& step, Truth& truth) {
  ASSERT_THAT(by_time, SizeIs(step.vertex_face.size() + step.edge_edge.size()));
  std::vector<Json> items(by_time.begin(), by_time.end());
  EXPECT_TRUE(std::ranges::is_sorted(items, {}, [](const Json& item) { return item["toi"].get<double>(); }));
  std::ranges::sort(items, {}, [](const Json& item) {
    return Json{item["kind"] != "vf", item["object_a"], item["a"], item["object_b"], item["b"]};
  });
  const auto near = [&](const Json& item, double toi, const std::vector<Vec3>& a,
                        const std::vector<Vec3>& b) {
    const Vec3 point(item["point"][0], item["point"][1], item["point"][2]);
    EXPECT_EQ(item["toi"], toi);
    EXPECT_EQ(item["answer"], "hit");
    EXPECT_LE(distance(point, a), step.tolerance);
    EXPECT_LE(distance(point, b), step.tolerance);
  };
  std::size_t next = 0;
  for (const VertexFaceCollision& c : step.vertex_face) {
    const Json& item = items[next++];
    EXPECT_EQ(item["kind"], "vf");
    EXPECT_EQ(item["object_a"], c.vertex_object);
    EXPECT_EQ(item["a"], Json({c.vertex}));
    EXPECT_EQ(item["object_b"], c.face_object);
    EXPECT_EQ(item["b"], Json({c.face}));
    std::vector<Vec3> face;
    for (const Index v : truth.motion(c.face_object).topology().triangles()[c.face])
      face.push_back(truth.at(c.face_object, v, c.toi));
    near(item, c.toi, {truth.at(c.vertex_object, c.vertex, c.toi)}, face);
  }
  for (const EdgeEdgeCollision& c : step.edge_edge) {
    const Json& item = items[next++];
    EXPECT_EQ(item["kind"], "ee");
    EXPECT_EQ(item["object_a"], c.object_a);
    EXPECT_EQ(item["a"], Json(c.a));
    EXPECT_EQ(item["object_b"], c.object_b);
    EXPECT_EQ(item["b"], Json(c.b));
    near(item, c.toi, {truth.at(c.object_a, c.a[0], c.toi), truth.at(c.object_a, c.a[1], c.toi)},
         {truth.at(c.object_b, c.b[0], c.toi), truth.at(c.object_b, c.b[1], c.toi)});
  }
}

void expect_same_faces(const std::string& body, const Topology& topology, Index object,
                       const StepResult& step) {
  const auto bytes = numbers_in<std::uint8_t>(body);
  const std::size_t count = topology.triangles().size();
  ASSERT_THAT(bytes, SizeIs(4 * count));
  const Explanation::Object& why = step.explanation.objects[object];
  const auto colliding = colliding_faces(topology, object, step);
  for (std::size_t t = 0; t < count; ++t) {
    ASSERT_EQ(bytes[t] & 1, colliding[t]);
    ASSERT_EQ(bytes[count + t], static_cast<std::uint8_t>(why.reason[t]));
    ASSERT_EQ(static_cast<std::int8_t>(bytes[2 * count + t]), why.level[t]);
    ASSERT_NEAR(bytes[3 * count + t], 255 * why.margin[t], 0.5);
  }
}

TEST(PageAnswers, StepsAreThoseOfTheChecker) {
  Served served(page_of(two_tubes()));
  Truth truth(two_tubes());
  const Json all = served.all_steps();
  EXPECT_EQ(all["state"], "done");
  EXPECT_EQ(all["error"], "");
  EXPECT_EQ(all["done"], 7);
  EXPECT_EQ(all["total"], 7);
  ASSERT_THAT(all["steps"], SizeIs(7));
  std::size_t vertex_face = 0, edge_edge = 0, between = 0;
  for (Index k = 0; k < 7; ++k) {
    const StepResult& step = truth.step(k);
    expect_same(all["steps"][k], step, k);
    const std::string path = "/api/steps/" + std::to_string(k);
    const Json collisions = served.json(path + "/collisions");
    EXPECT_EQ(collisions["total"], step.vertex_face.size() + step.edge_edge.size());
    ASSERT_LE(collisions["total"], 1000);
    expect_same_collisions(collisions["items"], step, truth);
    for (Index i = 0; i < 2; ++i) {
      expect_same_faces(served.get(path + "/faces/" + std::to_string(i)).body, truth.motion(i).topology(), i,
                        step);
    }
    vertex_face += step.vertex_face.size();
    edge_edge += step.edge_edge.size();
    for (const EdgeEdgeCollision& c : step.edge_edge) between += c.object_a != c.object_b;
  }
  EXPECT_GT(vertex_face, 20u) << "there is something to compare";
  EXPECT_GT(edge_edge, between);
  EXPECT_GT(between, 0u);
}

TEST(PageAnswers, CollisionsComeInParts) {
  Served served(page_of(two_tubes()));
  const Json steps = served.all_steps()["steps"];
  const auto worst = std::max_element(steps.begin(), steps.end(), [](const Json& a, const Json& b) {
    return a["edge_edge"] < b["edge_edge"];
  });
  const std::string path = "/api/steps/" + std::to_string((*worst)["number"].get<int>()) + "/collisions";
  const Json all = served.json(path)["items"];
  ASSERT_GT(all.size(), 20u);
  Json parts = Json::array();
  for (std::size_t offset = 0; offset < all.size(); offset += 7) {
    const Json part = served.json(path + "?limit=7&offset=" + std::to_string(offset))["items"];
    parts.insert(parts.end(), part.begin(), part.end());
  }
  EXPECT_TRUE(parts == all) << "parts of a list make the list";
  EXPECT_THAT(served.json(path + "?offset=99999999999")["items"], SizeIs(0));
  EXPECT_THAT(served.json(path + "?limit=0")["items"], SizeIs(0));
}

/// Boxes of the nodes at a depth, and of leaves above it, from the left.
void collect(const Hierarchy& h, Index node, Index depth, const std::vector<float>& x,
             std::vector<float>& out) {
  const Hierarchy::Node& n = h.nodes()[node];
  if (depth > 0 && !n.is_leaf()) {
    collect(h, node + 1, depth - 1, x, out);
    collect(h, n.right, depth - 1, x, out);
    return;
  }
  std::array<float, 6> box{1e9f, 1e9f, 1e9f, -1e9f, -1e9f, -1e9f};
  for (Index t = h.leaves()[n.leaf_begin].triangles; t < h.leaves()[n.leaf_end].triangles; ++t) {
    for (const Index v : h.topology().triangles()[h.triangle_ids()[t]]) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        box[axis] = std::min(box[axis], x[3 * std::size_t{v} + axis]);
        box[3 + axis] = std::max(box[3 + axis], x[3 * std::size_t{v} + axis]);
      }
    }
  }
  out.insert(out.end(), box.begin(), box.end());
}

TEST(PageAnswers, BoxesAreThoseOfTheHierarchy) {
  Served served(page_of(two_tubes()));
  Truth truth(two_tubes());
  const Json scene = served.json("/api/scene");
  for (Index i = 0; i < 2; ++i) {
    const Index levels = scene["objects"][i]["levels"];
    ASSERT_GT(levels, 2u);
    const std::string path = "/api/objects/" + std::to_string(i) + "/boxes";
    for (Index level = 0; level <= levels; ++level) {
      std::vector<float> boxes;
      collect(truth.hierarchy(i), 0, level, single(frame_of(truth.motion(i), 5), scene), boxes);
      EXPECT_EQ(served.numbers<float>(path + "?frame=5&level=" + std::to_string(level)), boxes);
      if (level == levels) {
        EXPECT_THAT(boxes, SizeIs(6 * truth.hierarchy(i).leaf_count()));
      }
    }
    served.json(path + "?level=" + std::to_string(levels + 1), 404);
    EXPECT_THAT(served.numbers<float>(path), SizeIs(6)) << "frame 0, the root";
  }
}

TEST(PageAnswers, StepsAreDividedIntoSubsteps) {
  CheckSettings check;
  check.substeps = 5;
  Served served(page_of(list(sinking_triangle(kSinking)), check));
  const Json all = served.all_steps();
  ASSERT_THAT(all["steps"], SizeIs(20));
  // The tip meets the floor 0.6 of the way from frame 1 to 2: at the end of the third part, or the start of
  // the fourth.
  int hits = 0;
  for (const Json& step : all["steps"]) {
    if (step["frame"] != 1 || step["vertex_face"] == 0) continue;
    ++hits;
    EXPECT_EQ(step["next_frame"], 2);
    EXPECT_NEAR(step["substep"].get<double>() + step["toi"].get<double>(), 3, 1e-6);
    const Json item =
        served.json("/api/steps/" + std::to_string(step["number"].get<int>()) + "/collisions")["items"][0];
    EXPECT_NEAR(item["point"][0], 0.1, 1e-6);
    EXPECT_NEAR(item["point"][2], 0, 1e-6);
  }
  EXPECT_GE(hits, 1);
}

TEST(PageAnswers, FramesAreNotKeptInMemory) {
  const auto held = [] { return mallinfo2().uordblks; };
  auto page = page_of(list(bending_tube(kTube, std::vector<double>(400, 1.0))));
  Served served(std::move(page));
  const std::size_t before = held();
  const Json all = served.all_steps();
  EXPECT_EQ(all["done"], 399);
  for (Index k = 0; k < 400; ++k)
    EXPECT_THAT(served.numbers<float>("/api/objects/0/frames/" + std::to_string(k)), SizeIs(3 * 32 * 49));
  // All answers are 399 x 3,072 x 4 bytes, about 5 MB.
  EXPECT_LT(static_cast<double>(held()) - static_cast<double>(before), 2e6);
}

TEST(PageAnswers, ManyStepsComeAThousandAtATime) {
  CheckSettings check;
  check.substeps = 3;
  Served served(page_of(list(bending_tube(kSmallTube, std::vector<double>(401, 1.0))), check));
  served.all_steps();
  const Json first = served.json("/api/steps"), rest = served.json("/api/steps?from=1000");
  EXPECT_THAT(first["steps"], SizeIs(1000));
  ASSERT_THAT(rest["steps"], SizeIs(200));
  EXPECT_EQ(rest["steps"][0]["number"], 1000);
  EXPECT_THAT(served.json("/api/steps?from=9999999")["steps"], SizeIs(0));
}

TEST(PageAnswers, ASinglePoseIsAStepWithoutMotion) {
  Served served(page_of(list(bending_tube(kSmallTube, {1}))));
  EXPECT_EQ(served.json("/api/scene")["steps"], 1);
  const Json steps = served.all_steps();
  EXPECT_EQ(steps["state"], "done");
  EXPECT_EQ(steps["total"], 1);
  EXPECT_EQ(steps["start"]["crossings"], 0);
  EXPECT_EQ(steps["steps"][0]["next_frame"], 0);
  EXPECT_THAT(served.numbers<float>("/api/objects/0/frames/0"), SizeIs(3 * 12 * 9));
  EXPECT_THAT(served.json("/api/steps/1/collisions", 404)["error"], HasSubstr("no step 1"));
  Served crossing(page_of(sphere_pair(1)));
  EXPECT_GT(crossing.all_steps()["start"]["crossings"], 0);
}

TEST(PageAnswers, BoundsAreThoseOfTheEndsOfSteps) {
  Served served(page_of(sphere_pair(5)));
  const Json steps = served.all_steps()["steps"];
  for (int k = 0; k < 4; ++k) {
    EXPECT_NEAR(steps[k]["low"][0], 0.3 * (k + 1) - 1, 0.01);
    EXPECT_NEAR(steps[k]["high"][0], 0.3 * (k + 1) + 2, 0.01);
  }
}

TEST(PageAnswers, PositionsFarFromTheOriginKeepTheirPrecision) {
  const std::vector<double> near = sphere_at(0.25);
  std::vector<double> far = near;
  for (double& value : far) value += 1e8;
  Served served(page_of(list(memory_motion("far", tube(16, 12), {far}))));
  const auto x = served.numbers<float>("/api/objects/0/frames/0");
  const Json center = served.json("/api/scene")["center"];
  for (std::size_t k = 0; k < x.size(); ++k)
    ASSERT_NEAR(x[k] + (center[k % 3].get<double>() - 1e8), near[k], 1e-6) << k;
}

TEST(PageAnswers, AStoppedCheckIsNotDone) {
  const auto page = page_of(sphere_pair(3));
  const std::atomic<bool> stop{true};
  page->work(stop);
  const Json all = Json::parse(page->get("/api/steps").body);
  EXPECT_EQ(all["state"], "stopped");
  EXPECT_EQ(all["done"], 0);
  EXPECT_EQ(all["total"], 2);
  EXPECT_TRUE(all["start"].is_null());
  const PageAnswer step = page->get("/api/steps/1/collisions"), start = page->get("/api/start/crossings");
  EXPECT_EQ(step.status, 404);
  EXPECT_THAT(step.body, HasSubstr("stopped before step 1"));
  EXPECT_EQ(start.status, 404);
  EXPECT_THAT(start.body, HasSubstr("stopped before the first frame"));
}

TEST(PageAnswers, AMotionThatTurnsBadFailsWithOneLine) {
  std::vector<std::unique_ptr<Motion>> motions;
  motions.push_back(std::make_unique<UnreadableFrom>(colliding_tube(), 3));
  Served served(page_of(std::move(motions)));
  const Json all = served.all_steps();
  EXPECT_EQ(all["state"], "failed");
  EXPECT_EQ(all["error"], "tube, frame 3: is torn; export it again");
  EXPECT_EQ(all["done"], 2);
  EXPECT_EQ(all["total"], 7);
  served.json("/api/steps/1/collisions");
  EXPECT_EQ(served.json("/api/steps/2/collisions", 404)["error"], all["error"]);
  EXPECT_EQ(served.json("/api/objects/0/frames/3", 500)["error"], all["error"]);
  EXPECT_THAT(served.numbers<float>("/api/objects/0/frames/2"), SizeIs(3 * 24 * 31));
}

TEST(PageAnswers, WhatIsNotCheckedYetIsSaid) {
  const auto page = page_of(two_tubes());  // nobody lets it work
  const Json steps = Json::parse(page->get("/api/steps").body);
  EXPECT_EQ(steps["state"], "running");
  EXPECT_EQ(steps["done"], 0);
  EXPECT_TRUE(steps["start"].is_null());
  for (const char* path : {"/api/steps/6/collisions", "/api/steps/0/faces/1", "/api/start/crossings"}) {
    const PageAnswer answer = page->get(path);
    EXPECT_EQ(answer.status, 425);
    EXPECT_THAT(Json::parse(answer.body)["error"].get<std::string>(), HasSubstr("not checked yet"));
  }
}

TEST(PageAnswers, ModelsTellShapes) {
  const std::vector<double> angles{0.2, 0.5, 0.9, 1.3, 1.6};
  const auto motion = bending_tube(kSmallTube, angles);
  const auto model = std::make_shared<const Model>(trained(*motion));
  ASSERT_TRUE(model->learned);
  const Learned& learned = *model->learned;
  CheckSettings check;
  check.models = {model};
  Served served(page_of(list(bending_tube(kSmallTube, angles)), check));
  const Json answer = served.json("/api/scene")["objects"][0]["model"];
  EXPECT_EQ(answer["modes"], learned.pca.modes());
  EXPECT_EQ(answer["poses"], 5);
  EXPECT_EQ(answer["key_points"], Json(learned.key_points.vertices));
  EXPECT_THAT(answer["energy"], SizeIs(learned.pca.modes()));
  EXPECT_EQ(answer["deviations"][0], learned.pca.deviations[0]);
  const auto floats = [](const Eigen::VectorXd& x) { return std::vector<float>(x.begin(), x.end()); };
  const Json scene = served.json("/api/scene");
  const auto place = [&](const Eigen::VectorXd& x) {
    return single(std::vector<double>(x.begin(), x.end()), scene);
  };
  EXPECT_EQ(served.numbers<float>("/api/objects/0/model/mean"), place(learned.pca.mean));
  for (Index k = 0; k < learned.pca.modes(); ++k) {
    EXPECT_EQ(served.numbers<float>("/api/objects/0/model/modes/" + std::to_string(k)),
              floats(learned.pca.basis.col(k)));
  }
  served.json("/api/objects/0/model/modes/" + std::to_string(learned.pca.modes()), 404);
  const Predictor predictor(model->learned);
  const std::vector<double> x = frame_of(*motion, 2);
  const Eigen::Map<const Eigen::VectorXd> pose(x.data(), static_cast<Eigen::Index>(x.size()));
  EXPECT_EQ(served.numbers<float>("/api/objects/0/prediction/2"),
            place(predictor.from_key_points(predictor.key_point_map().gather(pose))));

  Json radius;
  for (int k = 0; k < 1000 && (radius = served.json("/api/objects/0/model/radius"))["state"] == "computing";
       ++k)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  EXPECT_EQ(radius["state"], "done") << radius;
  EXPECT_EQ(radius["progress"], 1);
  const auto reduced =
      std::make_shared<const ReducedMotion>(*ReducedMotion::make(model->hierarchy(), learned.pca));
  const auto shape = ReducedShape::build(reduced, {{std::vector<double>(reduced->modes(), 0)}});
  ASSERT_TRUE(shape);
  EXPECT_EQ(radius["radius"], shape->radius(0));
  EXPECT_EQ(radius["share"], normal_share(shape->radius(0), reduced->modes()));
  EXPECT_EQ(radius["uncertified"], shape->uncertified(0).size());
  EXPECT_EQ(radius["uncertified_triangles"].empty(), shape->uncertified(0).empty());
}

TEST(PageAnswers, WithoutAModelThereIsNone) {
  Served served(page_of(list(colliding_tube())));
  for (const char* path : {"/api/objects/0/model/mean", "/api/objects/0/model/modes/0",
                           "/api/objects/0/model/radius", "/api/objects/0/prediction/0"}) {
    EXPECT_THAT(served.json(path, 404)["error"].get<std::string>(), HasSubstr("no model"));
  }
}

TEST(PageOpen, SaysWhatDoesNotFit) {
  const auto error_of = [](std::vector<std::unique_ptr<Motion>> motions, CheckSettings check = {}) {
    const auto page = Page::open({std::move(motions), std::move(check), {}});
    EXPECT_FALSE(page);
    return page ? "" : page.error().line();
  };
  EXPECT_THAT(error_of({}), HasSubstr("none given"));
  EXPECT_THAT(error_of(list(colliding_tube(3), colliding_tube(4))), HasSubstr("equally many frames"));
  CheckSettings check;
  check.frames = *parse_frame_range("50:60");
  EXPECT_THAT(error_of(list(colliding_tube()), check), HasSubstr("--frames"));
  check = {};
  check.steps_only = true;
  EXPECT_THAT(error_of(list(colliding_tube(1)), check), HasSubstr("--steps-only"));
  check = {};
  check.models = {std::make_shared<const Model>(small_model())};
  EXPECT_THAT(error_of(list(colliding_tube()), check), HasSubstr("tube"));
  std::vector<std::unique_ptr<Motion>> bad;
  bad.push_back(std::make_unique<UnreadableFrom>(colliding_tube(), 0));
  EXPECT_EQ(error_of(std::move(bad)), "tube, frame 0: is torn; export it again");
}

}  // namespace
}  // namespace foldproof
