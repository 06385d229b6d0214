// foldproof sweep, on the command line, whole and in shards.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <thread>

#include "apps/program.h"
#include "report/without_times.h"

namespace foldproof {
namespace {

using namespace foldproof::testing;
using namespace std::chrono_literals;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

/// Reads a file that others may be writing, or that may not exist yet.
std::string text_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// Names and states in a file of results, sorted.
std::vector<std::string> states(const std::string& path) {
  std::vector<std::string> all;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    const auto json = nlohmann::json::parse(line, nullptr, false);
    EXPECT_FALSE(json.is_discarded()) << line;
    if (!json.is_discarded())
      all.push_back(json.at("path").get<std::string>() + " " + json.at("state").get<std::string>());
  }
  std::sort(all.begin(), all.end());
  return all;
}

/// Motions of every format and state.
struct Library : Workplace {
  Library() {
    std::filesystem::create_directories(*this / "lib/sub");
    write_frames(*this / "lib/sink", *sinking_triangle(kSinking));
    EXPECT_TRUE(write_npz(*this / "lib/sub/fall.npz", *sinking_triangle({5, 4, 3})));
    EXPECT_TRUE(write_obj_pc2(*this / "lib/sub/n.obj", *this / "lib/sub/n.pc2", *sinking_triangle(kSinking)));
    write_file(*this / "lib/broken.glb", "no such thing");
  }

