#include <fmt/format.h>

#include <cstdlib>

#include "base/try.h"
#include "commands.h"
#include "page_files.h"
#include "step_options.h"
#include "system/program.h"
#include "terminal.h"

namespace foldproof {
namespace {

constexpr const char* kViewFooter = R"(  pose.obj                        a single pose: what crosses in it
Several motions are several objects. They need equally many frames, or a single one, which stands still.

The page shows the motion at once, while the check runs: it first finds what crosses in the first frame, then what
collides in each step. With --static, frames are no motion but poses of their own, and it finds what crosses in each.
Answers appear as they come; contacts at the end. The page is served to this machine only (http://127.0.0.1:PORT),
reads only the files named here, and writes nothing. Ctrl-C ends it.

Examples:
  foldproof view walk.glb                         look at it in the browser
  foldproof view body.npz shirt.npz               two objects
  foldproof view walk.glb --model body.model      with key points, mode sliders and predictions
  foldproof view poses/ --static                  poses that are no motion: what crosses in each of them
  foldproof view walk.glb --frames 10:21          only frames 10 to 20
  foldproof view walk.glb --substeps 10           each step in ten straight parts
  foldproof view walk.glb --no-browser --port 8000
                                                  on a machine without a display; from your own, first:
                                                  ssh -L 8000:127.0.0.1:8000 THAT_MACHINE)";

struct ViewArguments : StepArguments {
  std::string unit, command;
  int port = 0;
  bool no_browser = false;
};

// At once, whatever is checked and connected. There is nothing to finish: temporary files have no names.
extern "C" void end(int) { std::_Exit(kExitClean); }

Result<int> view(const ViewArguments& a) {
  FOLDPROOF_TRY(a.files.check());
  const auto files = FOLDPROOF_TRY(require_page_files());
  if (a.port < 0 || a.port > 65535)
    return fail(ErrorCode::InvalidArgument, "--port", fmt::format("{} is not between 1 and 65535", a.port),
                "give another, or leave it out");
  std::optional<ThreadLimit> limit;
  FOLDPROOF_TRY(limit_threads(a.threads, limit));
  auto opened = FOLDPROOF_TRY(open_motions(a));
  opened.settings.unit = a.unit;
  const auto page = FOLDPROOF_TRY(Page::open({.motions = std::move(opened.motions),
                                              .check = std::move(opened.settings),
                                              .read = a.motion.read,
                                              .files = files,
                                              .command = a.command}));
  auto server = FOLDPROOF_TRY(PageServer::open(*page, files, a.port));
  system::on_interrupt(end);
  const std::string address = fmt::format("http://127.0.0.1:{}/", server.port());
  print_output(fmt::format("{} (Ctrl-C ends it)\n", address));
  FOLDPROOF_TRY(flush_output());
  if (!a.no_browser) system::open_browser(address);  // failure is no error: the address has been printed
  FOLDPROOF_TRY(server.serve());
  return kExitClean;
}

}  // namespace

Command add_view(CommandLine& program, std::span<char* const> arguments) {
  const Subcommand command =
      program.add_subcommand("view", "Look at motions, collisions and proofs in the browser");
  command.footer(std::string(kMotionHelp) + kViewFooter);
  const auto a = std::make_shared<ViewArguments>();
  a->command = command_line(arguments);
  add_step_options(command, *a);
  command.add_option("--unit", a->unit, "What a mesh unit is, such as cm: named beside lengths [m for glTF]")
      .type_name("NAME");
  command
      .add_option("--port", a->port,
                  fmt::format("Where to serve [the first free one from {} on]", kFirstPagePort))
      .type_name("N");
  command.add_flag("--no-browser", a->no_browser, "Print the address and open nothing");
  return [a] { return view(*a); };
}

}  // namespace foldproof
