// Lines of results, the file that holds them and the page.
#include <gmock/gmock.h>
#include <sys/file.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <nlohmann/json.hpp>

#include "io/npy.h"
#include "report/spheres.h"
#include "sweep/library.h"

namespace {
/// What another sweep does between opening and locking the file.
std::function<void()> before_lock;
}  // namespace

/// Replaces that of the C library.
int flock(int descriptor, int operation) noexcept {
  if (const auto meanwhile = std::exchange(before_lock, {})) meanwhile();
  return static_cast<int>(::syscall(SYS_flock, descriptor, operation));
}

namespace foldproof {
namespace {

using namespace foldproof::testing;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::StartsWith;

TEST(SweepLine, SaysWhatWasFound) {
  const ThreeNeedles library;
  const SweepInput input = library.input();
  const SweepRecord sinking = record_of(*sweep_line(input.motions[0], library.settings));
  EXPECT_EQ(sinking.path, library / "in/a.npz");
  EXPECT_EQ(sinking.state, SweepState::Collides);
  EXPECT_EQ(sinking.collisions, 3u);
  EXPECT_EQ(sinking.steps, 4u);
  EXPECT_EQ(sinking.steps_with_collisions, 2u);
  EXPECT_EQ(sinking.first_frame, 1u);
  EXPECT_EQ(sinking.worst_frame, 2u);
  EXPECT_EQ(sinking.contacts, 1u);
  ASSERT_TRUE(sinking.depth);
  EXPECT_NEAR(*sinking.depth, 0.4, 1e-9);  // at least: both sides are open, and the tip reaches that far
  EXPECT_THAT(sinking.thumbnail, StartsWith("data:image/png;base64,"));
  EXPECT_LT(sinking.thumbnail.size(), 20000u);
  EXPECT_EQ(sinking.vertices, 6u);
  EXPECT_EQ(sinking.triangles, 2u);
  EXPECT_EQ(sinking.frames, 5u);
  EXPECT_EQ(sinking.bytes, std::filesystem::file_size(library / "in/a.npz"));
  const SweepRecord clean = record_of(*sweep_line(input.motions[1], library.settings));
  EXPECT_EQ(clean.state, SweepState::Clean);
  EXPECT_EQ(clean.contacts, 0u);
  EXPECT_THAT(clean.thumbnail, StartsWith("data:image/png;base64,"));
  EXPECT_EQ(record_of(*sweep_line(input.motions[2], library.settings)).state, SweepState::Clean);
  SweepSettings steps;
  steps.check.steps_only = true;
  EXPECT_EQ(record_of(*sweep_line(input.motions[2], steps)).state, SweepState::Still);
}

TEST(SweepLine, WhatCrossesFromTheStartIsNotClean) {
  const Library library;
  ASSERT_TRUE(write_npz(library / "in/apart.npz", *two_spheres(2.5)));
  ASSERT_TRUE(write_npz(library / "in/merged.npz", *two_spheres(1.03)));
  ASSERT_TRUE(write_npz(library / "in/pose.npz", *two_spheres(1.03, 1)));
  const SweepInput input = library.input();
  const auto found = [&](std::size_t motion, const SweepSettings& settings) {
    return record_of(*sweep_line(input.motions[motion], settings));
  };
  EXPECT_EQ(found(0, {}).state, SweepState::Clean);
  EXPECT_EQ(found(0, {}).starts_crossing, 0u);
  EXPECT_EQ(found(1, {}).state, SweepState::Collides);
  EXPECT_GT(found(1, {}).starts_crossing, 10u);
  EXPECT_EQ(found(1, {}).collisions, 0u);
  EXPECT_EQ(found(2, {}).state, SweepState::Collides);
  SweepSettings steps;
  steps.check.steps_only = true;
  EXPECT_EQ(found(1, steps).state, SweepState::Clean);
  EXPECT_EQ(found(1, steps).starts_crossing, std::nullopt);
  EXPECT_NE(settings_hash(steps), settings_hash({}));
}

TEST(SweepLine, ReadsAPairOfArrays) {
  const Library library;
  const auto write = [&](const std::string& name, std::string_view type, std::vector<std::uint64_t> shape,
                         std::span<const char> values) {
    std::ofstream(library / ("in/" + name), std::ios::binary)
        << io::npy_header(type, shape) << std::string_view(values.data(), values.size());
  };
  std::vector<double> frames;
  for (const double height : kSinking) {
    for (const double x : sinking_frame(height)) frames.push_back(x);
  }
  const std::vector<std::int32_t> faces{0, 1, 2, 3, 4, 5};
  write("faces.npy", "<i4", {2, 3}, io::bytes_of(faces));
  write("vertices.npy", "<f8", {kSinking.size(), 6, 3}, io::bytes_of(frames));
  const SweepRecord record = record_of(*sweep_line(library.input().motions.at(0), library.settings));
  EXPECT_EQ(record.path, library / "in/vertices.npy");
  EXPECT_EQ(record.collisions, 3u);
  EXPECT_EQ(record.error, "");
}

TEST(SweepLine, LinesWithoutTheFirstFrameCanBeRead) {
  const SweepRecord record = record_of(
      R"({"path":"x.npz","state":"clean","settings":"0","bytes":1,"modified":1,"seconds":0.5,"vertices":3,)"
      R"("triangles":1,"frames":2,"model":null,"totals":{"steps":1,"steps_with_collisions":0,)"
      R"("collisions":{"vf":0,"ee":0},"earliest":null,"worst":null}})");
  EXPECT_EQ(record.steps, 1u);
  EXPECT_EQ(record.starts_crossing, std::nullopt);
}

TEST(SweepLine, TellsWhetherContactsJoinAllPairs) {
  const ThreeNeedles library;
  const auto line = nlohmann::json::parse(*sweep_line(library.input().motions[0], library.settings));
  EXPECT_FALSE(record_of(line.dump()).contacts_cut);
  auto listed = line;
  listed["totals"]["listed"] = {{"vf", 1}, {"ee", 0}};
  EXPECT_TRUE(record_of(listed.dump()).contacts_cut);
  // Too many triangles cross in a frame.
  auto unknown = line;
  unknown["totals"]["contacts"]["unknown_frames"] = 1;
  EXPECT_TRUE(record_of(unknown.dump()).contacts_cut);
  unknown["totals"]["starts_crossing"] = nullptr;
  EXPECT_FALSE(record_of(unknown.dump()).contacts_cut) << "of --steps-only";
  listed["totals"].erase("contacts");
  EXPECT_FALSE(record_of(listed.dump()).contacts_cut) << "of --static";
}

TEST(SweepLine, SaysWhichFramesWereChecked) {
  ThreeNeedles library;
  const auto frames_checked = [&] {
    return nlohmann::json::parse(*sweep_line(library.input().motions[0], library.settings))["frames_checked"];
  };
  EXPECT_EQ(frames_checked(), (nlohmann::json{{"first", 0}, {"last", 4}, {"step", 1}}));
  library.settings.check.frames = {1, 4, 2};
  EXPECT_EQ(frames_checked(), (nlohmann::json{{"first", 1}, {"last", 3}, {"step", 2}}));
}

/// Answers of the first builds of 0.2.0 could be wrong.
TEST(SweepLine, SettingsHaveTheRevisionOfAnswers) { EXPECT_NE(settings_hash({}), "44240abbf3c0c7bd"); }

TEST(SweepLine, HasTheTotalsOfTheReport) {
  const ThreeNeedles library;
  const auto line = nlohmann::json::parse(*sweep_line(library.input().motions[0], library.settings));
  for (const char* key : {"steps", "steps_with_collisions", "collisions", "earliest", "worst", "tolerance",
                          "milliseconds", "work", "starts_crossing", "steps_expected", "stopped"})
    EXPECT_TRUE(line.at("totals").contains(key)) << key;
}

/// The sinking triangle as the meshes of its five frames.
struct Frames : Library {
  Frames() {
    const auto motion = sinking_triangle(kSinking);
    std::vector<double> x(18);
    for (Index frame = 0; frame < 5; ++frame) {
      EXPECT_TRUE(motion->read_frame(frame, x));
      EXPECT_TRUE(write_obj(*this / ("in/f" + std::to_string(frame) + ".obj"), motion->topology(), x));
    }
  }
};

TEST(SweepLine, TellsOfFramesThatAreMissing) {
  const Frames library;
  EXPECT_THAT(record_of(*sweep_line(library.input().motions.at(0), library.settings)).notes, IsEmpty());
  std::filesystem::remove(library / "in/f2.obj");
  const SweepRecord record = record_of(*sweep_line(library.input().motions.at(0), library.settings));
  const std::string note = "frame numbers jump from 1 to 3: the step between them was not in the files";
  EXPECT_THAT(record.notes, ElementsAre(note));
  ASSERT_TRUE(write_sweep_page(library / "page.html", {&record, 1}, {"", {"in"}, false}));
  EXPECT_THAT(read_file(library / "page.html"), HasSubstr(note));
}

TEST(SweepLine, ReadsFramesOfMeshesAndTellsOfABrokenOne) {
  const Frames library;
  EXPECT_EQ(record_of(*sweep_line(library.input().motions.at(0), library.settings)).collisions, 3u);
  std::ofstream(library / "in/f3.obj") << "f 1 2 3\n";
  const SweepRecord broken = record_of(*sweep_line(library.input().motions.at(0), library.settings));
  EXPECT_EQ(broken.state, SweepState::Failed);
  EXPECT_THAT(broken.error, HasSubstr("in/f3.obj"));
}

TEST(SweepLine, RefusesNumbersThatMayBeNegative) {
  const Frames library;
  for (const char* number : {"1", "2"})
    std::filesystem::rename(library / ("in/f" + std::string(number) + ".obj"),
                            library / ("in/f-" + std::string(number) + ".obj"));
  const SweepRecord refused = record_of(*sweep_line(library.input().motions.at(0), library.settings));
  EXPECT_EQ(refused.state, SweepState::Failed);
  EXPECT_THAT(refused.error, HasSubstr("in/f-1.obj: is sorted before f-2.obj"));
}

TEST(SweepLine, UsesTheModelOfItsMesh) {
  const ThreeNeedles library;
  const auto motion = sinking_triangle(kSinking);
  const TrainPose poses[] = {{motion.get(), 0}};
  auto model = train_model(poses, {.learn = false});
  ASSERT_TRUE(model);
  model->name = "sinking.model";
  const auto other = lone_floor(1);
  const TrainPose floor[] = {{other.get(), 0}};
  auto other_model = train_model(floor, {.learn = false});
  ASSERT_TRUE(other_model);
  SweepSettings settings;
  settings.models = {std::make_shared<const Model>(*other_model), std::make_shared<const Model>(*model)};
  const SweepRecord record = record_of(*sweep_line(library.input().motions[0], settings));
  EXPECT_EQ(record.model, "sinking.model");
  EXPECT_EQ(record.collisions, 3u);
  EXPECT_EQ(settings_hash(settings), settings_hash({}));
}

TEST(SweepLine, IsNoneWhenTheCheckWasCancelled) {
  const ThreeNeedles library;
  const std::atomic<bool> cancel = true;
  CheckHooks hooks;
  hooks.cancel = &cancel;
  EXPECT_FALSE(sweep_line(library.input().motions[0], library.settings, hooks));
}

TEST(SweepFile, ContinuesWhereItStopped) {
  const ThreeNeedles library;
  EXPECT_THAT(library.sweep(), ElementsAre(0, 1, 2));
  const std::string whole = read_file(library.results());
  EXPECT_THAT(library.sweep(), IsEmpty());
  EXPECT_EQ(read_file(library.results()), whole);
  EXPECT_THAT(library.sweep(true), ElementsAre(0, 1, 2));
}

/// For want of memory or permission, say, of which neither the file nor the settings tell.
TEST(SweepFile, ChecksAgainWhatFailed) {
  const ThreeNeedles library;
  library.sweep();
  const SweepInput found = library.input();
  std::filesystem::remove(library.results());
  {
    auto file = library.open(found);
    ASSERT_TRUE(file);
    auto line = nlohmann::json::parse(*sweep_line(found.motions[1], library.settings));
    line["state"] = "failed";
    line["error"] = "memory: there is not enough; check fewer";
    ASSERT_TRUE(file->add(line.dump()));
  }
  EXPECT_THAT(library.sweep(), ElementsAre(0, 1, 2));
  EXPECT_THAT(read_file(library.results()), Not(HasSubstr("not enough")));
  EXPECT_THAT(library.sweep(), IsEmpty());
}

TEST(SweepFile, RepairsATruncatedLastLine) {
  const ThreeNeedles library;
  library.sweep();
  const std::string whole = read_file(library.results());
  const std::size_t last = whole.rfind('\n', whole.size() - 2) + 1;
  for (std::size_t length = last; length < whole.size(); length += 1 + (whole.size() - length) / 40) {
    std::ofstream(library.results()) << whole.substr(0, length);
    const SweepInput input = library.input();
    const auto file = library.open(input);
    ASSERT_TRUE(file) << length << ": " << file.error().line();
    // A line that lacks only its line end is complete.
    const bool lost = length < whole.size() - 1;
    EXPECT_EQ(file->remaining().size(), lost ? 1u : 0u) << length;
    EXPECT_EQ(read_file(library.results()), lost ? whole.substr(0, last) : whole) << length;
  }
}

TEST(SweepFile, ChecksAgainWhatChanged) {
  ThreeNeedles library;
  library.sweep();
  library.add("b.npz", {3, 2, 1, -1});
  EXPECT_THAT(library.sweep(), ElementsAre(1));
  const auto later = std::filesystem::file_time_type::clock::now() + std::chrono::hours(1);
  std::filesystem::last_write_time(library / "in/a.npz", later);
  EXPECT_THAT(library.sweep(), ElementsAre(0));
  // Of the same size, and older than the others: restored from a backup.
  const auto earlier = std::filesystem::file_time_type::clock::now() - std::chrono::hours(1000);
  std::filesystem::last_write_time(library / "in/a.npz", earlier);
  EXPECT_THAT(library.sweep(), ElementsAre(0));
  library.settings.check.step.thickness = 0.1;
  EXPECT_THAT(library.sweep(), ElementsAre(0, 1, 2));
  // Nothing that makes it faster changes an answer.
  library.settings.check.step.certificates = false;
  EXPECT_THAT(library.sweep(), IsEmpty());
  library.settings.check.steps_only = true;
  EXPECT_THAT(library.sweep(), ElementsAre(0, 1, 2));
}

TEST(SweepFile, DropsWhatIsGoneAndKeepsWhatIsElsewhere) {
  const ThreeNeedles library;
  library.sweep();
  const std::string elsewhere =
      R"({"path":"elsewhere/x.npz","state":"still","settings":"0","bytes":1,)"
      R"("modified":1,"seconds":0.5,"vertices":3,"triangles":1,"frames":1,"model":null})";
  std::ofstream(library.results(), std::ios::app) << elsewhere << '\n';
  std::filesystem::remove(library / "in/b.npz");
  EXPECT_THAT(library.sweep(), IsEmpty());
  EXPECT_THAT(read_file(library.results()),
              AllOf(HasSubstr(elsewhere), HasSubstr("in/a.npz"), Not(HasSubstr("in/b.npz"))));
}

TEST(SweepFile, LeavesAloneWhatItDidNotWrite) {
  const ThreeNeedles library;
  for (const std::string text :
       {"my notes", "my notes\n", "{\"path\":1}\n", "{}\n{\"pa", "{\"other\":\"json\"}\n"}) {
    std::ofstream(library.results()) << text;
    const auto file = library.open(library.input());
    ASSERT_FALSE(file) << text;
    EXPECT_THAT(file.error().line(), HasSubstr("is no result of a sweep; name another file"));
    EXPECT_EQ(read_file(library.results()), text);
  }
}

TEST(SweepFile, IsWrittenByOneSweepAtATime) {
  const ThreeNeedles library;
  const SweepInput input = library.input();
  const auto first = library.open(input);
  ASSERT_TRUE(first);
  const auto second = library.open(input);
  ASSERT_FALSE(second);
  EXPECT_THAT(second.error().line(), HasSubstr("another sweep"));
}

TEST(SweepFile, IsTheOneOfItsNameOnceItIsLocked) {
  const ThreeNeedles library;
  library.sweep();
  before_lock = [&] {
    std::filesystem::copy_file(library.results(), library / "new");
    std::filesystem::rename(library / "new", library.results());
  };
  const SweepInput input = library.input();
  const auto file = library.open(input);
  ASSERT_TRUE(file) << file.error().line();
  EXPECT_FALSE(before_lock);
  EXPECT_FALSE(library.open(input)) << "what is locked is the file that another sweep replaced";
}

TEST(SweepFile, ChecksNamesThatAreNoTextEveryTime) {
  const Library library;
  library.add("x\xff.npz", kSinking);
  library.add("x\xfe.npz", {3, 2});
  EXPECT_EQ(library.sweep().size(), 2u);
  EXPECT_EQ(library.sweep().size(), 2u);
  const std::string text = read_file(library.results());
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 2);
}

TEST(SweepPage, ShowsNamesAsText) {
  const TemporaryDirectory directory;
  SweepRecord evil;
  evil.path = "<script>alert(1)</script>&\"\xff.glb";
  evil.error = "a<b";
  SweepRecord bad;
  bad.path = "bad.glb";
  bad.state = SweepState::Collides;
  bad.collisions = 7;
  const SweepRecord records[] = {evil, bad};
  ASSERT_TRUE(
      write_sweep_page(directory / "page.html", records, {"foldproof sweep '<x>'", {"<dir>"}, false}));
  const std::string page = read_file(directory / "page.html");
  EXPECT_THAT(page, AllOf(StartsWith("<!doctype html>"), EndsWith("</html>\n")));
  EXPECT_THAT(page, HasSubstr("&lt;script&gt;alert(1)&lt;/script&gt;&amp;&quot;\xef\xbf\xbd.glb"));
  EXPECT_THAT(page, AllOf(HasSubstr("a&lt;b"), HasSubstr("'&lt;x&gt;'"), HasSubstr("<h1>&lt;dir&gt;</h1>")));
  EXPECT_THAT(page, Not(HasSubstr("<script>alert")));
  EXPECT_LT(page.find("bad.glb"), page.find("alert(1)")) << "what collides comes first";
}

TEST(SweepPage, HasAColumnForWhatCrossesInTheFirstFrame) {
  const TemporaryDirectory directory;
  SweepRecord starts;
  starts.path = "merged.npz";
  starts.state = SweepState::Collides;
  starts.starts_crossing = 312;
  ASSERT_TRUE(write_sweep_page(directory / "page.html", std::span(&starts, 1), {"", {"lib"}}));
  std::string page = read_file(directory / "page.html");
  EXPECT_THAT(page, HasSubstr("<th>crossing pairs of the first frame</th><th>colliding pairs</th>"));
  EXPECT_THAT(page, HasSubstr("<td class=\"starts\" data-v=\"312\">312</td><td data-v=\"0\">0</td>"));
  EXPECT_THAT(page, Not(HasSubstr("Only the ")));

  starts.starts_crossing.reset();
  starts.state = SweepState::Clean;
  ASSERT_TRUE(
      write_sweep_page(directory / "page.html", std::span(&starts, 1), {"", {"lib"}, false, true, "::2"}));
  page = read_file(directory / "page.html");
  EXPECT_THAT(page, HasSubstr("Only the frames ::2 of each motion were checked"));
  EXPECT_THAT(page, HasSubstr("1 in whose steps no contact begins"));
  EXPECT_THAT(page, HasSubstr("Only the steps were checked"));
  EXPECT_THAT(page, Not(HasSubstr("Only the frames were checked")));
  ASSERT_TRUE(write_sweep_page(directory / "page.html", std::span(&starts, 1), {"", {"lib"}, true}));
  EXPECT_THAT(read_file(directory / "page.html"),
              HasSubstr("Only the frames were checked: motion between them was not tested."));
}

TEST(SweepPage, SaysInHowManyMotionsContactsDoNotJoinAllPairs) {
  const TemporaryDirectory directory;
  std::vector<SweepRecord> records(3);
  const auto page = [&] {
    EXPECT_TRUE(write_sweep_page(directory / "page.html", records, {"", {"lib"}}));
    return read_file(directory / "page.html");
  };
  EXPECT_THAT(page(), Not(HasSubstr("leave out")));
  records[1].contacts_cut = true;
  EXPECT_THAT(page(), HasSubstr("<p>Contacts leave out pairs in 1 motion: more than a million of a "));
  records[2].contacts_cut = true;
  EXPECT_THAT(page(), HasSubstr("pairs in 2 motions: "));
}

TEST(SweepPage, ShowsContactsTheDeepestFirst) {
  const TemporaryDirectory directory;
  SweepRecord many;
  many.path = "many.npz";
  many.state = SweepState::Collides;
  many.collisions = 1'234'567;
  many.contacts = 1021;
  SweepRecord deep;
  deep.path = "deep.npz";
  deep.state = SweepState::Collides;
  deep.collisions = 3;
  deep.contacts = 1;
  deep.depth = 0.0456789;
  deep.thumbnail = "data:image/png;base64,QUJD";
  const SweepRecord records[] = {many, deep};
  ASSERT_TRUE(write_sweep_page(directory / "page.html", records, {"", {"lib"}}));
  const std::string page = read_file(directory / "page.html");
  EXPECT_LT(page.find("deep.npz"), page.find("many.npz"));
  EXPECT_THAT(page, HasSubstr("<th>contacts</th><th>deepest</th>"));
  EXPECT_THAT(page, HasSubstr("<td data-v=\"1021\">1,021</td><td data-v=\"-1\"></td>"));
  EXPECT_THAT(page, HasSubstr("<td data-v=\"1\">1</td><td data-v=\"0.0456789\">0.0457</td>"));
  EXPECT_THAT(page, HasSubstr("<td data-v=\"1234567\">1,234,567</td>"));
  EXPECT_THAT(page, HasSubstr("<img src=\"data:image/png;base64,QUJD\" alt=\"\">deep.npz"));
  EXPECT_THAT(page, HasSubstr("img-src data:"));
}

TEST(SweepPage, SortsNumbersByTheirValue) {
  if (!std::filesystem::exists("/usr/bin/chromium")) GTEST_SKIP() << "Chromium is not installed.";
  const TemporaryDirectory directory;
  std::vector<SweepRecord> records(5);
  const std::optional<double> depths[] = {0.5, 0.12, 0.0843, 2e-7, std::nullopt};
  for (std::size_t i = 0; i < records.size(); ++i) {
    records[i].path = "run" + std::to_string(12 - i);
    records[i].depth = depths[i];
    records[i].seconds = 0.001 * static_cast<double>(5 - i);
  }
  ASSERT_TRUE(write_sweep_page(directory / "page.html", records, {}));
  const std::string page = read_file(directory / "page.html");
  /// The names in the order after a click on a heading.
  const auto clicked = [&](const std::string& heading) {
    // The policy, which permits no other script, is removed.
    std::string changed = page;
    changed.erase(changed.find("<meta http-equiv"),
                  changed.find("<title>") - changed.find("<meta http-equiv"));
    changed += "<script>[...document.querySelectorAll('th')].find((head) => head.textContent === '" +
               heading +
               "').click(); document.title = 'order ' + [...document.querySelectorAll('tbody tr')].map("
               "(row) => row.cells[0].textContent).join(' ');</script>";
    std::ofstream(directory / "clicked.html") << changed;
    const std::string command =
        "/usr/bin/chromium --headless --no-sandbox --disable-gpu --dump-dom "
        "--user-data-dir=" +
        (directory / "profile") + " file://" + (directory / "clicked.html") + " > " +
        (directory / "dom.html") + " 2>&1";
    EXPECT_EQ(std::system(command.c_str()), 0);
    const std::string dom = read_file(directory / "dom.html");
    const std::size_t begin = dom.find("<title>") + 7;
    return dom.substr(begin, dom.find("</title>") - begin);
  };
  EXPECT_EQ(clicked("deepest"), "order run8 run9 run10 run11 run12");
  EXPECT_EQ(clicked("seconds"), "order run8 run9 run10 run11 run12");
  EXPECT_EQ(clicked("motion"), "order run8 run9 run10 run11 run12");
}

TEST(SweepPage, NamesTheHashOfItsScript) {
  const TemporaryDirectory directory;
  ASSERT_TRUE(write_sweep_page(directory / "page.html", {}, {}));
  std::ofstream(directory / "hash.py")
      << "import sys, re, hashlib, base64\n"
         "page = open(sys.argv[1]).read()\n"
         "script = re.search('<script>(.*?)</script>', page, re.S).group(1)\n"
         "digest = hashlib.sha256(script.encode()).digest()\n"
         "sys.exit('sha256-' + base64.b64encode(digest).decode() not in page)\n";
  EXPECT_EQ(std::system(("python3 " + (directory / "hash.py") + " " + (directory / "page.html")).c_str()), 0);
}

}  // namespace
}  // namespace foldproof
