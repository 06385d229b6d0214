// The report to mail: one file, whole or not at all.
#include <regex>

#include "page/served.h"

namespace foldproof {
namespace {

using namespace foldproof::testing;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;
using ::testing::StartsWith;

constexpr const char* kNasty = "</script><script>alert(1)</script><b title=\"x\">&\xff\n.npz";

/// A report of a motion, and what the check said.
struct Reported : TemporaryDirectory {
  explicit Reported(std::vector<std::unique_ptr<Motion>> given, CheckSettings settings = {},
                    std::span<const PageFile> files = kStubPage)
      : motions(std::move(given)) {
    settings.step.explain = true;
    writers.push_back(nullptr);
    auto writer =
        page_report(*this / "report.html", motions, {{settings, {}}, "foldproof report '</script>'"}, files);
    if (!writer) {
      error = writer.error().line();
      return;
    }
    writers[0] = std::move(*writer);
    const auto done = run_check(motions, settings, writers);
    if (!done) {
      error = done.error().line();
      return;
    }
    totals = *done;
    html = read_file(*this / "report.html");
  }

  /// The JSON that the page's script reads.
  Json data() const {
    const std::string begin = "<script type=\"application/json\" id=\"data\">";
    const std::size_t from = html.find(begin) + begin.size();
    return Json::parse(html.substr(from, html.find("</script>", from) - from));
  }

