// Repairs on request.
#include "page/repaired_report.h"
#include "page/served.h"

namespace foldproof::testing {
namespace {

using ::testing::HasSubstr;

std::vector<std::unique_ptr<Motion>> list(std::unique_ptr<Motion> motion) {
  std::vector<std::unique_ptr<Motion>> motions;
  motions.push_back(std::move(motion));
  return motions;
}

/// Two balls of which the second sinks into the first and comes out again.
std::vector<std::unique_ptr<Motion>> balls() {
  std::vector<std::unique_ptr<Motion>> motions;
  for (const char* name : {"still", "moving"}) {
    std::vector<std::vector<double>> frames;
    for (const double apart : {2.3, 1.95, 1.9, 1.95, 2.3})
      frames.push_back(sphere_at(name == std::string("still") ? 0 : apart));
    std::vector<Triangle> triangles;
    for (Index ring = 0; ring < 12; ++ring) {
      for (Index i = 0; i < 16; ++i) {
        const Index a = 16 * ring + i, b = 16 * ring + (i + 1) % 16;
        triangles.push_back({a, b, b + 16});
        triangles.push_back({a, b + 16, a + 16});
      }
    }
    auto topology = Topology::make(static_cast<Index>(frames[0].size() / 3), std::move(triangles));
    motions.push_back(memory_motion(name, std::move(*topology), std::move(frames)));
  }
  return motions;
}

Json ended(Served& served) {
  for (int k = 0; k < 3000; ++k) {
    Json answer = served.json("/api/repair");
    if (answer["state"] != "queued" && answer["state"] != "running") return answer;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  ADD_FAILURE() << "the repair does not end";
  return {};
}

TEST(PageRepair, MovesWhatMayMoveAndGivesItsFramesAndFiles) {
  Served served(page_of(balls()));
  EXPECT_EQ(served.json("/api/repair")["state"], "idle");
  served.json("/api/objects/1/repaired/2", 404);
  served.json("/api/objects/1/repaired/file", 404);
  served.json("/api/repair/start?fixed=0");
  const Json done = ended(served);
  ASSERT_EQ(done["state"], "done") << done;
  EXPECT_EQ(done["verdict"]["kind"], "free");
  EXPECT_EQ(done["frames"].size(), 5);
  EXPECT_GT(done["frames"][2]["correction"], 0.05);
  EXPECT_EQ(done["files"], Json::parse(R"([{"object": 1, "name": "moving-repaired.npz"}])"));
  EXPECT_EQ(served.numbers<float>("/api/objects/0/repaired/2"),
            served.numbers<float>("/api/objects/0/frames/2"));
  EXPECT_NE(served.numbers<float>("/api/objects/1/repaired/2"),
            served.numbers<float>("/api/objects/1/frames/2"));
  EXPECT_EQ(served.get("/api/objects/1/repaired/file").body.substr(0, 2), "PK");
  served.json("/api/objects/0/repaired/file", 404);  // it may not move
  served.json("/api/objects/2/repaired/0", 404);
  // Both may move: each by about half.
  served.json("/api/repair/start");
  const Json both = ended(served);
  EXPECT_EQ(both["files"].size(), 2);
  EXPECT_LT(both["frames"][2]["correction"], done["frames"][2]["correction"]);
}

/// A third, on the other side.
std::vector<std::unique_ptr<Motion>> row_of_balls() {
  auto motions = balls();
  auto third = balls();
  std::vector<std::vector<double>> frames;
  for (const double apart : {2.3, 1.95, 1.9, 1.95, 2.3}) frames.push_back(sphere_at(-apart));
  motions.push_back(memory_motion("left", Topology(third[0]->topology()), std::move(frames)));
  return motions;
}

TEST(PageRepair, RepairsContactsAlone) {
  Served served(page_of(row_of_balls()));
  served.all_steps();
  const Json contacts = served.json("/api/contacts")["items"];
  ASSERT_EQ(contacts.size(), 2) << contacts;
  served.json("/api/repair/start?contact=2", 404);
  served.json("/api/repair/start?contact=0");
  const Json done = ended(served);
  ASSERT_EQ(done["state"], "done") << done;
  EXPECT_EQ(done["verdict"]["kind"], "limited");
  EXPECT_THAT(done["verdict"]["text"].get<std::string>(), HasSubstr("what was chosen is gone"));
  EXPECT_EQ(done["left"].size(), 1);
  EXPECT_EQ(done["left"][0]["sides"][1]["name"], contacts[1]["sides"][1]["name"]);
  // What was left can be shown.
  const Json left = served.json("/api/repair/contacts");
  EXPECT_EQ(left["total"], 1);
  ASSERT_EQ(left["items"].size(), 1);
  EXPECT_EQ(left["items"][0]["sides"][1]["name"], contacts[1]["sides"][1]["name"]);
  EXPECT_GT(left["items"][0]["sides"][1]["triangles"].size(), 0);
  EXPECT_EQ(served.json("/api/repair/contacts?offset=1")["items"].size(), 0);
  served.json("/api/repair/contacts?limit=a", 400);
}

TEST(PageRepair, HasAReport) {
  PageInput input{balls(), {}, {}};
  input.files.assign(std::begin(kStubPage), std::end(kStubPage));
  input.command = "foldproof view balls";
  auto page = Page::open(std::move(input));
  ASSERT_TRUE(page) << page.error().line();
  Served served(std::move(*page));
  served.json("/api/repair/contacts", 404);
  served.json("/api/repair/report", 404);
  served.json("/api/repair/start?vertices=0:0-9");
  ASSERT_EQ(ended(served)["state"], "done");
  const auto report = served.get("/api/repair/report");
  EXPECT_EQ(report.status, 200);
  EXPECT_EQ(report.get_header_value("Content-Type"), "text/html; charset=utf-8");
  EXPECT_THAT(report.body, HasSubstr("\"command\":\"foldproof view balls\""));
  EXPECT_THAT(report.body, HasSubstr("\"fixed\":[\"10 of the vertices of still\"]"));
}

/// The vertices of an object that the repair moved in the middle frame.
std::vector<Index> moved_vertices(Served& served, Index object) {
  const std::string path = "/api/objects/" + std::to_string(object);
  const auto before = served.numbers<float>(path + "/frames/2");
  const auto after = served.numbers<float>(path + "/repaired/2");
  EXPECT_EQ(before.size(), after.size());
  std::vector<Index> moved;
  for (std::size_t k = 0; k < before.size(); k += 3) {
    if (!std::equal(&before[k], &before[k] + 3, &after[k])) moved.push_back(static_cast<Index>(k / 3));
  }
  return moved;
}

// Both objects have parts of the same names.
TEST(PageRepair, PartsOfOneObjectMayNotMove) {
  constexpr std::size_t kOfRing = 32, kRingsOfCap = 5;  // triangles; rings
  constexpr Index kInCap = (kRingsOfCap + 1) * 16;      // vertices
  CheckSettings settings;
  settings.parts.resize(2);
  for (ObjectParts& parts : settings.parts) {
    parts.names = {"cap", "rest"};
    parts.of_triangle.assign(balls()[0]->topology().triangles().size(), 1);
    std::fill_n(parts.of_triangle.begin(), kRingsOfCap * kOfRing, 0);
  }
  Served served(page_of(balls(), settings));
  EXPECT_EQ(served.json("/api/scene")["parts"], Json::parse(R"([{"object": 0, "name": "cap"},
    {"object": 0, "name": "rest"}, {"object": 1, "name": "cap"}, {"object": 1, "name": "rest"}])"));
  served.json("/api/repair/start?parts=4", 404);
  served.json("/api/repair/start?parts=a", 400);
  served.json("/api/repair/start?fixed=1&parts=0,1");
  EXPECT_THAT(ended(served)["error"].get<std::string>(), HasSubstr("nothing that may move"));
  served.json("/api/repair/start?parts=0");
  const Json done = ended(served);
  ASSERT_EQ(done["verdict"]["kind"], "free") << done;
  const auto first = moved_vertices(served, 0), second = moved_vertices(served, 1);
  ASSERT_FALSE(first.empty() || second.empty());
  EXPECT_GE(first.front(), kInCap);
  EXPECT_LT(second.front(), kInCap);
}

TEST(PageRepair, VerticesMayNotMove) {
  Served served(page_of(balls()));
  EXPECT_THAT(served.json("/api/repair/start?vertices=0:1-a", 400)["error"].get<std::string>(),
              HasSubstr("'vertices' are no vertices of an object: 0:1-a"));
  for (const char* wrong :
       {"2:0", "0:208", "0:0-208", "0:5-4", "0:1-2-3", "0:", "0", ":", "0:0-207,0", "0:1;"})
    served.json(std::string("/api/repair/start?vertices=") + wrong, 400);
  EXPECT_EQ(served.json("/api/repair")["state"], "idle");
  served.json("/api/repair/start?vertices=0:0-207;1:0-150,151-207");
  EXPECT_THAT(ended(served)["error"].get<std::string>(), HasSubstr("nothing that may move"));
  served.json("/api/repair/start?vertices=0:7,0-6,8-95;1:112-207");
  const Json done = ended(served);
  ASSERT_EQ(done["verdict"]["kind"], "free") << done;
  const auto first = moved_vertices(served, 0), second = moved_vertices(served, 1);
  ASSERT_FALSE(first.empty() || second.empty());
  EXPECT_GE(first.front(), 96u);
  EXPECT_LT(second.back(), 112u);
}

// A URL does not hold so many.
TEST(PageRepair, TakesItsParametersFromABody) {
  Served served(page_of(balls()));
  std::string vertices = "vertices=0:0-207;1:0";
  for (Index v = 2; v < 64; v += 2) vertices += "," + std::to_string(v);
  const std::string long_enough = vertices + "&unknown=" + std::string(100'000, 'x');
  const auto started = served.client().Post("/api/repair/start", long_enough, "text/plain");
  ASSERT_TRUE(started && started->status == 200) << started->status;
  const Json done = ended(served);
  ASSERT_EQ(done["state"], "done") << done;
  EXPECT_TRUE(moved_vertices(served, 0).empty());
  const auto moved = moved_vertices(served, 1);
  ASSERT_FALSE(moved.empty());
  for (const Index v : moved) EXPECT_TRUE(v >= 64 || v % 2 == 1) << v;
  const auto wrong = served.client().Post("/api/repair/start", "fixed=a", "text/plain");
  EXPECT_EQ(wrong->status, 400);
  const auto too_long =
      served.client().Post("/api/repair/start", std::string((std::size_t{4} << 20) + 1, 'x'), "text/plain");
  ASSERT_TRUE(too_long && too_long->status == 413);
  EXPECT_THAT(Json::parse(too_long->body)["error"].get<std::string>(), HasSubstr("too many single vertices"));
  httplib::Headers foreign{{"Host", "evil.example"}};
  EXPECT_EQ(served.client().Post("/api/repair/start", foreign, "", "text/plain")->status, 403);
}

TEST(PageRepair, OffersTheFilesOfWhatWasMoved) {
  auto motions = balls();
  std::vector<std::vector<double>> far(5, sphere_at(20));
  motions.push_back(memory_motion("far", Topology(motions[0]->topology()), std::move(far)));
  Served served(page_of(std::move(motions)));
  served.json("/api/repair/start");
  const Json files = ended(served)["files"];
  ASSERT_EQ(files.size(), 2) << files;
  EXPECT_EQ(files[0]["object"], 0);
  EXPECT_EQ(files[1]["object"], 1);
}

TEST(PageRepair, SaysWhatCannotBe) {
  Served served(page_of(balls()));
  EXPECT_THAT(served.json("/api/repair/start?fixed=a", 400)["error"].get<std::string>(),
              HasSubstr("'fixed'"));
  served.json("/api/repair/start?fixed=2", 404);
  served.json("/api/repair/start?fixed=0,1");
  EXPECT_THAT(ended(served)["error"].get<std::string>(), HasSubstr("nothing that may move"));
  CheckSettings poses;
  poses.poses = true;
  Served still(page_of(balls(), poses));
  still.json("/api/repair/start");
  EXPECT_THAT(ended(still)["error"].get<std::string>(), HasSubstr("--static"));
}

TEST(PageRepair, EndsWhenItIsCancelled) {
  Served served(page_of(list(colliding_tube(40))));
  served.json("/api/repair/start");
  EXPECT_EQ(served.json("/api/repair/cancel")["state"], "idle");
  EXPECT_EQ(ended(served)["state"], "idle");
  // And begins again.
  served.json("/api/repair/start");
  served.json("/api/repair/start");
  EXPECT_EQ(ended(served)["state"], "done");
}

// In the middle of a repair, on the thread that computes it.
TEST(PageRepair, OneThatIsCancelledDoesNotGoOnWhenAnotherWaits) {
  std::unique_ptr<Page> page;
  std::vector<int> told{0};  // per repair, how often progress was
  PageInput input{list(colliding_tube(40)), {}, {}};
  input.repair_progress = [&](double) {
    if (++told.back() > 1 || told.size() > 1) return;
    page->get("/api/repair/cancel");
    page->get("/api/repair/start");
  };
  auto opened = Page::open(std::move(input));
  ASSERT_TRUE(opened) << opened.error().line();
  page = std::move(*opened);
  const std::atomic<bool> stop = false;
  while (page->advance(stop)) continue;
  page->get("/api/repair/start");
  EXPECT_TRUE(page->advance(stop));
  told.push_back(0);
  EXPECT_TRUE(page->advance(stop));
  EXPECT_LT(2 * told[0], told[1]);
  EXPECT_EQ(Json::parse(page->get("/api/repair").body)["state"], "done");
}

/// The data of the report of a repair.
Json report_of(Motions motions, const RepairRequest& request, const RepairedMotions& done) {
  const TemporaryDirectory directory;
  const auto written =
      write_repaired_report(directory / "repair.html", motions, request, done, "", kStubPage);
  EXPECT_TRUE(written) << written.error().line();
  const std::string html = read_file(directory / "repair.html"), begin = "id=\"data\">";
  const std::size_t from = html.find(begin) + begin.size();
  return Json::parse(html.substr(from, html.find("</script>", from) - from));
}

// Of many contacts the worst are listed: what a picture says must not depend on that.
TEST(RepairedReport, KnowsWhatRemainsBeyondItsList) {
  const auto motions = balls();
  const RepairRequest request;
  auto done = repair_motions(motions, request);
  ASSERT_TRUE(done && done->report.free && done->report.before.size() == 1);
  EXPECT_EQ(report_of(motions, request, *done)["pictures"][0]["remains"], false);
  const Contact contact = done->report.before[0];
  Contact worse = contact;
  worse.low[0] += 100;
  worse.high[0] += 100;
  for (ContactFrame& frame : worse.frames) frame.depth = 10;
  done->report.remaining.assign(200, worse);
  EXPECT_EQ(report_of(motions, request, *done)["pictures"][0]["remains"], false) << "it is elsewhere";
  done->report.remaining.push_back(contact);
  const Json data = report_of(motions, request, *done);
  EXPECT_EQ(data["repair"]["remaining"].size(), 200);
  EXPECT_EQ(data["repair"]["counts"]["remaining"], 201);
  EXPECT_EQ(data["pictures"][0]["remains"], true);
}

TEST(RepairedReport, HasNoPictureOfFramesThatWereNotWritten) {
  const auto motions = balls();
  const RepairRequest request;
  auto done = repair_motions(motions, request);
  ASSERT_TRUE(done && done->report.free);
  EXPECT_TRUE(report_of(motions, request, *done)["pictures"][0]["after"].is_string());
  done->report.frames.resize(1);  // as if interrupted
  const Json picture = report_of(motions, request, *done)["pictures"][0];
  EXPECT_TRUE(picture["after"].is_null());
  EXPECT_EQ(picture["remains"], false);
}

}  // namespace
}  // namespace foldproof::testing
