#include <fmt/format.h>

#include <algorithm>

#include "base/parallel.h"
#include "base/try.h"
#include "commands.h"
#include "progress_bar.h"
#include "step_options.h"
#include "sweep/sweep.h"
#include "sweep_ranks.h"
#include "terminal.h"

namespace foldproof {
namespace {

constexpr const char* kSweepFooter = R"(Below each DIR these are motions:
  .glb .gltf .npz .pvd            each file
  walk.pc2  walk.mdd              with the mesh of the same stem, or the only one beside it
  a_vertices.npy a_faces.npy      two whose names differ in the last word only, or vertices.npy and faces.npy
  run001.obj run002.obj ...       two meshes or more whose names differ in nothing but one number: frames of one motion
Each is one object, checked against itself. Single meshes are skipped, except with --static.

RESULTS gets a line of JSON as soon as a motion is done. Ctrl-C, or a crash, loses only the motion that is being checked:
the same command continues from there. It checks again only motions that changed, or were checked with other settings.
A file that cannot be read gets a line too, and does not stop the sweep. So do numbered meshes that look like bodies:
they are 'unclear' until --sequence or --separate says what they are.

Exit code: 0 no collision and no crossing in a first frame, 1 these, or files that could not be read or are unclear,
2 error.

Examples:
  foldproof sweep library -o results.jsonl                        check everything below library/
  foldproof sweep library -o results.jsonl --summary page.html    and write a table of all motions
  foldproof sweep library -o results.jsonl --again                check everything again
  foldproof sweep library cloth -o all.jsonl --model body.model   two folders; the model for motions of its mesh
  mpirun -n 9 foldproof sweep library -o results.jsonl            eight processes check, one distributes (docs/sweep.md))";

struct SweepArguments : StepArguments {
  std::string output, summary, command;
  double patience = 30;
  bool again = false, quiet = false;
};

void add_sweep_options(const Subcommand& sweep, SweepArguments& a) {
  a.files
      .reads(sweep.add_option("DIR", a.motions, "Where to look for motions (see below)"),
             FileArguments::Input::Library)
      .type_name("")
      .required();
  add_setting_options(sweep, a);
  sweep.option("--model").description(
      "A model from 'foldproof train', used for the motions of its mesh; may be given several times");
  sweep.option("--static")
      .description("Find triangles that cross in each frame instead, exactly; also in single meshes");
  sweep.option("--separate")
      .description("Numbered mesh files are single meshes (see --static), not frames of one motion");
  sweep.option("--sequence").description("Numbered mesh files are frames, also if they look like bodies");

  const char* group = "Output";
  a.files
      .writes(sweep.add_option("-o,--output", a.output,
                               "A line of JSON per motion; existing results are continued"))
      .type_name("RESULTS")
      .required()
      .group(group);
  a.files
      .writes(sweep.add_option("--summary", a.summary, "A table of all motions, one HTML file"),
              FileArguments::Output::File, {".html", ".htm"})
      .type_name("PAGE")
      .group(group);
  sweep.add_flag("--again", a.again, "Check everything, even motions that have a line").group(group);
  sweep.add_flag("-q,--quiet", a.quiet, "Print nothing but errors").group(group);
  sweep
      .add_option(
          "--patience", a.patience,
          "With mpirun: a process that has not responded for so long is lost, and others do its work [30]")
      .type_name("SECONDS")
      .group("Several machines");
}

Result<SweepSettings> load_settings(const SweepArguments& a) {
  const auto check = FOLDPROOF_TRY(step_settings(a));
  SweepSettings settings{check, a.motion.read, {}};
  settings.models = FOLDPROOF_TRY(load_models(a.models, {}));
  return settings;
}

/// Uses all cores, divided among the processes of this sweep on this machine.
Result<void> share_cores(const SweepArguments& a, const Ranks& ranks, std::optional<ThreadLimit>& limit) {
  int threads = a.threads;
  if (threads == 0 && ranks.local_count() > 1) threads = std::max(1, thread_count() / ranks.local_count());
  return limit_threads(threads, limit);
}

/// Checks the motions one after the other, each with all threads. False: cancelled.
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
    FOLDPROOF_TRY(task.done(motion, *line));
  }
  return true;
}