  std::vector<std::unique_ptr<Motion>> motions;
  std::vector<std::unique_ptr<ReportWriter>> writers;
  CheckTotals totals;
  std::string error, html;
};

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t found = 0;
  for (std::size_t at = text.find(part); at != text.npos; at = text.find(part, at + 1)) ++found;
  return found;
}

TEST(HtmlReport, HoldsWhatTheCheckFound) {
  const Reported reported(list(colliding_tube()));
  ASSERT_EQ(reported.error, "");
  const Json data = reported.data();
  EXPECT_EQ(data["program"], "foldproof");
  EXPECT_EQ(data["version"], version());
  EXPECT_TRUE(
      std::regex_match(data["made"].get<std::string>(), std::regex(R"(\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ)")));
  EXPECT_EQ(data["command"], "foldproof report '</script>'");
  EXPECT_EQ(data["objects"][0]["name"], "tube");
  EXPECT_EQ(data["objects"][0]["frames"], 8);
  EXPECT_TRUE(data["objects"][0]["model"].is_null());
  EXPECT_EQ(data["settings"]["substeps"], 1);
  EXPECT_EQ(data["totals"]["steps"], 7);
  EXPECT_EQ(data["totals"]["steps_with_collisions"], reported.totals.steps_with_collisions);
  EXPECT_EQ(data["totals"]["collisions"]["ee"], reported.totals.collisions.edge_edge);
  EXPECT_EQ(data["totals"]["worst"]["frame"], reported.totals.worst->frame);
  EXPECT_EQ(data["totals"]["earliest"]["toi"], reported.totals.earliest_toi);
  EXPECT_THAT(data["notes"], IsEmpty());
  ASSERT_THAT(data["steps"], SizeIs(7));
  std::uint64_t vertex_face = 0, leaf_pairs = 0;
  for (const Json& step : data["steps"]) {
    vertex_face += step["vertex_face"].get<std::uint64_t>();
    leaf_pairs += step["leaf_pairs"].get<std::uint64_t>();
    EXPECT_THAT(step["reasons"], SizeIs(kReasonNames.size()));
  }
  EXPECT_GT(vertex_face, 0u);
  EXPECT_EQ(vertex_face, reported.totals.collisions.vertex_face);
  EXPECT_EQ(leaf_pairs, reported.totals.work.leaf_pairs);
}

constexpr const char* kPng = "data:image/png;base64,iVBORw0KGgo";

TEST(HtmlReport, ShowsContactsTheWorstFirst) {
  const Reported reported(list(colliding_tube(12)));
  const Json data = reported.data();
  ASSERT_FALSE(reported.totals.contacts.empty());
  ASSERT_THAT(data["contacts"], SizeIs(std::min<std::size_t>(200, reported.totals.contacts.size())));
  EXPECT_EQ(data["totals"]["contacts"]["count"], reported.totals.contacts.size());
  for (std::size_t k = 0; k < data["contacts"].size(); ++k) {
    const Json& contact = data["contacts"][k];
    EXPECT_EQ(contact["number"], reported.totals.contacts[k].number);
    EXPECT_EQ(contact["sides"][0]["name"], "tube");
    ASSERT_EQ(contact.contains("picture"), k < 10);
    if (k < 10) {
      EXPECT_THAT(contact["picture"].get<std::string>(), StartsWith(kPng));
    }
  }
  EXPECT_TRUE(data["picture"].is_null());
}

TEST(HtmlReport, ShowsAFreeMotion) {
  const Reported reported(list(bending_tube(kSmallTube, {0.1, 0.2, 0.3})));
  const Json data = reported.data();
  EXPECT_TRUE(reported.totals.clean());
  EXPECT_TRUE(data["totals"]["worst"].is_null());
  EXPECT_THAT(data["contacts"], IsEmpty());
  EXPECT_THAT(data["picture"].get<std::string>(), StartsWith(kPng));
}

TEST(HtmlReport, ShowsWhatCrossesFromTheStart) {
  const Reported reported(sphere_pair(4));
  ASSERT_EQ(reported.error, "");
  EXPECT_FALSE(reported.totals.clean());
  EXPECT_EQ(reported.totals.collisions.sum(), 0u);
  const Json data = reported.data();
  EXPECT_EQ(data["start"]["frame"], 0);
  EXPECT_EQ(data["start"]["crossings"], *reported.totals.starts_crossing);
  EXPECT_EQ(data["totals"]["stopped"], false);
  EXPECT_EQ(data["totals"]["steps_expected"], 3);
  ASSERT_THAT(data["contacts"], SizeIs(1));
  EXPECT_EQ(data["contacts"][0]["from_start"], true);
  EXPECT_THAT(data["contacts"][0]["picture"].get<std::string>(), StartsWith(kPng));
}

/// Surfaces that touch on the way from a frame to the next cross in none, but have a picture.
TEST(HtmlReport, ShowsWhatTouchesBetweenFrames) {
  std::vector<std::vector<double>> frames{sinking_frame(1), sinking_frame(-1)};
  CheckSettings settings;
  settings.substeps = 3;
  const Reported reported(
      list(memory_motion("sinking", *Topology::make(6, {{0, 1, 2}, {3, 4, 5}}), std::move(frames))),
      settings);
  ASSERT_EQ(reported.error, "");
  const Json data = reported.data();
  ASSERT_THAT(data["contacts"], Not(IsEmpty()));
  EXPECT_THAT(data["contacts"][0]["picture"].get<std::string>(), StartsWith(kPng));
}

TEST(HtmlReport, IsCompleteWithoutPictures) {
  std::vector<std::vector<double>> frames{sinking_frame(1), sinking_frame(-1)};
  for (std::vector<double>& frame : frames) {
    for (double& x : frame) x *= 1e200;
  }
  const Reported reported(
      list(memory_motion("huge", *Topology::make(6, {{0, 1, 2}, {3, 4, 5}}), std::move(frames))));
  if (reported.error.empty()) {
    EXPECT_THAT(reported.data()["notes"][0].get<std::string>(), StartsWith("Pictures are missing: "));
  }
}

TEST(HtmlReport, WithStepsOnlyClaimsNothingOfTheStart) {
  CheckSettings settings;
  settings.steps_only = true;
  const Reported reported(sphere_pair(3), settings);
  const Json data = reported.data();
  EXPECT_TRUE(data["start"].is_null());
  EXPECT_EQ(data["settings"]["steps_only"], true);
  EXPECT_THAT(data["contacts"], IsEmpty());
  EXPECT_THAT(data["notes"][0].get<std::string>(), HasSubstr("--steps-only"));
}

/// Forwards to another writer, but claims at the end that more steps were expected.
class CancelledReport final : public ReportWriter {
 public:
  explicit CancelledReport(std::unique_ptr<ReportWriter> writer) : writer_(std::move(writer)) {}
  Result<void> start(const CheckedStep& pose) override { return writer_->start(pose); }
  Result<void> step(const CheckedStep& step) override { return writer_->step(step); }
  Result<void> finish(const CheckTotals& whole) override {
    CheckTotals totals = whole;
    totals.cancelled = true;
    totals.steps_expected = 7200;
    return writer_->finish(totals);
  }

