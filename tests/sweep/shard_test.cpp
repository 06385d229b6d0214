// Which motions a shard has, the file of a shard, and joining all.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "report/without_times.h"
#include "sweep/library.h"
#include "sweep/shard.h"

namespace foldproof {
namespace {

using namespace foldproof::testing;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::vector<std::uint32_t> shards_of(const std::vector<std::string>& paths, std::uint32_t count) {
  std::vector<std::uint32_t> shards;
  for (const std::string& path : paths) shards.push_back(shard_of(path, count));
  return shards;
}

TEST(Shard, IsReadFromText) {
  const auto shard = parse_shard("2/4");
  ASSERT_TRUE(shard);
  EXPECT_EQ(name_of(*shard), "2/4");
  EXPECT_TRUE(parse_shard("1/1"));
  EXPECT_TRUE(parse_shard("1000000/1000000"));
  for (const char* text : {"", "/", "2", "2/", "/4", "0/4", "5/4", "-1/4", "+1/4", "1/0", "1/4 ", " 1/4",
                           "1 /4", "1/4/4", "1.0/4", "a/b", "1/1000001", "1/99999999999", "99999999999/4"}) {
    const auto refused = parse_shard(text);
    ASSERT_FALSE(refused) << text;
    EXPECT_EQ(
        refused.error().line(),
        fmt::format("--shard: '{}' is no shard; give I/N with I from 1 to N, and N up to 1000000; add 1 to "
                    "an I that counts from 0",
                    text));
  }
}

/// Machines that work on one sweep must agree, and so must versions that continue it.
TEST(Shard, OfAMotionIsTheSameEverywhere) {
  const std::vector<std::string> paths = {"lib/walk.glb", "lib/a/run1.npz", "x\xff.npz", "frames"};
  EXPECT_THAT(shards_of(paths, 4), ElementsAre(2, 3, 3, 1));
  EXPECT_THAT(shards_of(paths, 1000), ElementsAre(306, 503, 891, 9));
}

TEST(Shard, HasItsPartOfRegularNames) {
  std::vector<std::string> numbers, twice, files;
  for (int k = 0; k < 1000; ++k) {
    numbers.push_back(fmt::format("lib/run{}", k));
    twice.push_back(fmt::format("lib/{0}/{0}.glb", k));
    files.push_back(fmt::format("lib/{:04}.npz", k));
  }
  for (const auto& paths : {numbers, twice, files}) {
    for (const std::uint32_t count : {2u, 4u, 10u}) {
      const auto shards = shards_of(paths, count);
      for (std::uint32_t shard = 1; shard <= count; ++shard) {
        // Five standard deviations of a random choice.
        const double mean = 1000.0 / count, bound = 5 * std::sqrt(mean * (1 - 1.0 / count));
        EXPECT_NEAR(static_cast<double>(std::ranges::count(shards, shard)), mean, bound)
            << paths[0] << ' ' << shard << '/' << count;
      }
    }
  }
}

SweepInput input_of(const std::vector<std::string>& paths) {
  SweepInput input;
  for (const std::string& path : paths) input.motions.push_back({path, {path}, 5, 0});
  return input;
}

std::vector<std::string> paths_in(SweepInput input, Shard shard) {
  const ShardHeader header = take_shard(input, shard, {}, "");
  EXPECT_EQ(header.motions, input.motions.size());
  std::vector<std::string> paths;
  for (const SweepMotion& motion : input.motions) paths.push_back(motion.path);
  return paths;
}

TEST(Shard, AMotionThatIsAddedMovesNoOther) {
  std::vector<std::string> paths = {"b", "c", "d", "e", "f", "g"};
  std::vector<std::vector<std::string>> before;
  std::size_t all = 0;
  for (std::uint32_t number = 1; number <= 3; ++number) {
    before.push_back(paths_in(input_of(paths), {number, 3}));
    all += before.back().size();
  }
  EXPECT_EQ(all, paths.size());
  paths.insert(paths.begin(), "a");
  for (std::uint32_t number = 1; number <= 3; ++number) {
    auto after = paths_in(input_of(paths), {number, 3});
    std::erase(after, "a");
    EXPECT_EQ(after, before[number - 1]);
  }
}

TEST(Shard, HasAHeaderThatCanBeRead) {
  SweepInput input = input_of({"lib/a", "lib/b"});
  const SweepScope scope{"command", {"lib", "l\xff"}, true, true, "0:2", {{"a", "b"}}, 3, 4};
  const ShardHeader header = take_shard(input, {2, 4}, scope, "0123");
  const auto read = read_shard_header(line_of(header));
  ASSERT_TRUE(read);
  EXPECT_EQ(line_of(*read), line_of(header));
  EXPECT_EQ(read->version, version());
  EXPECT_EQ(read->settings, "0123");
  EXPECT_EQ(read->scope.command, "");
  EXPECT_THAT(read->scope.directories, ElementsAre("lib", "l\xef\xbf\xbd"));
  EXPECT_TRUE(read->scope.poses && read->scope.steps_only);
  EXPECT_EQ(read->scope.frames, "0:2");
  EXPECT_EQ(read->scope.ignore, scope.ignore);
  EXPECT_EQ(read->scope.single_meshes, 3u);
  EXPECT_EQ(read->scope.single_arrays, 4u);
  // Of no shard: a number out of range, a field that is missing or of another type.
  const auto json = nlohmann::json::parse(line_of(header));
  for (const auto& [key, value] : json.items()) {
    auto lacks = json, other = json;
    lacks.erase(key);
    other[key] = nullptr;
    EXPECT_FALSE(read_shard_header(lacks.dump())) << key;
    EXPECT_FALSE(read_shard_header(other.dump())) << key;
  }
  for (const std::int64_t number : {0, 5}) {
    auto other = json;
    other["shard"] = number;
    EXPECT_FALSE(read_shard_header(other.dump())) << number;
  }
}

/// A library that is swept in shards.
struct ShardedLibrary : Library {
  ShardedLibrary() {
    add("a2.npz", kSinking);
    add("a10.npz", {3, 2, 1});
    add("b.npz", {1});
    add("c.npz", {2, 1, -1});
    std::ofstream(*this / "in/broken.glb") << "no such thing";
  }