/// A progress bar over the remaining motions, weighted by size.
class SweepBar {
 public:
  SweepBar(bool enabled, const SweepInput& input, const SweepFile& file)
      : bar_(enabled), input_(input), file_(file), count_(file.remaining().size()) {
    for (const std::size_t motion : file.remaining()) all_ += weight(motion);
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

/// The first few records with a state, and the number of others.
std::string list_of(const std::vector<SweepRecord>& records, SweepState state, const SweepArguments& a) {
  constexpr std::size_t kMaxShown = 10;
  std::string text;
  std::size_t count = 0;
  for (const SweepRecord& r : records) {
    if (r.state != state || ++count > kMaxShown) continue;
    if (state == SweepState::Failed || state == SweepState::Unclear) {
      text += "  " + r.error + '\n';
    } else {
      text += fmt::format("  {}: {}\n", Error{r.path, "", ""}.where, found_in(r, a));
    }
  }
  if (count > kMaxShown) text += fmt::format("  and {} more, in {}\n", count - kMaxShown, a.output);
  if (count == 0) return "";
  const char* heading = state == SweepState::Failed    ? "\nCould not be read:\n"
                        : state == SweepState::Unclear ? "\nUnclear:\n"
                                                       : "\nCollide:\n";
  return heading + text;
}

/// "2 single mesh files and 1 single .npy file"
std::string left_out(const SweepInput& input) {
  std::string meshes = counted(input.single_meshes, "single mesh file");
  if (input.single_arrays == 0) return meshes;
  const std::string arrays = counted(input.single_arrays, "single .npy file");
  return input.single_meshes == 0 ? arrays : meshes + " and " + arrays;
}

std::string closing(const SweepArguments& a, const SweepInput& input, const SweepFile& file,
                    const SweepSettings& settings) {
  const auto& records = file.records();
  const auto count = [&](SweepState state) {
    return grouped(static_cast<std::uint64_t>(
        std::count_if(records.begin(), records.end(), [&](const auto& r) { return r.state == state; })));
  };
  std::string text = fmt::format("motions                 {}", grouped(records.size()));
  if (const std::size_t before = input.motions.size() - file.remaining().size(); before > 0)
    text += fmt::format("  ({} of them checked before)", grouped(before));
  text += fmt::format("\n  {:<22}{}\n  collide               {}\n  could not be read     {}\n",
                      a.steps_only ? "no contact in steps" : "clean", count(SweepState::Clean),
                      count(SweepState::Collides), count(SweepState::Failed));
  if (count(SweepState::Unclear) != "0")
    text += fmt::format("  unclear               {}\n", count(SweepState::Unclear));
  if (count(SweepState::Still) != "0")
    text += fmt::format("  a single pose         {}\n", count(SweepState::Still));
  if (input.single_meshes + input.single_arrays > 0)
    text += fmt::format("skipped                 {}\n", left_out(input));
  if (a.steps_only) text += "first frames            not tested for crossings (--steps-only)\n";
  if (a.poses) text += "motion between frames   not tested (--static)\n";
  if (!settings.check.frames.selects_all())
    text += fmt::format("frames                  only {} of each motion (--frames)\n", a.motion.frames);
  if (const std::string cut = contacts_cut(records); !cut.empty())
    text += fmt::format("contacts                {}\n", cut);
  for (const auto& pair : settings.check.ignore) {
    const auto motions = std::count_if(records.begin(), records.end(), [&](const SweepRecord& r) {
      return std::ranges::find(r.ignored, pair) != r.ignored.end();
    });
    text +=
        fmt::format("ignored                 {}, in {}\n",
                    printable(pair[0] == pair[1] ? pair[0] + " with itself" : pair[0] + " and " + pair[1]),
                    counted(static_cast<std::uint64_t>(motions), "motion"));
  }
  for (const auto& model : settings.models) {
    const bool used =
        std::any_of(records.begin(), records.end(), [&](const auto& r) { return r.model == model->name; });
    if (!used)
      text += fmt::format("not used                {}: of none of these meshes\n", cell(model->name));
  }
  for (const SweepState state : {SweepState::Collides, SweepState::Failed, SweepState::Unclear})
    text += list_of(records, state, a);
  return text;
}

Result<void> require_sense(const SweepArguments& a) {
  FOLDPROOF_TRY(a.files.check());
  if (!(a.patience >= 1))
    return fail(ErrorCode::InvalidArgument, "--patience",
                fmt::format("{} s is less than the interval of heartbeats", a.patience), "give 1 or more");
  return {};
}

Result<SweepInput> find_some(const SweepArguments& a) {
  auto input = find_motions(a.motions, a.poses, a.motion.read.mesh_files == MeshFiles::Separate);
  if (input && input->motions.empty()) {
    return fail(ErrorCode::InvalidArgument, a.motions[0],
                fmt::format("holds no motions, and {}", left_out(*input)),
                "'foldproof sweep --help' lists what is found; --static checks single meshes");
  }
  return input;
}

/// Runs the sweep in rank 0, or in the only process.
Result<int> lead(const SweepArguments& a, Ranks& ranks) {
  FOLDPROOF_TRY(require_sense(a));
  const auto settings = FOLDPROOF_TRY(load_settings(a));
  const auto input = FOLDPROOF_TRY(find_some(a));
  const std::atomic<bool>& interrupted = watch_for_interrupt();
  auto file = FOLDPROOF_TRY(SweepFile::open(a.output, input, settings_hash(settings), a.again));

  SweepBar bar(!a.quiet, input, file);
  const auto done = [&](std::size_t motion, const std::string& line) {
    auto added = file.add(line);
    if (added) bar.finish(motion);
    return added;
  };
  const SweepTask task{input.motions, file.remaining(), settings, done, [&](auto parts) { bar.show(parts); },
                       &interrupted};
  const auto finished = ranks.alone() ? check_here(task) : ranks.distribute(task);
  bar.clear();
  if (!finished) return tl::unexpected(finished.error());
  const auto& records = file.records();
  if (!*finished) {
    print_error({"interrupted",
                 fmt::format("{} of {} are done", records.size(), counted(input.motions.size(), "motion")),
                 "the same command continues from there"});
    return kExitInterrupted;
  }
  if (!a.summary.empty()) {
    const std::string frames = settings.check.frames.selects_all() ? "" : a.motion.frames;
    FOLDPROOF_TRY(
        write_sweep_page(a.summary, records, {a.command, input.directories, a.poses, a.steps_only, frames}));
  }
  if (!a.quiet) print_output(closing(a, input, file, settings));
  return exit_code(std::all_of(records.begin(), records.end(), [](const SweepRecord& r) {
    return r.state == SweepState::Clean || r.state == SweepState::Still;
  }));
}

Result<int> sweep(const SweepArguments& a) {
  auto ranks = FOLDPROOF_TRY(Ranks::join(a.patience));
  std::optional<ThreadLimit> limit;
  const auto limited = share_cores(a, ranks, limit);
  if (!ranks.leads()) {
    return ranks.work([&] { return load_settings(a); }, watch_for_interrupt());
  }
  auto answer = limited ? lead(a, ranks) : tl::unexpected(limited.error());
  ranks.dismiss();
  return answer;
}

}  // namespace

Command add_sweep(CommandLine& program, std::span<char* const> arguments) {
  const Subcommand command = program.add_subcommand(
      "sweep", "Check every motion below directories, and continue where it was stopped");
  command.footer(kSweepFooter);
  const auto a = std::make_shared<SweepArguments>();
  a->command = command_line(arguments);
  add_sweep_options(command, *a);
  return [a] { return sweep(*a); };
}

}  // namespace foldproof
