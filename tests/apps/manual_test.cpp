// Manual pages and completion, as they are installed.
#include <gmock/gmock.h>

#include "apps/program.h"

namespace foldproof {
namespace {

using namespace foldproof::testing;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

fs::path share() { return fs::path(FOLDPROOF_PROGRAM).parent_path() / "share"; }

Outcome shell(const std::string& program, std::vector<std::string> arguments) {
  return run_program(std::move(arguments), {.directory = share().string(), .program = program});
}

TEST(Manual, EveryCommandHasAPage) {
  if (!fs::exists(share() / "man")) GTEST_SKIP() << "help2man is not installed";
  const auto page = [](const std::string& name) { return read_file(share() / ("man/man1/" + name + ".1")); };
  EXPECT_THAT(page("foldproof"), HasSubstr("\nfoldproof \\- Finds every collision"));
  const std::string check = page("foldproof-check");
  EXPECT_THAT(check, HasSubstr("\n.TH foldproof-check "));
  EXPECT_THAT(check, HasSubstr("\nfoldproof-check \\- Find every collision"));
  EXPECT_THAT(check, HasSubstr("\n.TP\n\\fB\\-\\-thickness\\fR D\n"));
  EXPECT_THAT(check, HasSubstr("\n.SH EXAMPLES\n.TP\nfoldproof check walk.glb\nevery collision"));
  EXPECT_TRUE(fs::exists(share() / "man/man1/foldproof-sweep.1"));
  EXPECT_FALSE(fs::exists(share() / "man/man1/foldproof-help.1"));
}

TEST(Manual, EveryPageIsRenderedWithoutWarnings) {
  if (!fs::exists(share() / "man")) GTEST_SKIP() << "help2man is not installed";
  if (!fs::exists("/usr/bin/groff")) GTEST_SKIP() << "groff is not installed";
  for (const auto& page : fs::directory_iterator(share() / "man/man1")) {
    const Outcome outcome =
        shell("/usr/bin/groff", {"-man", "-Tutf8", "-ww", "-P-cbou", page.path().string()});
    EXPECT_EQ(outcome.code, 0);
    EXPECT_EQ(outcome.err, "");
    EXPECT_THAT(outcome.out, HasSubstr("SYNOPSIS"));
  }
}

/// What bash completes after these words.
std::string completed(const std::string& words) {
  const std::string command =
      "source bash-completion/completions/foldproof; COMP_WORDS=(" + words +
      "); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); _foldproof ../foldproof; echo \"${COMPREPLY[@]}\"";
  return shell("/bin/bash", {"-c", command}).out;
}

TEST(Completion, BashCompletesCommandsOptionsAndValues) {
  EXPECT_EQ(completed("foldproof ch"), "check\n");
  EXPECT_EQ(completed("foldproof --ver"), "--version\n");
  EXPECT_EQ(completed("foldproof help tr"), "train\n");
  EXPECT_EQ(completed("foldproof check walk.glb --thi"), "--thickness\n");
  EXPECT_EQ(completed("foldproof check -q --qu"), "--quiet\n");
  EXPECT_EQ(completed("foldproof check walk.glb --mode p"), "proven paper\n");
  EXPECT_EQ(completed("foldproof render a.glb --color co"), "collisions contacts\n");
  EXPECT_EQ(completed("foldproof check wa"), "\n") << "readline completes files";
}

}  // namespace
}  // namespace foldproof
