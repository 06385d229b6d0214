#include "run_and_summarize.h"

#include <fmt/format.h>

#include <algorithm>

#include "commands.h"
#include "contact_lines.h"
#include "options.h"
#include "progress_bar.h"
#include "terminal.h"

namespace foldproof {
namespace {

/// What to know before the contacts.
std::string notices_of(Motions motions, const CheckTotals& totals) {
  std::string text;
  for (const auto& [object, notice] : totals.notices)
    text += fmt::format("\n{}: {}\n", cell(motions[object]->name()), printable(notice));
  return text;
}

/// Frames whose names are not numbered are bodies.
std::string frames_hint(Motions motions, const ReadOptions& read) {
  if (read.mesh_files == MeshFiles::Separate) return "";
  const auto is_frame = [&](const auto& motion) {
    return motion->frame_count() == 1 && motion->topology() == motions[0]->topology();
  };
  if (motions.size() < 3 || !std::ranges::all_of(motions, is_frame)) return "";
  return fmt::format(
      "\nAll {} meshes have the same triangles. If they are frames of one motion, check them with "
      "--sequence.\n",
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

Result<int> run_and_summarize(Motions motions, const ReadOptions& read, const CheckSettings& settings,
                              Writers writers, bool quiet, std::size_t contacts) {
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
    print_output(summary(motions, settings, *totals) + notices_of(motions, *totals) +
                 contact_lines(motions, settings, *totals, contacts) + frames_hint(motions, read) +
                 notes_of(motions));
  }
  return exit_code(totals->clean());
}

}  // namespace foldproof
