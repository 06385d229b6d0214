#include "run_and_summarize.h"

#include <fmt/format.h>

#include "commands.h"
#include "contact_lines.h"
#include "options.h"
#include "terminal.h"

namespace foldproof {

Result<int> run_and_summarize(Motions motions, const CheckSettings& settings, Writers writers, bool quiet,
                              std::size_t contacts) {
  ProgressBar bar(!quiet);
  CheckHooks hooks;
  hooks.progress = [&](const CheckTotals& totals, std::uint64_t expected) {
    bar.show(static_cast<double>(totals.steps) / static_cast<double>(expected),
             fmt::format("{} of {} {}s, {} with collisions", totals.steps, expected,
                         settings.poses ? "frame" : "step", totals.steps_with_collisions));
  };
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
    print_output(summary(motions, settings, *totals) + contact_lines(motions, settings, *totals, contacts));
  }
  return exit_code(totals->clean());
}

}  // namespace foldproof
