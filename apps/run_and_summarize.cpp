#include "run_and_summarize.h"

#include <fmt/format.h>

#include <algorithm>

#include "commands.h"
#include "contact_lines.h"
#include "io/readers.h"
#include "options.h"
#include "progress_bar.h"
#include "terminal.h"

namespace foldproof {
namespace {

/// Exporters double vertices at seams, where triangles then touch.
std::string weld_hint(Motions motions) {
  std::string text;
  for (const auto& motion : motions) {
    const Index count = io::count_weldable(*motion).value_or(0);
    if (count == 0) continue;
    text += fmt::format(
        "\nOf the {} vertices of {}, {} lie exactly where others do, and so their triangles touch.\n"
        "If they belong to one surface, check it with --weld.\n",
        grouped(motion->topology().vertex_count()), cell(motion->name()), grouped(count));
  }
  return text;
}

/// A shell expands the names of frames to meshes of their own where their numbers are not last.
std::string frames_hint(Motions motions) {
  const auto is_frame = [&](const auto& motion) {
    return motion->frame_count() == 1 && motion->topology() == motions[0]->topology();
  };
  if (motions.size() < 3 || !std::ranges::all_of(motions, is_frame)) return "";
  return fmt::format(
      "\nAll {} meshes have the same triangles. If they are frames of one motion, name their directory "
      "instead.\n",
      motions.size());
}

/// What readers left out comes last, where it is read.
std::string notes_of(Motions motions) {
  std::string text;
  for (const auto& motion : motions) {
    for (const std::string& note : motion->info().notes)
      text += fmt::format("\n{}: {}\n", cell(motion->name()), printable(note));
  }
  return text;
}

}  // namespace

Result<int> run_and_summarize(Motions motions, const CheckSettings& settings, Writers writers, bool quiet,
                              std::size_t contacts) {
  ProgressBar bar(!quiet);
  CheckHooks hooks;
  hooks.progress = [&](const CheckTotals& totals, std::uint64_t expected) {
    bar.show(static_cast<double>(totals.steps) / static_cast<double>(expected),
             fmt::format("{} of {} {}s, {} with collisions", totals.steps, expected,
                         settings.poses ? "frame" : "step", totals.steps_with_collisions));
  };
  hooks.stage = [&](const char* what) { bar.begin(what); };
  hooks.cancel = &watch_for_interrupt();
  const auto totals = run_check(motions, settings, writers, hooks);
  bar.clear();
  if (!totals) return tl::unexpected(totals.error());
  if (totals->cancelled) {
    print_error({"interrupted",
                 fmt::format("stopped at {} of {}, {} with collisions", grouped(totals->steps),
                             counted(totals->steps_expected, settings.poses ? "frame" : "step"),
                             grouped(totals->steps_with_collisions)),
                 "no report was written"});
    return kExitInterrupted;
  }
  if (!quiet) {
    print_output(summary(motions, settings, *totals) + contact_lines(motions, settings, *totals, contacts) +
                 (totals->clean() || !settings.reduced.empty() ? "" : weld_hint(motions)) +
                 frames_hint(motions) + notes_of(motions));
  }
  return exit_code(totals->clean());
}

}  // namespace foldproof