  std::string file(std::uint32_t number, std::uint32_t count = kCount) const {
    return *this / fmt::format("shard-{}-of-{}.jsonl", number, count);
  }
  std::vector<std::string> files() const {
    std::vector<std::string> all;
    for (std::uint32_t number = kCount; number >= 1; --number) all.push_back(file(number));
    return all;
  }

  Result<SweepFile> open_shard(const std::string& path, SweepInput& found, Shard shard) const {
    const std::string hash = settings_hash(settings);
    const SweepScope scope{"", found.directories};
    const ShardHeader header = take_shard(found, shard, scope, hash);
    return SweepFile::open(path, found, hash, false, &header);
  }

  /// Checks what remains of a shard; returns the paths of what it checked.
  std::vector<std::string> sweep_shard(std::uint32_t number, std::uint32_t count = kCount) const {
    SweepInput found = input();
    auto opened = open_shard(file(number, count), found, {number, count});
    EXPECT_TRUE(opened) << opened.error().line();
    std::vector<std::string> checked;
    if (!opened) return checked;
    for (const std::size_t motion : opened->remaining()) {
      const auto line = sweep_line(found.motions[motion], settings);
      EXPECT_TRUE(line && opened->add(*line));
      checked.push_back(found.motions[motion].path);
    }
    EXPECT_EQ(opened->records().size(), found.motions.size());
    return checked;
  }
  void sweep_shards() const {
    for (std::uint32_t number = 1; number <= kCount; ++number) sweep_shard(number);
  }

