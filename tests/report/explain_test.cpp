// Explain reports: npz, csv and ply.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cstring>
#include <map>
#include <numeric>
#include <sstream>

#include "bvh/meshes.h"
#include "report/needle.h"

namespace foldproof {
namespace {

using namespace foldproof::testing;
using ::testing::AllOf;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::SizeIs;

constexpr std::size_t kFrames = 8;

/// A sheet that ripples a little.
std::unique_ptr<Motion> ripple(Index side, double height) {
  const auto sheet = cloth(side);
  std::vector<std::vector<double>> frames;
  for (std::size_t k = 0; k < kFrames; ++k) {
    frames.push_back(sheet.positions);
    for (std::size_t i = 0; i < frames[k].size(); i += 3)
      frames[k][i + 2] = height + 0.1 * std::sin(5 * frames[k][i] + 0.1 * static_cast<double>(k));
  }
  return memory_motion("ripple", sheet.topology, std::move(frames));
}

/// A check with an explain report, and its output.
struct Checked {
  Checked(Motions motions, const std::string& name, CheckSettings settings = {}) : path(directory / name) {
    settings.step.explain = true;
    auto writer = explain_report(path, motions, settings);
    EXPECT_TRUE(writer) << (writer ? "" : writer.error().line());
    if (!writer) return;
    std::vector<std::unique_ptr<ReportWriter>> writers;
    writers.push_back(std::move(*writer));
    auto done = run_check(motions, settings, writers);
    EXPECT_TRUE(done);
    if (done) totals = *done;
  }
  const TemporaryDirectory directory;
  const std::string path;
  CheckTotals totals;
};

/// The rows of a file without its head, split at commas.
std::vector<std::vector<std::string>> rows(const std::string& path, const std::string& head) {
  std::istringstream file(read_file(path));
  std::string line;
  std::getline(file, line);
  EXPECT_EQ(line, head);
  std::vector<std::vector<std::string>> rows;
  while (std::getline(file, line)) {
    std::istringstream cells(line);
    rows.emplace_back();
    while (std::getline(cells, line, ',')) rows.back().push_back(line);
  }
  return rows;
}

TEST(ExplainReport, CsvCountsEveryTriangleAndLeafPair) {
  const auto motions = list(ripple(16, 0), ripple(20, 0.05));
  const Checked checked(motions, "a.csv");
  std::map<std::pair<std::string, std::string>, std::uint64_t> triangles;  // by frame and object
  std::map<std::string, std::uint64_t> pairs;                              // by reason
  for (const auto& row : rows(checked.path, "frame,substep,kind,object,reason,level,count")) {
    ASSERT_THAT(row, SizeIs(7));
    EXPECT_EQ(row[1], "0");
    const std::uint64_t count = std::stoull(row[6]);
    EXPECT_GT(count, 0u);
    if (row[2] == "triangles") {
      triangles[{row[0], row[3]}] += count;
    } else {
      EXPECT_EQ(row[2], "leaf_pairs");
      EXPECT_EQ(row[3] + row[5], "");
      pairs[row[4]] += count;
    }
  }
  ASSERT_THAT(triangles, SizeIs(2 * (kFrames - 1)));
  for (const auto& [key, count] : triangles) EXPECT_EQ(count, key.second == "0" ? 512u : 800u);
  std::uint64_t tested = 0;
  for (std::size_t i = 0; i < kReasonNames.size(); ++i) {
    EXPECT_EQ(pairs[kReasonNames[i]], checked.totals.leaf_pairs[i]) << kReasonNames[i];
    if (i > 0) tested += checked.totals.leaf_pairs[i];
  }
  EXPECT_EQ(tested, checked.totals.work.leaf_pairs);
  EXPECT_GT(pairs["certified"], tested);
}

/// The data of an array that is stored uncompressed.
std::string array_of(const std::string& archive, const std::string& name) {
  const std::size_t named = archive.find(name + ".npy");
  if (named == archive.npos) return {};
  const std::size_t start = named + name.size() + 4 + 20;  // the name, then the extra field
  const auto byte = [&](std::size_t at) { return static_cast<unsigned char>(archive[at]); };
  const std::size_t head = 10 + byte(start + 8) + 256u * byte(start + 9);
  const std::string text = archive.substr(start, head);
  std::size_t items = 1;
  std::istringstream shape(text.substr(text.find("'shape': (") + 10));
  for (std::size_t n = 0; shape >> n; shape.ignore(1)) items *= n;
  return archive.substr(start + head, items * (text.find("'<") != text.npos ? 4 : 1));
}

TEST(ExplainReport, NpzHoldsEveryTriangleAndStep) {
  CheckSettings settings;
  settings.substeps = 2;
  const auto motions = list(ripple(16, 0), ripple(20, 1));
  const Checked all(motions, "a.npz", settings);
  const Checked counts(motions, "a.csv", settings);
  const std::string archive = read_file(all.path);
  const std::size_t steps = 2 * (kFrames - 1);
  const std::string frames = array_of(archive, "frame"), substeps = array_of(archive, "substep");
  ASSERT_THAT(frames, SizeIs(4 * steps));
  ASSERT_THAT(substeps, SizeIs(4 * steps));
  std::map<std::string, int> counted, reported;
  std::size_t with_margin = 0;
  for (const std::string object : {"0", "1"}) {
    const std::string level = array_of(archive, "level_" + object),
                      margin = array_of(archive, "margin_" + object),
                      reason = array_of(archive, "reason_" + object);
    const std::size_t triangles = object == "0" ? 512 : 800;
    ASSERT_THAT(level, SizeIs(steps * triangles));
    ASSERT_THAT(margin, SizeIs(4 * steps * triangles));
    ASSERT_THAT(reason, SizeIs(steps * triangles));
    for (std::size_t i = 0; i < level.size(); ++i) {
      const std::size_t step = i / triangles;
      const char* name = kReasonNames.at(static_cast<unsigned char>(reason[i]));
      float share = -1;
      std::memcpy(&share, &margin[4 * i], sizeof share);
      EXPECT_TRUE(share >= 0 && share <= 1 && (share == 0 || level[i] >= 0)) << share;
      with_margin += share > 0;
      ++counted[fmt::format("{} {} {} {} {}", int{frames[4 * step]}, int{substeps[4 * step]}, object, name,
                            int{level[i]})];
    }
  }
  for (const auto& row : rows(counts.path, "frame,substep,kind,object,reason,level,count")) {
    if (row[2] != "triangles") continue;
    reported[fmt::format("{} {} {} {} {}", row[0], row[1], row[3], row[4], row[5])] = std::stoi(row[6]);
  }
  EXPECT_EQ(counted, reported);
  EXPECT_GT(with_margin, 0u);
  // With one object the arrays have plain names.
  const Checked single(list(ripple(8, 0)), "a.npz");
  EXPECT_THAT(array_of(read_file(single.path), "level"), SizeIs(128 * (kFrames - 1)));
}

/// The five properties per face of a PLY, which ends with records of 18 bytes.
std::vector<std::string> face_values(const std::string& path, std::size_t faces) {
  const std::string bytes = read_file(path);
  EXPECT_THAT(bytes, HasSubstr("property char level\nproperty uchar reason\nproperty uchar red\n"
                               "property uchar green\nproperty uchar blue\nend_header\n"));
  std::vector<std::string> values;
  for (std::size_t face = 0; face < faces && bytes.size() > faces * 18; ++face)
    values.push_back(bytes.substr(bytes.size() - 18 * (faces - face) + 13, 5));
  return values;
}

TEST(ExplainReport, PlyShowsAStepInColor) {
  CheckSettings settings;
  settings.frames = *parse_frame_range("0:2");
  const Checked checked(list(ripple(4, 0), ripple(6, 1)), "a.ply", settings);
  // In the first step nothing has been tried yet.
  EXPECT_THAT(face_values(checked.path, 104), AllOf(SizeIs(104), Each("\xff\x01\xf0\xe4\x42")));
  const std::vector<std::string> names{checked.path};
  const auto back = open_motions(names);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->front()->topology().triangles().size(), 104u);
}

TEST(ExplainReport, PlyShowsTheWorstStep) {
  const auto motions = list(ripple(16, 0), ripple(20, 0.05));
  const Checked picture(motions, "a.ply"), counts(motions, "a.csv");
  std::map<std::string, int> tested;                            // by frame
  std::map<std::string, std::map<std::string, int>> triangles;  // by frame and reason
  for (const auto& row : rows(counts.path, "frame,substep,kind,object,reason,level,count")) {
    if (row[2] == "triangles") triangles[row[0]][row[4]] += std::stoi(row[6]);
    if (row[2] == "leaf_pairs" && row[4] != "certified" && row[4] != "not_built")
      tested[row[0]] += std::stoi(row[6]);
  }
  const auto worst = std::max_element(tested.begin(), tested.end(),
                                      [](const auto& a, const auto& b) { return a.second < b.second; });
  ASSERT_NE(worst, tested.end());
  std::map<std::string, int> shown;
  for (const std::string& values : face_values(picture.path, 1312))
    ++shown[kReasonNames.at(static_cast<unsigned char>(values[1]))];
  EXPECT_EQ(shown, triangles[worst->first]);
  EXPECT_GT(shown["near_other"], 0);
  EXPECT_GT(shown["certified"], 0);
}

TEST(ExplainReport, PosesAreExplainedAsWell) {
  CheckSettings settings;
  settings.poses = true;
  const Checked checked(list(ripple(16, 0)), "a.csv", settings);
  EXPECT_GT(checked.totals.leaf_pairs[0], 0u);
  EXPECT_EQ(std::accumulate(checked.totals.leaf_pairs.begin() + 1, checked.totals.leaf_pairs.end(),
                            std::uint64_t{0}),
            checked.totals.work.leaf_pairs);
}

TEST(ExplainReport, RefusesWhatItCannotWrite) {
  const auto motions = list(needle(kSinking));
  CheckSettings settings;
  EXPECT_FALSE(explain_report("a.csv", motions, settings)) << "the steps have no explanation";
  settings.step.explain = true;
  for (const char* path : {"a.txt", "a", "npz", "a.npz/b", "no/where.npz", "no/where.csv", "no/where.ply"}) {
    const auto writer = explain_report(path, motions, settings);
    ASSERT_FALSE(writer) << path;
    EXPECT_THAT(writer.error().line(), HasSubstr(path));
  }
}

TEST(ExplainReport, LeavesNoFileUnlessFinished) {
  const TemporaryDirectory directory;
  const auto motions = list(needle(kSinking));
  CheckSettings settings;
  settings.step.explain = true;
  const std::atomic<bool> stop{true};
  CheckHooks hooks;
  hooks.cancel = &stop;
  {
    std::vector<std::unique_ptr<ReportWriter>> writers;
    for (const char* name : {"a.npz", "a.csv", "a.ply"}) {
      auto writer = explain_report(directory / name, motions, settings);
      ASSERT_TRUE(writer);
      writers.push_back(std::move(*writer));
    }
    ASSERT_TRUE(run_check(motions, settings, writers, hooks));
  }
  EXPECT_THAT(directory.names(), ElementsAre());
}

}  // namespace
}  // namespace foldproof
