#include <fmt/format.h>

#include <algorithm>

#include "base/parallel.h"
#include "commands.h"
#include "step_options.h"
#include "sweep/sweep.h"
#include "sweep_ranks.h"
#include "terminal.h"

namespace foldproof {
namespace {

constexpr const char* kFooter = R"(Below each DIR these are motions:
  walk.glb  walk.gltf  walk.npz   each file
  walk.pc2  walk.mdd              with the OBJ, OFF or PLY of the same stem, or the only one beside it
  run001.obj run002.obj ...       two meshes or more whose names differ in their last number only: frames of one motion
Each is one object, checked against itself. Single meshes are left out, unless --static asks for crossing triangles.

RESULTS gets a line of JSON as soon as a motion is done. Ctrl-C, or worse, loses only the motion that is being checked: the
same command goes on from there. It checks anew what changed since, what was checked otherwise, and nothing else.
A file that cannot be read is a line, too, and does not stop the sweep.

Exit code: 0 no collision and no crossing in a first frame, 1 these or files that could not be read, 2 the sweep itself could not be made.

Examples:
  foldproof sweep library -o results.jsonl                        check everything below library/
  foldproof sweep library -o results.jsonl --summary page.html    and write a table of all to look at
  foldproof sweep library -o results.jsonl --again                from the beginning
  foldproof sweep walks runs -o results.jsonl --model body.model --model hand.model
                                                                  each model for the motions of its mesh
  mpirun -n 9 foldproof sweep library -o results.jsonl            eight processes check, one hands out (docs/sweep.md))";

struct SweepArguments : StepArguments {
  std::string output, summary, command;
  double patience = 30;
  bool poses = false, again = false, quiet = false;
};

void add_options(CLI::App& sweep, SweepArguments& a) {
  a.files
      .reads(sweep.add_option("DIR", a.motions, "Where to look for motions (see below)"),
             FileArguments::Input::Library)
      ->type_name("")
      ->required();
  add_setting_options(sweep, a);
  sweep.get_option("--model")->description(
      "What 'foldproof train' found out, used for the motions of its mesh; may be given several times");
  auto* poses =
      sweep
          .add_flag("--static", a.poses,
                    "Crossing triangles of each frame instead, decided exactly; of single meshes, too")
          ->group(sweep.get_option("--thickness")->get_group());
  for (const char* option : {"--thickness", "--tolerance", "--substeps", "--steps-only"})
    sweep.get_option(option)->excludes(poses);

  const char* group = "Where the answer goes";
  a.files
      .writes(sweep.add_option("-o,--output", a.output,
                               "A line of JSON per motion; goes on with what stands there"))
      ->type_name("RESULTS")
      ->required()
      ->group(group);
  a.files.writes(sweep.add_option("--summary", a.summary, "A table of all motions, one HTML file"))
      ->type_name("PAGE")
      ->group(group);
  sweep.add_flag("--again", a.again, "Check everything, also what has its line")->group(group);
  sweep.add_flag("--quiet", a.quiet, "Print nothing but errors")->group(group);
  sweep
      .add_option("--patience", a.patience,
                  "With mpirun: a process not heard of for so long is lost, and others do its work [30]")
      ->type_name("SECONDS")
      ->group("Several machines");
}

Result<SweepSettings> load_settings(const SweepArguments& a) {
  const auto check = step_settings(a);
  if (!check) return tl::unexpected(check.error());
  SweepSettings settings{*check, a.motion.read, {}};
  settings.check.poses = a.poses;
  auto models = load_models(a.models, {});
  if (!models) return tl::unexpected(models.error());
  settings.models = std::move(*models);
  return settings;
}

/// All cores, unless they are shared with other processes of this sweep.
Result<void> share_cores(const SweepArguments& a, const Ranks& ranks, std::optional<ThreadLimit>& limit) {
  int threads = a.threads;
  if (threads == 0 && ranks.here() > 1) threads = std::max(1, thread_count() / ranks.here());
  return limit_threads(threads, limit);
}

/// One motion after the other, each with all threads. False: cancelled.
Result<bool> check_here(const SweepTask& task) {
  for (const std::size_t motion : task.todo) {
    CheckHooks hooks;
    hooks.cancel = task.cancel;
    hooks.progress = [&](const CheckTotals& totals, std::uint64_t expected) {
      const std::pair<std::size_t, double> part{
          motion, static_cast<double>(totals.steps) / static_cast<double>(expected)};
      task.progress(std::span(&part, 1));
    };
    if (*task.cancel) return false;
    const auto line = sweep_line(task.motions[motion], task.settings, hooks);
    if (!line) return false;
    if (auto done = task.done(motion, *line); !done) return tl::unexpected(done.error());
  }
  return true;
}

/// The bar over all motions that are left, weighed by their size.
class SweepBar {
 public:
  SweepBar(bool wanted, const SweepInput& input, const SweepFile& file)
      : bar_(wanted), input_(input), file_(file), count_(file.left().size()) {
    for (const std::size_t motion : file.left()) all_ += weight(motion);
  }