  static constexpr std::uint32_t kCount = 3;
};

TEST(Join, GivesWhatOneSweepWouldHaveWritten) {
  const ShardedLibrary library;
  library.sweep_shards();
  library.sweep();
  const auto joined = join_shards(library.files());
  ASSERT_TRUE(joined) << joined.error().line();
  EXPECT_EQ(without_times(joined->lines), without_times(read_file(library.results())));
  EXPECT_EQ(joined->records.size(), 5u);
  EXPECT_THAT(joined->scope.directories, ElementsAre(library / "in"));
  // A sweep continues it. It checks again what failed, as always.
  std::ofstream(library.results()) << joined->lines;
  const SweepInput found = library.input();
  EXPECT_EQ(library.open(found)->remaining().size(), 1u);
}

TEST(Join, GivesTheSameForMoreShardsThanMotions) {
  const ShardedLibrary library;
  library.sweep_shards();
  std::vector<std::string> files;
  for (std::uint32_t number = 1; number <= 20; ++number) {
    library.sweep_shard(number, 20);
    files.push_back(library.file(number, 20));
  }
  const auto many = join_shards(files), few = join_shards(library.files());
  ASSERT_TRUE(many && few);
  EXPECT_EQ(without_times(many->lines), without_times(few->lines));
}

TEST(Join, TakesNamesThatAreNoText) {
  const ShardedLibrary library;
  library.add("x\xff.npz", kSinking);
  library.add("x\xfe.npz", {3, 2});
  library.sweep_shards();
  const auto joined = join_shards(library.files());
  ASSERT_TRUE(joined) << joined.error().line();
  EXPECT_EQ(joined->records.size(), 7u);
}

void expect_refused(const std::vector<std::string>& files, const std::string& said) {
  const auto joined = join_shards(files);
  ASSERT_FALSE(joined) << said;
  EXPECT_THAT(joined.error().line(), HasSubstr(said));
}

TEST(Join, RefusesWhatIsMissingDoubledOrNoShard) {
  const ShardedLibrary library;
  library.sweep_shards();
  const auto files = library.files();
  expect_refused({files[0], files[2]}, "--join: lacks 1 of 3 shards: 2/3; name their files, too");
  expect_refused({files[1]}, "lacks 2 of 3 shards: 1/3, 3/3; ");
  expect_refused({files[0], files[1], files[2], files[1]},
                 fmt::format("{0}: holds shard 2/3, as does '{0}'; name one of them", files[1]));
  library.sweep_shard(1, 4);
  expect_refused({files[0], library.file(1, 4)},
                 fmt::format("{}: is one of 4 shards, not of 3 as '{}'", library.file(1, 4), files[0]));
  library.sweep_shard(7, 1000);
  expect_refused({library.file(7, 1000)},
                 "lacks 999 of 1000 shards: 1/1000, 2/1000, 3/1000, 4/1000, 5/1000, "
                 "6/1000, 8/1000, 9/1000, 10/1000, 11/1000, ...; ");
  library.sweep();
  expect_refused({library.results()},
                 "results.jsonl: does not hold a shard of a sweep; name the files that ");
  expect_refused({library / "in/a2.npz"}, "does not hold a shard of a sweep");
  expect_refused({library / "none.jsonl"}, "none.jsonl: ");
  std::ofstream(library / "empty.jsonl").flush();
  expect_refused({library / "empty.jsonl"}, "empty.jsonl: ");
}

TEST(Join, RefusesShardsOfDifferentSweeps) {
  ShardedLibrary library;
  library.sweep_shards();
  const auto files = library.files();
  const std::string last = read_file(library.file(1));
  const auto restore = [&] { std::ofstream(library.file(1)) << last; };

  library.settings.check.step.thickness = 0.1;
  library.sweep_shard(1);
  expect_refused(files,
                 fmt::format("{}: was made with other settings than '{}'; ", library.file(1), files[0]));
  library.settings.check.step.thickness = 0;

  std::string other = last;
  other.replace(other.find(version()), std::string(version()).size(), "0.0.1");
  std::ofstream(library.file(1)) << other;
  expect_refused(files, fmt::format("{}: was made by version 0.0.1, not {} as '{}'; ", library.file(1),
                                    version(), files[0]));

  restore();
  library.add("new.npz", {3, 2});
  library.sweep_shard(1);
  expect_refused(files, "was made from another list of motions than");
  library.sweep_shards();
  EXPECT_TRUE(join_shards(files));
  // Of another size: not the same file.
  library.add("new.npz", {3, 2, 1});
  library.sweep_shard(1);
  expect_refused(files, "was made from another list of motions than");
}

/// The number of a shard with at least two motions.
std::uint32_t large_shard(const ShardedLibrary& library) {
  for (std::uint32_t number = 1; number <= library.kCount; ++number) {
    SweepInput found = library.input();
    if (take_shard(found, {number, library.kCount}, {}, "").motions >= 2) return number;
  }
  ADD_FAILURE() << "no shard has two motions";
  return 1;
}

TEST(Join, RefusesWhatIsNotFinished) {
  const ShardedLibrary library;
  library.sweep_shards();
  const std::uint32_t number = large_shard(library);
  const std::string whole = read_file(library.file(number));
  const auto count = std::count(whole.begin(), whole.end(), '\n') - 1;
  // Wherever its sweep was stopped.
  for (std::size_t length = whole.size() - 1; length > whole.find('\n'); length -= 1 + length / 20) {
    std::ofstream(library.file(number)) << whole.substr(0, length);
    const auto left =
        std::count(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(length), '\n') - 1;
    expect_refused(
        library.files(),
        fmt::format("{}: is not finished: it holds {} of {} motions; run the sweep with --shard {}/3 "
                    "again",
                    library.file(number), left, count, number));
  }
  library.sweep_shard(number);
  EXPECT_TRUE(join_shards(library.files()));
}

TEST(Join, RefusesLinesThatAreNotOfTheShard) {
  const ShardedLibrary library;
  library.sweep_shards();
  const std::uint32_t number = large_shard(library);
  const std::string whole = read_file(library.file(number));
  const std::size_t second = whole.find('\n') + 1, third = whole.find('\n', second) + 1;
  const std::string line = whole.substr(second, third - second);
  const auto refused = [&](const std::string& text, const std::string& said) {
    std::ofstream(library.file(number)) << text;
    expect_refused(library.files(), said);
  };
  refused(whole + line, "' twice; run the sweep with --shard");
  refused(whole + "{}\n", "is no result of a sweep; remove the line, and run the sweep with --shard");

  auto other = nlohmann::json::parse(line);
  other["settings"] = "0";
  refused(whole.substr(0, second) + other.dump() + '\n' + whole.substr(third), "or has other settings");

  // The line of a motion that another shard has.
  const std::uint32_t next = number % library.kCount + 1;
  std::string path;
  for (int k = 0; path.empty() || shard_of(path, library.kCount) != next; ++k) path = fmt::format("m{}", k);
  other = nlohmann::json::parse(line);
  other["path"] = path;
  refused(whole + other.dump() + '\n', fmt::format("holds '{}', which does not belong to shard", path));

  // In place of a motion of the list, one that is not in it.
  for (int k = 0; shard_of(path, library.kCount) != number; ++k) path = fmt::format("m{}", k);
  other["path"] = path;
  refused(whole.substr(0, second) + other.dump() + '\n' + whole.substr(third),
          "do not hold the motions that they were made from; run all shards again with --again");
}

TEST(ShardFile, ContinuesWhereItStopped) {
  const ShardedLibrary library;
  const std::uint32_t number = large_shard(library);
  std::vector<std::string> checked = library.sweep_shard(number);
  std::erase_if(checked, [](const std::string& path) { return !path.ends_with("broken.glb"); });
  EXPECT_EQ(library.sweep_shard(number), checked) << "what failed is checked again";
  const std::string whole = read_file(library.file(number));
  const std::size_t last = whole.rfind('\n', whole.size() - 2) + 1;
  std::ofstream(library.file(number)) << whole.substr(0, last + 20);
  EXPECT_EQ(library.sweep_shard(number).size(), 1u);
  EXPECT_EQ(without_times(read_file(library.file(number))), without_times(whole));
}

TEST(ShardFile, TakesUpOnlyItsOwnShard) {
  ShardedLibrary library;
  library.sweep_shard(1);
  library.sweep();
  const std::string shard = read_file(library.file(1)), results = read_file(library.results());
  const auto refused = [&](const std::string& path, Shard of, const std::string& said) {
    SweepInput found = library.input();
    const auto opened = library.open_shard(path, found, of);
    ASSERT_FALSE(opened) << said;
    EXPECT_THAT(opened.error().line(), HasSubstr(said));
  };
  refused(library.file(1), {2, 3},
          "shard-1-of-3.jsonl: holds shard 1/3; name another file, a new one for each");
  refused(library.file(1), {1, 4}, "holds shard 1/3; ");
  refused(library.results(), {1, 3}, "results.jsonl: does not hold a shard of a sweep; name another file");

  const SweepInput found = library.input();
  const auto plain = SweepFile::open(library.file(1), found, settings_hash(library.settings), false);
  ASSERT_FALSE(plain);
  EXPECT_THAT(
      plain.error().line(),
      HasSubstr("holds shard 1/3 of a sweep; continue it with --shard 1/3, join all shards with --join, "));

  SweepInput elsewhere = library.input();
  elsewhere.directories = {"elsewhere"};
  const auto other = library.open_shard(library.file(1), elsewhere, {1, 3});
  ASSERT_FALSE(other);
  EXPECT_THAT(other.error().line(),
              AllOf(HasSubstr("holds a shard of '"), HasSubstr("name the same directories")));

  EXPECT_EQ(read_file(library.file(1)), shard);
  EXPECT_EQ(read_file(library.results()), results);
}

}  // namespace
}  // namespace foldproof
