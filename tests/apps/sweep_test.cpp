// foldproof sweep, on the command line, alone and below mpirun.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <chrono>
#include <csignal>
#include <nlohmann/json.hpp>
#include <thread>

#include "apps/program.h"

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
struct Library : TemporaryDirectory {
  Library() {
    std::filesystem::create_directories(*this / "lib/sub");
    write_frames(*this / "lib/sink", *needle(kSinking));
    EXPECT_TRUE(write_npz(*this / "lib/sub/fall.npz", *needle({5, 4, 3})));
    EXPECT_TRUE(write_obj_pc2(*this / "lib/sub/n.obj", *this / "lib/sub/n.pc2", *needle(kSinking)));
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

TEST(Sweep, ChecksALibraryAndContinues) {
  const Library library;
  const Outcome first = library.sweep({"--summary", "page.html"});
  EXPECT_EQ(first.code, 1);
  EXPECT_EQ(first.err, "");
  EXPECT_THAT(first.out,
              AllOf(HasSubstr("motions                 4\n"), HasSubstr("\n  collide               2\n"),
                    HasSubstr("\n  could not be read     1\n"),
                    HasSubstr("\n  lib/sink: 3 pairs in 2 of 4 steps, the first in frame 1\n"),
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
  write_frames(library / "other", *lone_needle({1, 2}));
  ASSERT_EQ(run_program({"train", "other", "-o", "o.model"}, {.directory = library.path()}).code, 0);
  const Outcome found = library.sweep({"--model", "o.model", "--model", "n.model"});
  EXPECT_EQ(found.code, 1);
  EXPECT_THAT(found.out, HasSubstr("not used                o.model"));
  EXPECT_THAT(read_file(library / "r.jsonl"), HasSubstr("\"model\":\"n.model\""));
}

TEST(Sweep, SaysWhatIsWrongInOneLine) {
  const Library library;
  const auto run = [&](std::vector<std::string> arguments) {
    return run_program(std::move(arguments), {.directory = library.path()});
  };
  expect_one_line_error(run({"sweep", "nowhere", "-o", "r.jsonl"}), "nowhere: does not exist");
  expect_one_line_error(run({"sweep", "lib/broken.glb", "-o", "r.jsonl"}), "is no directory");
  expect_one_line_error(run({"sweep", "lib", "-o", "no/r.jsonl"}), "no/r.jsonl: cannot be written");
  expect_one_line_error(run({"sweep", "lib", "-o", "/dev/null"}), "is not a regular file");
  expect_one_line_error(run({"sweep", "lib", "-o", "lib/broken.glb"}), "would write over 'lib/broken.glb'");
  write_file(library / "other.txt", read_file(library / "lib/broken.glb"));
  expect_one_line_error(run({"sweep", "lib", "-o", "other.txt"}), "other.txt:1: is no result of a sweep");
  expect_one_line_error(run({"sweep", "lib", "-o", "r", "--summary", "r"}), "named for two outputs");
  std::filesystem::create_directory(library / "empty");
  expect_one_line_error(run({"sweep", "empty", "-o", "r.jsonl"}), "holds no motions");
  EXPECT_FALSE(std::filesystem::exists(library / "r.jsonl"));
}

/// Motions that take long enough to be interrupted: many steps of two triangles.
struct LongLibrary : TemporaryDirectory {
  explicit LongLibrary(int motions, std::size_t frames = 40000) {
    std::filesystem::create_directory(*this / "lib");
    std::vector<double> heights(frames, 1);
    for (std::size_t i = 0; i < frames; i += 2) heights[i] = -1;
    for (int i = 0; i < motions; ++i)
      EXPECT_TRUE(write_npz(*this / fmt::format("lib/{}.npz", i), *needle(heights)));
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

#ifdef FOLDPROOF_MPIRUN

/// Arguments of mpirun, also for machines with fewer cores than ranks.
std::vector<std::string> by_ranks(const char* count, std::vector<std::string> sweep,
                                  std::vector<std::string> options = {}) {
  std::vector<std::string> all = {"--allow-run-as-root", "--oversubscribe", "-n", count};
  all.insert(all.end(), options.begin(), options.end());
  all.push_back(FOLDPROOF_PROGRAM);
  all.insert(all.end(), sweep.begin(), sweep.end());
  return all;
}

/// Kills the process that mpirun started as `rank` in `directory`.
void kill_rank(const std::string& directory, int rank) {
  const std::string variable = '\0' + fmt::format("OMPI_COMM_WORLD_RANK={}", rank) + '\0';
  for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
    std::error_code status;
    const auto where = std::filesystem::read_symlink(entry.path() / "cwd", status);
    if (status || where != std::filesystem::canonical(directory)) continue;
    if (text_of(entry.path() / "environ").find(variable) == std::string::npos) continue;
    ::kill(std::stoi(entry.path().filename()), SIGKILL);
    return;
  }
  ADD_FAILURE() << "no rank " << rank;
}

TEST(SweepByMpi, AnswersAsOneProcessDoes) {
  const Library library;
  ASSERT_EQ(library.sweep({}).code, 1);
  const Outcome found =
      run_program(by_ranks("4", {"sweep", "lib", "-o", "mpi.jsonl", "--summary", "page.html"}),
                  {.directory = library.path(), .program = FOLDPROOF_MPIRUN});
  EXPECT_EQ(found.code, 1) << found.err;
  EXPECT_THAT(found.out, HasSubstr("motions                 4\n"));
  EXPECT_THAT(states(library / "mpi.jsonl"), kAll);
  EXPECT_EQ(states(library / "r.jsonl"), states(library / "mpi.jsonl"));
  EXPECT_TRUE(std::filesystem::exists(library / "page.html"));
}

TEST(SweepByMpi, SaysOnceWhatIsWrong) {
  const Library library;
  const Outcome found = run_program(by_ranks("2", {"sweep", "nowhere", "-o", "r.jsonl"}),
                                    {.directory = library.path(), .program = FOLDPROOF_MPIRUN});
  EXPECT_EQ(found.code, 2);
  const std::string said = "foldproof: nowhere: does not exist; check the name\n";
  EXPECT_THAT(found.err, HasSubstr(said));
  EXPECT_EQ(found.err.find("foldproof: ", found.err.find(said) + said.size()), std::string::npos)
      << found.err;
}

TEST(SweepByMpi, DoesTheWorkOfARankThatIsKilled) {
  const LongLibrary library(8, 30000);
  const Outcome found =
      run_program(by_ranks("4", library.command({"--patience", "2"}), {"--enable-recovery"}),
                  {.directory = library.path(), .program = FOLDPROOF_MPIRUN, .while_it_runs = [&](pid_t) {
                     library.wait_for_lines(1);
                     kill_rank(library.path(), 2);
                   }});
  EXPECT_THAT(found.err, HasSubstr("rank 2: has not responded for 2 s; the other ranks do its work"));
  EXPECT_THAT(found.out, HasSubstr("\n  collide               8\n")) << found.err;
  EXPECT_EQ(library.lines(), 8u);
}

TEST(SweepByMpi, LeavesWholeLinesWhenMpirunEndsAllAfterOne) {
  const LongLibrary library(8, 30000);
  run_program(by_ranks("4", library.command()),
              {.directory = library.path(), .program = FOLDPROOF_MPIRUN, .while_it_runs = [&](pid_t) {
                 library.wait_for_lines(1);
                 kill_rank(library.path(), 2);
               }});
  const std::size_t before = library.lines();
  EXPECT_GE(before, 1u);
  EXPECT_LT(before, 8u);
  const Outcome rest = run_program(by_ranks("4", library.command()),
                                   {.directory = library.path(), .program = FOLDPROOF_MPIRUN});
  EXPECT_THAT(rest.out,
              HasSubstr(fmt::format("motions                 8  ({} of them checked before)\n", before)));
  EXPECT_EQ(library.lines(), 8u);
}

#else

TEST(Sweep, SaysThatItWasBuiltWithoutMpi) {
  const Library library;
  for (const char* rank : {"0", "3"}) {
    for (const std::string launcher : {"OMPI_COMM_WORLD_", "PMI_"}) {
      ::setenv((launcher + "SIZE").c_str(), "4", 1);
      ::setenv((launcher + "RANK").c_str(), rank, 1);
      expect_one_line_error(library.sweep({}), "started 4 processes, but this program was built without MPI");
      ::unsetenv((launcher + "SIZE").c_str());
      ::unsetenv((launcher + "RANK").c_str());
    }
  }
  EXPECT_FALSE(std::filesystem::exists(library / "r.jsonl"));
  ::setenv("OMPI_COMM_WORLD_SIZE", "1", 1);
  EXPECT_EQ(library.sweep({}).code, 1);  // what it finds
  ::unsetenv("OMPI_COMM_WORLD_SIZE");
  EXPECT_THAT(states(library / "r.jsonl"), kAll);
}

#endif

}  // namespace
}  // namespace foldproof
