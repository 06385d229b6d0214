#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>

#include "base/try.h"
#include "commands.h"
#include "progress_bar.h"
#include "step_options.h"
#include "sweep/shard.h"
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

Many processes, on one machine or several, share the work with --shard I/N: the I-th of N parts of the motions, each with
RESULTS of its own. --join makes of these the RESULTS of one sweep. docs/sweep.md shows it with Slurm, Kubernetes and ssh.

Exit code: 0 no collision and no crossing in a first frame, 1 these, or files that could not be read or are unclear,
2 error. A shard that is finished ends with 0, whatever it found; --join says what that was.

Examples:
  foldproof sweep library -o results.jsonl                        check everything below library/
  foldproof sweep library -o results.jsonl --summary page.html    and write a table of all motions
  foldproof sweep library -o results.jsonl --repair repaired      and repair what collides
  foldproof sweep library -o results.jsonl --again                check everything again
  foldproof sweep library cloth -o all.jsonl --model body.model   two folders; the model for motions of its mesh
  foldproof sweep library --shard 1/2 -o shard-1.jsonl            one of two parts
  foldproof sweep library --shard 2/2 -o shard-2.jsonl            the other one, perhaps on another machine
  foldproof sweep --join shard-*.jsonl -o results.jsonl           both together)";

struct SweepArguments : StepArguments {
  std::string output, summary, repaired, command;
  std::vector<std::string> shard;  // one; none if it is not given, unlike ""
  std::vector<std::string> join;
  bool again = false, quiet = false;
};

void add_sweep_options(const Subcommand& sweep, SweepArguments& a) {
  a.files
      .reads(sweep.add_option("DIR", a.motions, "Where to look for motions (see below)"),
             FileArguments::Input::Library)
      .type_name("");
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
  sweep
      .add_option("--repair", a.repaired,
                  "A directory for motions that collide, repaired, under their paths: GLB of glTF, else NPZ")
      .type_name("DIR")
      .group(group);
  sweep.add_flag("--again", a.again, "Check everything, even motions that have a line").group(group);
  sweep.add_flag("-q,--quiet", a.quiet, "Print nothing but errors").group(group);

  const char* shards = "Several processes or machines";
  sweep.add_option("--shard", a.shard, "Check only the I-th of N parts, from 1/N to N/N")
      .expected(1, 1)
      .type_name("I/N")
      .group(shards);
  const Option join = a.files.reads(sweep.add_option("--join", a.join, "Join the RESULTS of all shards"))
                          .type_name("FILE...")
                          .group(shards);
  sweep.exclude_all_but(join, std::array{"--output", "--summary", "--quiet", "--help"});
}

Result<SweepSettings> load_settings(const SweepArguments& a) {
  const auto check = FOLDPROOF_TRY(step_settings(a));
  if (!a.repaired.empty() && (a.poses || a.steps_only))
    return fail(ErrorCode::InvalidArgument, "--repair", "is of whole motions",
                fmt::format("leave out {}", a.poses ? "--static" : "--steps-only"));
  SweepSettings settings{check, a.motion.read, {}, a.repaired};
  settings.models = FOLDPROOF_TRY(load_models(a.models, {}));
  return settings;
}

