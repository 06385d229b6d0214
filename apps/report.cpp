#include <fmt/format.h>

#include "commands.h"
#include "page_files.h"
#include "run_and_summarize.h"
#include "step_options.h"
#include "terminal.h"

namespace foldproof {
namespace {

constexpr const char* kFooter = R"(Several motions are several objects, and need equally many frames.

The report is one file that opens in any browser, offline: what crosses in the first frame, what collides and when,
charts of every step, pictures of the start and of the worst steps, what was proven and why not the rest, the settings and
the version. It names the files as they were typed.

Exit code: 0 no collision and no crossing in the first frame, 1 collisions or crossings, 2 error.

Examples:
  foldproof report walk.glb -o report.html
  foldproof report body.npz shirt.npz --between -o shirt.html
  foldproof report walk.glb --model body.model --frames 10:21 -o report.html)";

struct ReportArguments : StepArguments {
  std::string output, command;
  bool quiet = false;
};

Result<int> report(const ReportArguments& a) {
  if (const auto ok = a.files.check(); !ok) return tl::unexpected(ok.error());
  const auto files = require_page_files();
  if (!files) return tl::unexpected(files.error());
  std::optional<ThreadLimit> limit;
  if (const auto ok = limit_threads(a.threads, limit); !ok) return tl::unexpected(ok.error());
  auto opened = open_motions(a);
  if (!opened) return tl::unexpected(opened.error());
  CheckSettings& settings = opened->settings;
  settings.step.explain = true;
  // From here on a file is open that must not stay behind half written.
  watch_for_interrupt();
  auto writer = page_report(a.output, opened->motions, {{settings, a.motion.read}, a.command}, *files);
  if (!writer) return tl::unexpected(writer.error());
  return run_and_summarize(opened->motions, settings, std::span(&*writer, 1), a.quiet);
}

}  // namespace

Command add_report(CLI::App& program, std::span<char* const> typed) {
  CLI::App* command =
      program.add_subcommand("report", "Check motions and write what was found into one HTML file to mail");
  command->footer(std::string(kMotionHelp) + kFooter);
  const auto a = std::make_shared<ReportArguments>();
  a->command = command_line(typed);
  add_step_options(*command, *a);
  a->files.writes(command->add_option("-o,--output", a->output, "The report to write"))
      ->type_name("FILE")
      ->required();
  command->add_flag("--quiet", a->quiet, "Print nothing but errors");
  return [a] { return report(*a); };
}

}  // namespace foldproof