  Outcome sweep(std::vector<std::string> arguments, RunOptions options = {}) const {
    arguments.insert(arguments.begin(), {"sweep", "lib", "-o", "r.jsonl"});
    options.directory = path();
    return run_program(std::move(arguments), options);
  }
};

const auto kAll = ElementsAre("lib/broken.glb failed", "lib/sink collides", "lib/sub/fall.npz clean",
                              "lib/sub/n.pc2 collides");

TEST(SweepRepair, WritesWhatCollidesWithoutCollisionsAndSaysSo) {
  const Workplace place;
  const auto run = [&](std::vector<std::string> arguments) {
    return run_program(std::move(arguments), {.directory = place.path()});
  };
  EXPECT_EQ(run({"demo", "-q", "demo"}).code, 0);
  const std::vector<std::string> command{"sweep",    "demo/library", "-o",        "r.jsonl",
                                         "--repair", "fixed",        "--summary", "page.html"};
  const Outcome done = run(command);
  EXPECT_EQ(done.code, 1) << done.err;
  EXPECT_THAT(done.out, HasSubstr("    repair: Proven: nothing touches"));
  EXPECT_THAT(read_file(place / "page.html"), HasSubstr("<p>Repair: Proven: nothing touches"));
  std::size_t repaired = 0;
  std::ifstream results(place / "r.jsonl");
  for (std::string line; std::getline(results, line);) {
    const auto json = nlohmann::json::parse(line);
    EXPECT_EQ(json.contains("repair"), json["state"] == "collides") << line;
    if (!json.contains("repair") || !json["repair"]["free"]) continue;
    ++repaired;
    EXPECT_GT(json["repair"]["correction"], 0);
    EXPECT_EQ(run({"check", json["repair"]["file"], "-q"}).code, 0) << line;
  }
  EXPECT_GT(repaired, 0);
  // What is done is not done again; without --repair it is checked again.
  EXPECT_EQ(run(command).code, 1);
  EXPECT_THAT(run({"sweep", "demo/library", "-o", "r.jsonl"}).out, Not(HasSubstr("repair")));
}

TEST(SweepRepair, RefusesWhatItCouldNotDo) {
  const Library library;
  EXPECT_THAT(library.sweep({"--repair", "lib/fixed"}).err,
              HasSubstr("is in lib, where motions are looked for"));
  EXPECT_THAT(library.sweep({"--repair", "fixed", "--static"}).err, HasSubstr("leave out --static"));
  EXPECT_THAT(library.sweep({"--repair", "fixed", "--steps-only"}).err, HasSubstr("leave out --steps-only"));
}

TEST(Sweep, ChecksALibraryAndContinues) {
  const Library library;
  const Outcome first = library.sweep({"--summary", "page.html"});
  EXPECT_EQ(first.code, 1);
  EXPECT_EQ(first.err, "");
  EXPECT_THAT(
      first.out,
      AllOf(HasSubstr("motions                 4\n"), HasSubstr("\n  collide               2\n"),
            HasSubstr("\n  could not be read     1\n"), HasSubstr("\n  lib/sink: sink goes through itself, "),
            HasSubstr("\n  lib/broken.glb, byte 2: "), Not(HasSubstr("before"))));
  EXPECT_THAT(states(library / "r.jsonl"), kAll);
  EXPECT_THAT(read_file(library / "page.html"),
              HasSubstr("foldproof sweep lib -o r.jsonl --summary page.html"));

  const Outcome second = library.sweep({});
  EXPECT_EQ(second.code, 1);
  EXPECT_THAT(second.out, HasSubstr("motions                 4  (3 of them checked before)\n"));
  EXPECT_THAT(states(library / "r.jsonl"), kAll);

  std::filesystem::remove(library / "lib/broken.glb");
  const Outcome start = library.sweep({"--frames", "0:2"});
  EXPECT_EQ(start.code, 0);
  EXPECT_THAT(start.out, HasSubstr("\nframes                  only 0:2 of each motion (--frames)\n"));
  EXPECT_THAT(library.sweep({"--frames", ":"}).out, Not(HasSubstr("--frames")));
}

TEST(Sweep, ChecksSinglePosesExactly) {
  const Library library;
  write_file(library / "lib/one.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  EXPECT_EQ(library.sweep({"--static"}).code, 1);
  EXPECT_THAT(states(library / "r.jsonl"),
              ElementsAre("lib/broken.glb failed", "lib/one.obj clean", "lib/sink collides",
                          "lib/sub/fall.npz clean", "lib/sub/n.pc2 collides"));
}

TEST(Sweep, SaysWhatWasNotTested) {
  const Library library;
  const std::string between = "\nmotion between frames   not tested (--static)\n";
  EXPECT_THAT(library.sweep({"--static", "--summary", "page.html"}).out, HasSubstr(between));
  EXPECT_THAT(read_file(library / "page.html"), HasSubstr("motion between them was not tested"));
  EXPECT_THAT(library.sweep({"--steps-only"}).out,
              AllOf(HasSubstr("\nfirst frames            not tested"), Not(HasSubstr(between))));
  EXPECT_THAT(library.sweep({}).out, AllOf(Not(HasSubstr("not tested")), Not(HasSubstr("\ncontacts "))));
  std::string lines = read_file(library / "r.jsonl");
  const std::string total = "\"unknown_frames\":0";
  ASSERT_NE(lines.find(total), lines.npos);
  lines[lines.find(total) + total.size() - 1] = '1';
  write_file(library / "r.jsonl", lines);
  EXPECT_THAT(library.sweep({}).out,
              HasSubstr("\ncontacts                leave out pairs in 1 motion: more than a million "));
}

TEST(Sweep, TakesNumberedMeshesAsSingleOnesIfAsked) {
  const Library library;
  std::filesystem::create_directory(library / "poses");
  for (const char* name : {"run1.obj", "run2.obj"})
    write_file(library / (std::string("poses/") + name), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const auto run = [&](std::vector<std::string> more) {
    more.insert(more.begin(), {"sweep", "poses", "-o", "p.jsonl"});
    return run_program(more, {.directory = library.path()});
  };
  EXPECT_EQ(run({"--static"}).code, 0);
  EXPECT_THAT(states(library / "p.jsonl"), ElementsAre("poses clean"));
  EXPECT_EQ(run({"--static", "--separate"}).code, 0);
  EXPECT_THAT(states(library / "p.jsonl"), ElementsAre("poses/run1.obj clean", "poses/run2.obj clean"));
  expect_one_line_error(run({"--separate"}), "holds no motions, and 2 single mesh files");
}

TEST(Sweep, AsksForFramesThatLookLikeBodies) {
  const Library library;
  std::filesystem::create_directory(library / "lib/far");
  for (const int k : {0, 1})
    write_file(library / fmt::format("lib/far/b{}.obj", k),
               fmt::format("v {0} 0 0\nv {1} 0 0\nv {0} 1 0\nf 1 2 3\n", 5 * k, 5 * k + 1));
  const Outcome asked = library.sweep({"--summary", "page.html"});
  EXPECT_EQ(asked.code, 1);
  EXPECT_THAT(asked.out,
              AllOf(HasSubstr("\n  unclear               1\n"),
                    HasSubstr("\nUnclear:\n  lib/far: may be 2 frames of one mesh or 2 bodies: ")));
  EXPECT_THAT(states(library / "r.jsonl"), ::testing::Contains("lib/far unclear"));
  EXPECT_THAT(read_file(library / "page.html"), HasSubstr("<span class=\"unclear\">1 unclear</span>"));
  // The same line is checked again where that is clear.
  library.sweep({"--sequence"});
  EXPECT_THAT(states(library / "r.jsonl"), ::testing::Contains("lib/far clean"));
  expect_one_line_error(library.sweep({"--sequence", "--separate"}), "--separate");
}

TEST(Sweep, UsesModelsWhereTheyFit) {
  const Library library;
  ASSERT_EQ(run_program({"train", "lib/sink", "-o", "n.model"}, {.directory = library.path()}).code, 0);
  write_frames(library / "other", *lone_triangle({1, 2}));
  ASSERT_EQ(run_program({"train", "other", "-o", "o.model"}, {.directory = library.path()}).code, 0);
  const Outcome found = library.sweep({"--model", "o.model", "--model", "n.model"});
  EXPECT_EQ(found.code, 1);
  EXPECT_THAT(found.out, HasSubstr("not used                o.model"));
  EXPECT_THAT(read_file(library / "r.jsonl"), HasSubstr("\"model\":\"n.model\""));
}

TEST(Sweep, SaysWhatIsWrongInOneLine) {
  const Library library;
  expect_one_line_error(library.run({"sweep", "nowhere", "-o", "r.jsonl"}), "nowhere: does not exist");
  expect_one_line_error(library.run({"sweep", "lib/broken.glb", "-o", "r.jsonl"}), "is no directory");
  expect_one_line_error(library.run({"sweep", "lib", "-o", "no/r.jsonl"}), "no/r.jsonl: cannot be written");
  expect_one_line_error(library.run({"sweep", "lib", "-o", "/dev/null"}), "is not a regular file");
  expect_one_line_error(library.run({"sweep", "lib", "-o", "lib/broken.glb"}),
                        "would write over 'lib/broken.glb'");
  write_file(library / "other.txt", read_file(library / "lib/broken.glb"));
  expect_one_line_error(library.run({"sweep", "lib", "-o", "other.txt"}),
                        "other.txt:1: is no result of a sweep");
  expect_one_line_error(library.run({"sweep", "lib", "-o", "r", "--summary", "r"}), "named for two outputs");
  std::filesystem::create_directory(library / "empty");
  expect_one_line_error(library.run({"sweep", "empty", "-o", "r.jsonl"}), "holds no motions");
  EXPECT_FALSE(std::filesystem::exists(library / "r.jsonl"));
}

/// Motions that take long enough to be interrupted: many steps of two triangles.
struct LongLibrary : Workplace {
  explicit LongLibrary(int motions, std::size_t frames = 40000) {
    std::filesystem::create_directory(*this / "lib");
    std::vector<double> heights(frames, 1);
    for (std::size_t i = 0; i < frames; i += 2) heights[i] = -1;
    for (int i = 0; i < motions; ++i)
      EXPECT_TRUE(write_npz(*this / fmt::format("lib/{}.npz", i), *sinking_triangle(heights)));
  }

  std::size_t lines() const { return states(*this / "r.jsonl").size(); }

  /// Waits until there are lines, with a time limit.
  void wait_for_lines(std::size_t count) const {
    const auto start = std::chrono::steady_clock::now();
    while (std::chrono::steady_clock::now() - start < 20s) {
      const std::string text = text_of(*this / "r.jsonl");
      if (static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n')) >= count) return;
      std::this_thread::sleep_for(2ms);
    }
    ADD_FAILURE() << count << " lines did not come in 20 s";
  }

  std::vector<std::string> command(std::vector<std::string> more = {}) const {
    std::vector<std::string> all = {"sweep",     "lib",       "-o",        "r.jsonl",
                                    "--summary", "page.html", "--threads", "1"};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
};

TEST(Sweep, MayBeStoppedAtAnyTime) {
  const LongLibrary library(4);
  for (const int signal : {SIGINT, SIGKILL}) {
    const std::size_t before = signal == SIGINT ? 0 : library.lines();
    const Outcome stopped =
        run_program(library.command(), {.directory = library.path(), .while_it_runs = [&](pid_t child) {
                                          library.wait_for_lines(before + 1);
                                          ::kill(child, signal);
                                        }});
    if (signal == SIGINT) {
      EXPECT_EQ(stopped.code, 130);
      EXPECT_THAT(stopped.err, HasSubstr("of 4 motions are done; the same command continues from there\n"));
    } else {
      EXPECT_EQ(stopped.signal, SIGKILL);
    }
    EXPECT_GE(library.lines(), before + 1);
    EXPECT_LT(library.lines(), 4u);
    EXPECT_FALSE(std::filesystem::exists(library / "page.html"));
  }
  EXPECT_EQ(run_program(library.command(), {.directory = library.path()}).code, 1);
  EXPECT_EQ(library.lines(), 4u);
  EXPECT_TRUE(std::filesystem::exists(library / "page.html"));
}

TEST(SweepShards, TogetherAreOneSweep) {
  const Library library;
  const Outcome plain = library.sweep({"--frames", "0:3"});
  const std::string names[] = {"s1.jsonl", "s2.jsonl", "s3.jsonl"};
  std::size_t motions = 0;
  for (int shard = 1; shard <= 3; ++shard) {
    expect_one_line_error(
        library.run({"sweep", "--join", "s1.jsonl", "s2.jsonl", "s3.jsonl", "-o", "joined.jsonl"}),
        fmt::format("s{}.jsonl: ", shard));
    const std::string& file = names[shard - 1];
    const Outcome found =
        library.run({"sweep", "lib", "--shard", fmt::format("{}/3", shard), "-o", file, "--frames", "0:3"});
    EXPECT_EQ(found.code, 0) << "it is finished, whatever it found";
    EXPECT_THAT(found.out, HasSubstr(fmt::format("shard                   {}/3\nmotions  ", shard)));
    const std::string lines = read_file(library / file);
    motions += static_cast<std::size_t>(std::count(lines.begin(), lines.end(), '\n')) - 1;
  }
  EXPECT_EQ(motions, 4u);
  EXPECT_FALSE(std::filesystem::exists(library / "joined.jsonl"));
  const Outcome joined = library.run(
      {"sweep", "-o", "joined.jsonl", "--summary", "page.html", "--join", names[2], names[0], names[1]});
  EXPECT_EQ(joined.code, 1);
  EXPECT_EQ(joined.out, plain.out);
  EXPECT_EQ(without_times(read_file(library / "joined.jsonl")),
            without_times(read_file(library / "r.jsonl")));
  EXPECT_THAT(
      read_file(library / "page.html"),
      AllOf(HasSubstr("<h1>lib</h1>"), HasSubstr("<p>Only the frames 0:3 of each motion were checked.</p>"),
            HasSubstr("sweep -o joined.jsonl --summary page.html --join s3.jsonl s1.jsonl s2.jsonl")));
}

TEST(SweepShards, SayWhatIsWrongInOneLine) {
  const Library library;
  const auto run = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "sweep");
    return run_program(std::move(arguments), {.directory = library.path()});
  };
  const std::string count_from_1 =
      "'0/4' is no shard; give I/N with I from 1 to N, and N up to 1000000; add 1 to";
  expect_one_line_error(run({"lib", "--shard", "0/4", "-o", "s.jsonl"}), count_from_1);
  expect_one_line_error(run({"lib", "--shard", "", "-o", "s.jsonl"}), "'' is no shard");
  expect_one_line_error(run({"-o", "s.jsonl"}), "DIR: is required; name a directory, or shards after --join");
  EXPECT_FALSE(std::filesystem::exists(library / "s.jsonl"));
  ASSERT_EQ(run({"lib", "--shard", "1/1", "-o", "s.jsonl"}).code, 0);
  expect_one_line_error(run({"--join", "s.jsonl", "-o", "s.jsonl"}),
                        "would write over 's.jsonl', which is read");
  for (const auto& option : {std::vector<std::string>{"--shard", "1/1"},
                             {"--steps-only"},
                             {"--static"},
                             {"--again"},
                             {"--threads", "1"}}) {
    std::vector<std::string> arguments = option;
    arguments.insert(arguments.end(), {"-o", "j.jsonl", "--join", "s.jsonl"});
    expect_one_line_error(run(arguments), option[0] + " excludes --join");
  }
  expect_one_line_error(run({"lib", "-o", "j.jsonl", "--join", "s.jsonl"}), "DIR excludes --join");
  EXPECT_FALSE(std::filesystem::exists(library / "j.jsonl"));
  EXPECT_EQ(run({"-q", "-o", "j.jsonl", "--join", "s.jsonl"}).out, "");
  EXPECT_THAT(states(library / "j.jsonl"), kAll);
}

/// Kills every foldproof that runs in `directory`; returns how many.
int kill_sweeps(const std::string& directory) {
  int killed = 0;
  const auto program = std::filesystem::canonical(FOLDPROOF_PROGRAM);
  for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
    std::error_code status;
    if (std::filesystem::read_symlink(entry.path() / "exe", status) != program || status) continue;
    if (std::filesystem::read_symlink(entry.path() / "cwd", status) != directory || status) continue;
    killed += ::kill(std::stoi(entry.path().filename()), SIGKILL) == 0;
  }
  return killed;
}

/// docs/sweep.md shows this, on several machines.
TEST(SweepShards, RunByGnuParallelMayBeKilled) {
  const char* parallel = "/usr/bin/parallel";
  if (std::system("/usr/bin/parallel --version 2>/dev/null | grep -q GNU") != 0)
    GTEST_SKIP() << "GNU Parallel is not installed.";
  const LongLibrary library(8, 20000);
  const auto run = [&](std::vector<std::string> arguments, RunOptions options = {}) {
    options.directory = library.path();
    return run_program(std::move(arguments), options);
  };
  const auto run_shards = [&](const std::function<void()>& meanwhile) {
    return run(
        {"--will-cite", "-j2", "--joblog", "jobs", "--resume-failed", FOLDPROOF_PROGRAM, "sweep", "lib",
         "--shard", "{}/3", "-o", "shard-{}.jsonl", "--threads", "1", "--quiet", ":::", "1", "2", "3"},
        {.program = parallel, .while_it_runs = [&](pid_t) { meanwhile(); }});
  };
  const std::vector<std::string> join = {"sweep",         "--join", "shard-1.jsonl", "shard-2.jsonl",
                                         "shard-3.jsonl", "-o",     "joined.jsonl"};
  const Outcome killed = run_shards([&] {
    const auto start = std::chrono::steady_clock::now();
    const auto has_line = [&](int shard) {
      const std::string text = text_of(library / fmt::format("shard-{}.jsonl", shard));
      return std::count(text.begin(), text.end(), '\n') > 1;
    };
    while (!(has_line(1) || has_line(2) || has_line(3)) || kill_sweeps(library.path()) == 0) {
      ASSERT_LT(std::chrono::steady_clock::now() - start, 60s);
      std::this_thread::sleep_for(1ms);
    }
  });
  EXPECT_NE(killed.code, 0);
  expect_one_line_error(run(join), "shard-");
  EXPECT_FALSE(std::filesystem::exists(library / "joined.jsonl"));

  const Outcome finished = run_shards([] {});
  EXPECT_EQ(finished.code, 0) << finished.err;
  EXPECT_EQ(run(join).code, 1);
  EXPECT_EQ(run({"sweep", "lib", "-o", "plain.jsonl"}).code, 1);
  EXPECT_EQ(without_times(read_file(library / "joined.jsonl")),
            without_times(read_file(library / "plain.jsonl")));
}

}  // namespace
}  // namespace foldproof
