#include <fmt/format.h>

#include "base/try.h"
#include "commands.h"
#include "page_files.h"
#include "run_and_summarize.h"
#include "step_options.h"
#include "terminal.h"

namespace foldproof {
namespace {

constexpr const char* kReportFooter =
    R"(Several motions are several objects. They need equally many frames, or a single one, which stands still.

The report is one file that opens in any browser, offline. It shows the contacts, the worst first, with pictures; what
crosses in the first frame, what collides and when; charts of every step; what was proven and why not the rest; the
settings and the version. With --static it shows what crosses in each frame instead. It names files as they were typed.

Exit code: 0 no collision and no crossing in the first frame, 1 collisions or crossings, 2 error.

Examples:
  foldproof report walk.glb -o report.html
  foldproof report body.npz shirt.npz --between -o shirt.html
  foldproof report poses/ --static -o poses.html
  foldproof report walk.glb --model body.model --frames 10:21 -o report.html)";

struct ReportArguments : StepArguments {
  std::string output, command;
  bool quiet = false;
};

Result<int> report(const ReportArguments& a) {
  FOLDPROOF_TRY(a.files.check());
  const auto files = FOLDPROOF_TRY(require_page_files());
  std::optional<ThreadLimit> limit;
  FOLDPROOF_TRY(limit_threads(a.threads, limit));
  auto opened = FOLDPROOF_TRY(open_motions(a, a.quiet));
  CheckSettings& settings = opened.settings;
  settings.step.explain = true;
  // From here on an interrupt must not leave an incomplete file behind.
  watch_for_interrupt();
  const auto writer =
      FOLDPROOF_TRY(page_report(a.output, opened.motions, {{settings, a.motion.read}, a.command}, files));
  return run_and_summarize(opened.motions, a.motion.read, settings, std::span(&writer, 1), a.quiet);
}

}  // namespace

Command add_report(CommandLine& program, std::span<char* const> arguments) {
  const Subcommand command =
      program.add_subcommand("report", "Check motions and write the results to one HTML file");
  command.footer(std::string(kMotionHelp) + kReportFooter);
  const auto a = std::make_shared<ReportArguments>();
  a->command = command_line(arguments);
  add_step_options(command, *a);
  a->files
      .writes(command.add_option("-o,--output", a->output, "The report to write"),
              FileArguments::Output::File, {".html", ".htm"})
      .type_name("FILE")
      .required();
  command.add_flag("-q,--quiet", a->quiet, "Print nothing but errors");
  return [a] { return report(*a); };
}

}  // namespace foldproof