 private:
  std::unique_ptr<ReportWriter> writer_;
};

TEST(HtmlReport, ReportsHowFarACancelledCheckCame) {
  const TemporaryDirectory directory;
  const auto motions = sphere_pair(4, 2.5);
  CheckSettings settings;
  settings.step.explain = true;
  auto writer = page_report(directory / "report.html", motions, {{settings, {}}, ""}, kStubPage);
  ASSERT_TRUE(writer);
  const std::unique_ptr<ReportWriter> writers[] = {std::make_unique<CancelledReport>(std::move(*writer))};
  ASSERT_TRUE(run_check(motions, settings, writers));
  const std::string html = read_file(directory / "report.html");
  EXPECT_THAT(html, HasSubstr("\"stopped\":true"));
  EXPECT_THAT(html, HasSubstr("\"steps_expected\":7200"));
}

TEST(HtmlReport, ReportsCrossingsOfASingleFrame) {
  const Reported reported(sphere_pair(1));
  ASSERT_EQ(reported.error, "");
  const Json data = reported.data();
  EXPECT_GT(data["start"]["crossings"], 0);
  EXPECT_THAT(data["steps"], SizeIs(1));
}

TEST(HtmlReport, ShowsPosesOfAStaticCheck) {
  CheckSettings settings;
  settings.poses = true;
  const Reported reported(sphere_pair(3), settings);
  ASSERT_EQ(reported.error, "");
  const Json data = reported.data();
  EXPECT_EQ(data["settings"]["static"], true);
  EXPECT_TRUE(data["start"].is_null());
  EXPECT_EQ(data["totals"]["collisions"]["tt"], reported.totals.collisions.triangle_triangle);
  ASSERT_THAT(data["steps"], SizeIs(3));
  for (const Json& step : data["steps"]) {
    EXPECT_GT(step["crossings"], 0);
    EXPECT_EQ(step["frame"], step["next_frame"]);
  }
  ASSERT_THAT(data["contacts"], SizeIs(1));
  EXPECT_THAT(data["contacts"][0]["picture"].get<std::string>(), StartsWith(kPng));
  EXPECT_THAT(data["notes"], IsEmpty());
}

TEST(HtmlReport, NamesAreEscaped) {
  std::vector<std::vector<double>> frames{sinking_frame(1), sinking_frame(-1)};
  const Reported reported(
      list(memory_motion(kNasty, *Topology::make(6, {{0, 1, 2}, {3, 4, 5}}), std::move(frames))));
  ASSERT_EQ(reported.error, "");
  EXPECT_EQ(reported.data()["objects"][0]["name"],
            "</script><script>alert(1)</script><b title=\"x\">&\xef\xbf\xbd\n.npz");
  // The report's own two elements, and none from the name.
  EXPECT_EQ(count(reported.html, "<script"), 2u);
  EXPECT_EQ(count(reported.html, "</script"), 2u);
  EXPECT_EQ(count(reported.html, "<b"), 1u) << "the body";
  EXPECT_THAT(reported.html, HasSubstr("<title>script>&lt;b title=\"x\">&amp;")) << "the last part of a path";
  // The hash is that of the script; nothing may be loaded.
  EXPECT_THAT(reported.html, HasSubstr("default-src 'none'; script-src 'sha256-c3R1Yg=='; style-src"));
  EXPECT_THAT(reported.html, HasSubstr("<script>'report'</script>"));
  EXPECT_THAT(reported.html, HasSubstr("<style>body{}</style>"));
}

TEST(HtmlReport, IsCompleteOrAbsent) {
  std::vector<std::unique_ptr<Motion>> motions;
  motions.push_back(std::make_unique<UnreadableFrom>(colliding_tube(), 5));
  const Reported torn(std::move(motions));
  EXPECT_EQ(torn.error, "tube, frame 5: is torn; export it again");
  EXPECT_THAT(torn.names(), Not(::testing::Contains("report.html")));
  const Reported without(list(colliding_tube(3)), {}, std::span(kStubPage).first(2));
  EXPECT_THAT(without.error, HasSubstr("report/report.js: is missing"));
  EXPECT_THAT(without.names(), IsEmpty());
}

}  // namespace
}  // namespace foldproof
