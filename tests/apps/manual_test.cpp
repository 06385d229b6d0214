// Manual pages and completions, as they are installed.
#include <gmock/gmock.h>

#include "apps/program.h"

namespace foldproof {
namespace {

using namespace foldproof::testing;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

struct Share : TemporaryDirectory {
  Share() { EXPECT_EQ(run_program({"write-share", path()}).code, 0); }

  std::string page(const std::string& name) const { return read_file(*this / ("man/man1/" + name + ".1")); }

  Outcome shell(const std::string& program, std::vector<std::string> arguments) const {
    return run_program(std::move(arguments), {.directory = path(), .program = program});
  }
  /// What bash completes after these words.
  std::string completed(const std::string& words) const {
    return shell("/bin/bash",
                 {"-c", "source bash-completion/completions/foldproof; COMP_WORDS=(" + words +
                            "); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); _foldproof; echo \"${COMPREPLY[@]}\""})
        .out;
  }
};

TEST(Manual, EveryCommandHasAPage) {
  const Share share;
  const std::string program = share.page("foldproof"), check = share.page("foldproof-check");
  EXPECT_THAT(program, HasSubstr("\n.SH COMMANDS\n"));
  EXPECT_THAT(program, HasSubstr("\\fBfoldproof\\-sweep\\fR(1)"));
  EXPECT_THAT(check, HasSubstr("[\\fIOPTION\\fR]... \\fIMOTION...\\fR\n"));
  EXPECT_THAT(check, HasSubstr("\n.PP\nSeveral motions are several objects"));
  EXPECT_THAT(check, HasSubstr("\\fB\\-\\-thickness\\fR \\fID\\fR\n"));
  EXPECT_THAT(check, HasSubstr("\\fB\\-q\\fR, \\fB\\-\\-quiet\\fR\n"));
  EXPECT_THAT(check, HasSubstr("\n.SH EXIT STATUS\n0 no collision"));
  EXPECT_THAT(check, HasSubstr(".SH EXAMPLES\n.TP\n\\fBfoldproof check walk.glb\\fR\nevery collision"));
  EXPECT_FALSE(fs::exists(share / "man/man1/foldproof-write-share.1"));
  EXPECT_FALSE(fs::exists(share / "man/man1/foldproof-help.1"));
}

TEST(Manual, EveryPageIsRenderedWithoutWarnings) {
  if (!fs::exists("/usr/bin/groff")) GTEST_SKIP() << "groff is not installed";
  const Share share;
  for (const auto& page : fs::directory_iterator(share / "man/man1")) {
    const Outcome outcome =
        share.shell("/usr/bin/groff", {"-man", "-Tutf8", "-ww", "-P-cbou", page.path().string()});
    EXPECT_EQ(outcome.code, 0);
    EXPECT_EQ(outcome.err, "");
    EXPECT_THAT(outcome.out, HasSubstr("SYNOPSIS"));
  }
}

TEST(Completion, BashCompletesCommandsOptionsAndValues) {
  const Share share;
  EXPECT_EQ(share.completed("foldproof ch"), "check\n");
  EXPECT_EQ(share.completed("foldproof --ver"), "--version\n");
  EXPECT_EQ(share.completed("foldproof help tr"), "train\n");
  EXPECT_EQ(share.completed("foldproof check walk.glb --thi"), "--thickness\n");
  EXPECT_EQ(share.completed("foldproof check walk.glb --mode p"), "proven paper\n");
  EXPECT_EQ(share.completed("foldproof check wa"), "\n") << "readline completes files";
}

TEST(Completion, ZshFindsItsFunction) {
  if (!fs::exists("/usr/bin/zsh")) GTEST_SKIP() << "zsh is not installed";
  const Share share;
  const Outcome syntax = share.shell("/usr/bin/zsh", {"-n", "zsh/site-functions/_foldproof"});
  EXPECT_EQ(syntax.code, 0) << syntax.err;
  const Outcome found =
      share.shell("/usr/bin/zsh", {"-fc",
                                   "fpath=($PWD/zsh/site-functions $fpath); autoload -Uz compinit; "
                                   "compinit -u -D; echo $_comps[foldproof]"});
  EXPECT_EQ(found.out, "_foldproof\n") << found.err;
}

TEST(Completion, FishCompletes) {
  if (!fs::exists("/usr/bin/fish")) GTEST_SKIP() << "fish is not installed";
  const Share share;
  const auto completed = [&](const std::string& words) {
    const Outcome outcome = share.shell(
        "/usr/bin/fish", {"--no-config", "-c",
                          "source fish/vendor_completions.d/foldproof.fish; complete -C '" + words + "'"});
    EXPECT_EQ(outcome.err, "");
    return outcome.out;
  };
  EXPECT_THAT(completed("foldproof che"), HasSubstr("check\tFind every"));
  EXPECT_THAT(completed("foldproof check --thi"), HasSubstr("--thickness\t"));
  EXPECT_THAT(completed("foldproof check --mode pa"), HasSubstr("paper"));
}

}  // namespace
}  // namespace foldproof