  void finish(std::size_t motion) {
    done_ += weight(motion);
    show({});
  }

  void show(std::span<const std::pair<std::size_t, double>> parts) {
    double sum = done_;
    for (const auto& [motion, part] : parts) sum += part * weight(motion);
    const auto& records = file_.records();
    const auto count = [&](SweepState state) {
      return std::count_if(records.begin(), records.end(), [&](const auto& r) { return r.state == state; });
    };
    const std::size_t before = input_.motions.size() - count_;
    bar_.show(std::clamp(sum / all_, 1e-6, 1.0),
              fmt::format("{} of {} motions, {} collide, {} failed", records.size() - before, count_,
                          count(SweepState::Collides), count(SweepState::Failed)));
  }

  void clear() { bar_.clear(); }

 private:
  double weight(std::size_t motion) const { return static_cast<double>(input_.motions[motion].bytes) + 1; }

  ProgressBar bar_;
  const SweepInput& input_;
  const SweepFile& file_;
  std::size_t count_;
  double all_ = 0, done_ = 0;
};

/// "the first frame starts with 2 crossing pairs; 3 pairs in 1 of 4 steps, the first in frame 2"
std::string found_in(const SweepRecord& r, const SweepArguments& a) {
  std::string text;
  if (r.starts_crossing.value_or(0) > 0)
    text = fmt::format("the first frame starts with {}", counted(*r.starts_crossing, "crossing pair"));
  if (r.collisions == 0) return text;
  return (text.empty() ? "" : text + "; ") +
         fmt::format("{} in {} of {}, the first in frame {}", counted(r.collisions, "pair"),
                     grouped(r.steps_with_collisions), counted(r.steps, a.poses ? "pose" : "step"),
                     r.first_frame.value_or(0));
}

/// The first few of a kind, and how many more there are.
std::string list_of(const std::vector<SweepRecord>& records, SweepState state, const SweepArguments& a) {
  constexpr std::size_t kMost = 10;
  std::string text;
  std::size_t count = 0;
  for (const SweepRecord& r : records) {
    if (r.state != state || ++count > kMost) continue;
    if (state == SweepState::Failed) {
      text += "  " + r.error + '\n';
    } else {
      text += fmt::format("  {}: {}\n", Error{r.path, "", ""}.where, found_in(r, a));
    }
  }
  if (count > kMost) text += fmt::format("  and {} more, in {}\n", count - kMost, a.output);
  if (count == 0) return "";
  return (state == SweepState::Failed ? "\nCould not be read:\n" : "\nCollide:\n") + text;
}

std::string closing(const SweepArguments& a, const SweepInput& input, const SweepFile& file,
                    const SweepSettings& settings) {
  const auto& records = file.records();
  const auto count = [&](SweepState state) {
    return grouped(static_cast<std::uint64_t>(
        std::count_if(records.begin(), records.end(), [&](const auto& r) { return r.state == state; })));
  };
  std::string text = fmt::format("motions                 {}", grouped(records.size()));
  if (const std::size_t before = input.motions.size() - file.left().size(); before > 0)
    text += fmt::format("  ({} of them checked before)", grouped(before));
  text += fmt::format("\n  {:<22}{}\n  collide               {}\n  could not be read     {}\n",
                      a.steps_only ? "no contact in steps" : "clean", count(SweepState::Clean),
                      count(SweepState::Collides), count(SweepState::Failed));
  if (count(SweepState::Still) != "0")
    text += fmt::format("  a single pose         {}\n", count(SweepState::Still));
  if (input.single_meshes > 0)
    text += fmt::format("left out                {}\n", counted(input.single_meshes, "single mesh file"));
  if (a.steps_only) text += "first frames            not asked what crosses in them (--steps-only)\n";
  for (const auto& model : settings.models) {
    const bool used =
        std::any_of(records.begin(), records.end(), [&](const auto& r) { return r.model == model->name; });
    if (!used)
      text += fmt::format("not used                {}: of none of these meshes\n", cell(model->name));
  }
  text += list_of(records, SweepState::Collides, a) + list_of(records, SweepState::Failed, a);
  return text;
}

Result<void> require_sense(const SweepArguments& a) {
  if (auto ok = a.files.check(); !ok) return ok;
  if (!(a.patience >= 1))
    return fail("--patience", fmt::format("{} s is less than signs of life need", a.patience),
                "give 1 or more");
  return {};
}

Result<SweepInput> find_some(const SweepArguments& a) {
  auto input = find_motions(a.motions, a.poses);
  if (input && input->motions.empty()) {
    return fail(a.motions[0],
                fmt::format("holds no motions, and {}", counted(input->single_meshes, "single mesh file")),
                "'foldproof sweep --help' says what is found; --static checks single meshes");
  }
  return input;
}

/// What rank 0 does, or the only process.
Result<int> lead(const SweepArguments& a, Ranks& ranks) {
  if (const auto ok = require_sense(a); !ok) return tl::unexpected(ok.error());
  const auto settings = load_settings(a);
  if (!settings) return tl::unexpected(settings.error());
  const auto input = find_some(a);
  if (!input) return tl::unexpected(input.error());
  const std::atomic<bool>& interrupted = watch_for_interrupt();
  auto file = SweepFile::open(a.output, *input, settings_hash(*settings), a.again);
  if (!file) return tl::unexpected(file.error());

  SweepBar bar(!a.quiet, *input, *file);
  const auto done = [&](std::size_t motion, const std::string& line) {
    auto added = file->add(line);
    if (added) bar.finish(motion);
    return added;
  };
  const SweepTask task{input->motions, file->left(), *settings, done, [&](auto parts) { bar.show(parts); },
                       &interrupted};
  const auto finished = ranks.alone() ? check_here(task) : ranks.hand_out(task);
  bar.clear();
  if (!finished) return tl::unexpected(finished.error());
  const auto& records = file->records();
  if (!*finished) {
    print_error({"interrupted",
                 fmt::format("{} of {} are done", records.size(), counted(input->motions.size(), "motion")),
                 "the same command goes on from there"});
    return kExitInterrupted;
  }
  if (!a.summary.empty()) {
    const auto written =
        write_sweep_page(a.summary, records, {a.command, input->directories, a.poses, a.steps_only});
    if (!written) return tl::unexpected(written.error());
  }
  if (!a.quiet) print_output(closing(a, *input, *file, *settings));
  const bool well = std::all_of(records.begin(), records.end(), [](const SweepRecord& r) {
    return r.state == SweepState::Clean || r.state == SweepState::Still;
  });
  return exit_code(well);
}

Result<int> sweep(const SweepArguments& a) {
  auto ranks = Ranks::join(a.patience);
  if (!ranks) return tl::unexpected(ranks.error());
  if (ranks->superfluous()) return kExitClean;
  std::optional<ThreadLimit> limit;
  const auto limited = share_cores(a, *ranks, limit);
  if (!ranks->leads()) {
    return ranks->work([&] { return load_settings(a); }, watch_for_interrupt());
  }
  auto answer = limited ? lead(a, *ranks) : tl::unexpected(limited.error());
  ranks->dismiss();
  return answer;
}

}  // namespace

Command add_sweep(CLI::App& program, std::span<char* const> typed) {
  CLI::App* command =
      program.add_subcommand("sweep", "Check every motion below directories, and go on where it was stopped");
  command->footer(kFooter);
  const auto a = std::make_shared<SweepArguments>();
  a->command = command_line(typed);
  add_options(*command, *a);
  return [a] { return sweep(*a); };
}

}  // namespace foldproof
