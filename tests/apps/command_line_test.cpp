// What all subcommands have in common: help, mistakes, standard output, color.
#include <gmock/gmock.h>

#include <cstdlib>
#include <nlohmann/json.hpp>

#include "apps/program.h"

namespace foldproof {
namespace {

using namespace foldproof::testing;
using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::MatchesRegex;
using ::testing::Not;
using ::testing::StartsWith;

struct Sinking : TemporaryDirectory {
  Sinking() { EXPECT_TRUE(write_npz(*this / "sink.npz", *sinking_triangle(kSinking))); }
  Outcome run(std::vector<std::string> arguments) const {
    return run_program(std::move(arguments), {.directory = path()});
  }
  /// On a terminal, whose output and errors are one.
  std::string on_terminal(const std::string& environment, const std::string& arguments) const {
    const std::string command = environment + " " FOLDPROOF_PROGRAM " " + arguments;
    return run_program({"-qec", command, "/dev/null"}, {.directory = path(), .program = "/usr/bin/script"})
        .out;
  }
};

TEST(CommandLine, NoArgumentsShowTheHelpAndAreNoAnswer) {
  const Outcome nothing = run_program({});
  EXPECT_EQ(nothing.code, 2);
  EXPECT_EQ(nothing.out, "");
  EXPECT_EQ(nothing.err, run_program({"--help"}).out);
}

TEST(CommandLine, HelpOfACommandCanBeAskedForInTwoWays) {
  const Outcome help = run_program({"help", "check"});
  EXPECT_EQ(help.code, 0);
  EXPECT_THAT(help.out, HasSubstr("--thickness"));
  EXPECT_EQ(help.out, run_program({"check", "--help"}).out);
  EXPECT_EQ(run_program({"help"}).out, run_program({"--help"}).out);
  expect_one_line_error(run_program({"help", "chekc"}), "did you mean 'check'?");
}

TEST(CommandLine, ShortOptions) {
  EXPECT_THAT(run_program({"-V"}).out,
              MatchesRegex("foldproof 0[.][0-9.]+\n(GCC|Clang) [0-9.]+, threads (oneTBB|std::thread|none) "
                           "[(][0-9]+[)], (AVX-512|AVX2|SSE4|SSSE3|NEON|EMU128)\n"));
  EXPECT_EQ(run_program({"-V"}).out, run_program({"--version"}).out);
  const Outcome quiet = Sinking().run({"check", "sink.npz", "-q"});
  EXPECT_EQ(quiet.code, 1);
  EXPECT_EQ(quiet.out + quiet.err, "");
}

TEST(CommandLine, MistakesAreAnsweredWithWhatWasMeant) {
  const Sinking scene;
  const std::vector<std::pair<std::vector<std::string>, const char*>> mistakes{
      {{"chek", "sink.npz"}, "'chek' is no command of foldproof; did you mean 'check'?"},
      {{"sink.npz"}, "'sink.npz' is no command of foldproof; did you mean 'foldproof check sink.npz'?"},
      {{"dance"}, "'dance' is no command of foldproof; 'foldproof --help' shows what there is"},
      {{"--versoin"}, "'--versoin' is no option of foldproof; did you mean '--version'?"},
      {{"check", "sink.npz", "--jsn", "a.json"},
       "'--jsn' is no option of foldproof check; did you mean '--json'?"},
      {{"check", "sink.npz", "--threds=2"}, "did you mean '--threads'?"},
      {{"check", "sink.npz", "--wireframe"}, "; 'foldproof check --help' shows what there is"},
      {{"train", "sink.npz", "-o", "a.model", "--mdoes", "3"}, "did you mean '--modes'?"}};
  for (const auto& [arguments, said] : mistakes) expect_one_line_error(scene.run(arguments), said);
}

TEST(CommandLine, WrongValuesAreAnsweredWithWhatIsRight) {
  const auto error = [](std::vector<std::string> words) { return run_program(std::move(words)).err; };
  EXPECT_EQ(error({"check", "a.glb", "--thickness", "abc"}),
            "foldproof: command line: --thickness: 'abc' is not a number; give one\n");
  EXPECT_EQ(error({"check", "a.glb", "--substeps", "1.5"}),
            "foldproof: command line: --substeps: '1.5' is not a whole number; give one\n");
  EXPECT_EQ(error({"check", "a.glb", "--mode", "papre"}),
            "foldproof: command line: --mode: 'papre' is not known; did you mean 'paper'?\n");
  EXPECT_EQ(error({"check", "a.glb", "--mode", "xyz"}),
            "foldproof: command line: --mode: 'xyz' is not known; give proven or paper\n");
  EXPECT_EQ(error({"radius", "a.model", "--clearance", "-1"}),
            "foldproof: --clearance: -1 is below 0; give a number of at least 0\n");
}

TEST(CommandLine, AReportOnStandardOutputLeavesTheSummaryToStandardError) {
  const Sinking scene;
  const Outcome check = scene.run({"check", "sink.npz", "--json", "-", "--csv", "a.csv"});
  EXPECT_EQ(check.code, 1);
  EXPECT_EQ(json::parse(check.out)["totals"]["steps"], 4);
  EXPECT_THAT(check.err, HasSubstr("Collisions in 2 of 4 steps"));
  const Outcome rows = scene.run({"check", "sink.npz", "--csv", "-"});
  EXPECT_EQ(rows.out, read_file(scene / "a.csv"));
  EXPECT_THAT(scene.run({"check", "sink.npz", "--contacts-csv", "-"}).out, StartsWith("contact,side_a,"));
  EXPECT_FALSE(std::filesystem::exists(scene / "-"));

  expect_one_line_error(scene.run({"check", "sink.npz", "--json", "-", "--csv", "-"}),
                        "--csv -: is named for two outputs");
  expect_one_line_error(scene.run({"check", "sink.npz", "--vtk", "-"}), "--vtk -: cannot be standard output");
}

TEST(CommandLine, AReportMayBeAddedToAFileOrReadInPart) {
  const Sinking scene;
  write_file(scene / "log", "before\n");
  const auto shell = [&](const std::string& command) {
    return run_program({"-c", FOLDPROOF_PROGRAM " check sink.npz -q --csv - " + command},
                       {.directory = scene.path(), .program = "/bin/sh"});
  };
  EXPECT_EQ(shell(">> log").code, 1);
  EXPECT_THAT(read_file(scene / "log"), StartsWith("before\nframe,"));
  const Outcome closed = shell("2> err | true");
  EXPECT_EQ(closed.code, 0);
  EXPECT_EQ(read_file(scene / "err"), "");
  EXPECT_EQ(shell("> /dev/full").code, 2);
}

TEST(CommandLine, ColorIsForTerminals) {
  const Sinking scene;
  EXPECT_THAT(scene.run({"check", "sink.npz"}).out, Not(HasSubstr("\x1b[")));
  EXPECT_THAT(scene.on_terminal("TERM=xterm NO_COLOR=", "check sink.npz"),
              HasSubstr("\x1b[1;31msink goes through itself, "));
  EXPECT_THAT(scene.on_terminal("TERM=xterm NO_COLOR=", "check none.npz"), HasSubstr("\x1b[1;31mfoldproof:"));
  for (const char* plain : {"TERM=xterm NO_COLOR=1", "TERM=dumb NO_COLOR="})
    EXPECT_THAT(scene.on_terminal(plain, "check sink.npz"), Not(HasSubstr("\x1b[")));
}

}  // namespace
}  // namespace foldproof