/// So that no sweep finds what another has repaired.
Result<void> require_outside(const std::string& repaired, const std::vector<std::string>& directories) {
  namespace fs = std::filesystem;
  std::error_code ignored;
  const fs::path target = fs::weakly_canonical(fs::absolute(repaired, ignored), ignored);
  for (const std::string& directory : directories) {
    const fs::path swept = fs::weakly_canonical(fs::absolute(directory, ignored), ignored);
    const fs::path below = target.lexically_relative(swept);
    if (repaired.empty() || below.empty() || *below.begin() == "..") continue;
    return fail(ErrorCode::InvalidArgument, "--repair " + repaired,
                fmt::format("is in {}, where motions are looked for", directory),
                "name a directory elsewhere");
  }
  return {};
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
    show(motion, 0);
  }

  /// `part`: how much of the motion is done.
  void show(std::size_t motion, double part) {
    const double sum = done_ + part * weight(motion);
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

/// The first few records with a state, and the number of others, which are in `file`.
std::string list_of(const std::vector<SweepRecord>& records, SweepState state, const std::string& file) {
  constexpr std::size_t kMaxShown = 10;
  std::string text;
  std::size_t count = 0;
  for (const SweepRecord& r : records) {
    if (r.state != state || ++count > kMaxShown) continue;
    if (state == SweepState::Failed || state == SweepState::Unclear) {
      text += "  " + r.error + '\n';
    } else {
      text += fmt::format("  {}: {}\n", printable(r.path), printable(r.verdict));
      if (!r.repair.empty()) text += fmt::format("    repair: {}\n", printable(r.repair));
    }
  }
  if (count > kMaxShown) text += fmt::format("  and {} more, in {}\n", count - kMaxShown, file);
  if (count == 0) return "";
  const char* heading = state == SweepState::Failed    ? "\nCould not be read:\n"
                        : state == SweepState::Unclear ? "\nUnclear:\n"
                                                       : "\nCollide:\n";
  return heading + text;
}

/// "2 single mesh files and 1 single .npy file"
std::string left_out(std::uint64_t single_meshes, std::uint64_t single_arrays) {
  std::string meshes = counted(single_meshes, "single mesh file");
  if (single_arrays == 0) return meshes;
  const std::string arrays = counted(single_arrays, "single .npy file");
  return single_meshes == 0 ? arrays : meshes + " and " + arrays;
}

/// How many motions are in which state. `before`: how many of them were checked by an earlier sweep.
std::string counts_of(const std::vector<SweepRecord>& records, bool steps_only, std::size_t before) {
  const auto count = [&](SweepState state) {
    return grouped(static_cast<std::uint64_t>(
        std::count_if(records.begin(), records.end(), [&](const auto& r) { return r.state == state; })));
  };
  std::string text = fmt::format("motions                 {}", grouped(records.size()));
  if (before > 0) text += fmt::format("  ({} of them checked before)", grouped(before));
  text += fmt::format("\n  {:<22}{}\n  collide               {}\n  could not be read     {}\n",
                      steps_only ? "no contact in steps" : "clean", count(SweepState::Clean),
                      count(SweepState::Collides), count(SweepState::Failed));
  if (count(SweepState::Unclear) != "0")
    text += fmt::format("  unclear               {}\n", count(SweepState::Unclear));
  if (count(SweepState::Still) != "0")
    text += fmt::format("  a single pose         {}\n", count(SweepState::Still));
  return text;
}

/// What was not looked at.
std::string limits_of(const std::vector<SweepRecord>& records, const SweepScope& scope) {
  std::string text;
  if (scope.single_meshes + scope.single_arrays > 0)
    text += fmt::format("skipped                 {}\n", left_out(scope.single_meshes, scope.single_arrays));
  if (scope.steps_only) text += "first frames            not tested for crossings (--steps-only)\n";
  if (scope.poses) text += "motion between frames   not tested (--static)\n";
  if (!scope.frames.empty())
    text +=
        fmt::format("frames                  only {} of each motion (--frames)\n", printable(scope.frames));
  if (const std::string cut = contacts_cut(records); !cut.empty())
    text += fmt::format("contacts                {}\n", cut);
  for (const auto& pair : scope.ignore) {
    const auto motions = std::count_if(records.begin(), records.end(), [&](const SweepRecord& r) {
      return std::ranges::find(r.ignored, pair) != r.ignored.end();
    });
    text +=
        fmt::format("ignored                 {}, in {}\n",
                    printable(pair[0] == pair[1] ? pair[0] + " with itself" : pair[0] + " and " + pair[1]),
                    counted(static_cast<std::uint64_t>(motions), "motion"));
  }
  return text;
}

std::string unused_models(const std::vector<SweepRecord>& records, const SweepSettings& settings) {
  std::string text;
  for (const auto& model : settings.models) {
    const bool used =
        std::any_of(records.begin(), records.end(), [&](const auto& r) { return r.model == model->name; });
    if (!used)
      text += fmt::format("not used                {}: of none of these meshes\n", cell(model->name));
  }
  return text;
}

std::string lists_of(const std::vector<SweepRecord>& records, const std::string& file) {
  std::string text;
  for (const SweepState state : {SweepState::Collides, SweepState::Failed, SweepState::Unclear})
    text += list_of(records, state, file);
  return text;
}

Result<SweepInput> find_some(const SweepArguments& a) {
  auto input = find_motions(a.motions, a.poses, a.motion.read.mesh_files == MeshFiles::Separate);
  if (input && input->motions.empty()) {
    return fail(ErrorCode::InvalidArgument, a.motions[0],
                fmt::format("holds no motions, and {}", left_out(input->single_meshes, input->single_arrays)),
                "'foldproof sweep --help' lists what is found; --static checks single meshes");
  }
  return input;
}

SweepScope scope_of(const SweepArguments& a, const SweepInput& input, const CheckSettings& settings) {
  return {a.command,
          input.directories,
          a.poses,
          a.steps_only,
          settings.frames.selects_all() ? "" : a.motion.frames,
          settings.ignore,
          input.single_meshes,
          input.single_arrays};
}

/// Checks the remaining motions, one after the other. False: cancelled.
Result<bool> check_remaining(const SweepInput& input, const SweepSettings& settings, SweepFile& file,
                             bool quiet) {
  const std::atomic<bool>& interrupted = watch_for_interrupt();
  SweepBar bar(!quiet, input, file);
  for (const std::size_t motion : file.remaining()) {
    CheckHooks hooks;
    hooks.cancel = &interrupted;
    hooks.progress = [&](const CheckTotals& totals, std::uint64_t expected) {
      bar.show(motion, static_cast<double>(totals.steps) / static_cast<double>(expected));
    };
    const auto line = interrupted ? std::nullopt : sweep_line(input.motions[motion], settings, hooks);
    if (!line) return false;
    FOLDPROOF_TRY(file.add(*line));
    bar.finish(motion);
  }
  return true;
}

int exit_code_of(const std::vector<SweepRecord>& records) {
  return exit_code(std::all_of(records.begin(), records.end(), [](const SweepRecord& r) {
    return r.state == SweepState::Clean || r.state == SweepState::Still;
  }));
}

Result<int> sweep_all(const SweepArguments& a) {
  std::optional<ThreadLimit> limit;
  FOLDPROOF_TRY(limit_threads(a.threads, limit));
  const auto settings = FOLDPROOF_TRY(load_settings(a));
  FOLDPROOF_TRY(require_outside(a.repaired, a.motions));
  auto input = FOLDPROOF_TRY(find_some(a));
  const SweepScope scope = scope_of(a, input, settings.check);
  const std::string hash = settings_hash(settings);
  std::optional<ShardHeader> shard;
  if (!a.shard.empty()) shard = take_shard(input, FOLDPROOF_TRY(parse_shard(a.shard.front())), scope, hash);
  auto file = FOLDPROOF_TRY(SweepFile::open(a.output, input, hash, a.again, shard ? &*shard : nullptr));
  const auto& records = file.records();
  const bool finished = FOLDPROOF_TRY(check_remaining(input, settings, file, a.quiet));
  if (!finished) {
    print_error({"interrupted",
                 fmt::format("{} of {} are done", records.size(), counted(input.motions.size(), "motion")),
                 "the same command continues from there"});
    return kExitInterrupted;
  }
  if (!a.summary.empty()) FOLDPROOF_TRY(write_sweep_page(a.summary, records, scope));
  if (!a.quiet) {
    if (shard) print_output(fmt::format("shard                   {}\n", name_of(shard->shard)));
    print_output(counts_of(records, a.steps_only, input.motions.size() - file.remaining().size()) +
                 limits_of(records, scope) + unused_models(records, settings) + lists_of(records, a.output));
  }
  // A scheduler would repeat what ends with another code.
  return shard ? kExitClean : exit_code_of(records);
}

Result<int> join(const SweepArguments& a) {
  JoinedSweep joined = FOLDPROOF_TRY(join_shards(a.join));
  auto file = FOLDPROOF_TRY(FileWriter::open(a.output));
  FOLDPROOF_TRY(file.write(joined.lines));
  FOLDPROOF_TRY(file.commit());
  const auto& records = joined.records;
  joined.scope.command = a.command;
  if (!a.summary.empty()) FOLDPROOF_TRY(write_sweep_page(a.summary, records, joined.scope));
  if (!a.quiet)
    print_output(counts_of(records, joined.scope.steps_only, 0) + limits_of(records, joined.scope) +
                 lists_of(records, a.output));
  return exit_code_of(records);
}

Result<int> sweep(const SweepArguments& a) {
  FOLDPROOF_TRY(a.files.check());
  if (!a.join.empty()) return join(a);
  if (a.motions.empty())
    return fail(ErrorCode::InvalidArgument, "DIR", "is required", "name a directory, or shards after --join");
  return sweep_all(a);
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
