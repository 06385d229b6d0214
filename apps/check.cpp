#include <fmt/format.h>
#include <tbb/global_control.h>

#include <atomic>
#include <cmath>
#include <csignal>
#include <set>

#include "commands.h"
#include "foldproof/report.h"
#include "terminal.h"

namespace foldproof {
namespace {

constexpr const char* kFooter = R"(A MOTION is one topology and its frames:
  walk.glb  walk.gltf  walk.npz   an animation; NPZ holds 'faces' and 'vertices' (frames x n x 3)
  walk.obj walk.pc2               a mesh (OBJ, OFF, PLY) followed by its point cache (.pc2, .mdd)
  frames/  'frames/*.ply'         a directory or a quoted glob of meshes, a frame each, in natural order
  pose.obj                        a single frame, for --static
Several motions are several objects, and need equally many frames.

Exit code: 0 no collision, 1 collisions, 2 error.

Examples:
  foldproof check walk.glb                        every collision between all frames
  foldproof check body.npz shirt.npz --between    only those between the two
  foldproof check walk.glb --frames 10:21         the ten steps from frame 10 to frame 20
  foldproof check walk.glb --substeps 10          each step in ten straight parts
  foldproof check pose.obj --static               triangles that cross in one pose
  foldproof check cloth/ --thickness 0.001        closer than 0.001 mesh units counts
  foldproof check walk.glb --json a.json --pairs  every pair with its time of impact, to a file
  foldproof check walk.glb --ply worst.ply        the worst step's mesh, colliding faces marked 1)";

struct CheckArguments {
  std::vector<std::string> motions;
  std::string frames, json, csv, ply;
  Index substeps = 1;
  int threads = 0;
  double thickness = 0, tolerance = 0;
  bool poses = false, within = false, between = false, first = false, pairs = false, quiet = false;
  ReadOptions read;
};

std::atomic<bool> interrupted = false;
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler sets it");

extern "C" void interrupt(int) { interrupted = true; }

void add_query_options(CLI::App& check, CheckArguments& a) {
  const char* group = "What counts";
  auto* poses =
      check.add_flag("--static", a.poses, "Crossing triangles of each frame instead, decided exactly")
          ->group(group);
  auto* within =
      check.add_flag("--within", a.within, "Only collisions of each object with itself")->group(group);
  check.add_flag("--between", a.between, "Only collisions between objects")->group(group)->excludes(within);
  check
      .add_option("--thickness", a.thickness,
                  "Closer than or equal to this is a collision, in mesh units [0]")
      ->type_name("D")
      ->group(group)
      ->excludes(poses);
  check
      .add_option(
          "--tolerance", a.tolerance,
          "How far beyond the thickness a reported pair may be, in mesh units [2^-30 of the scene's size]")
      ->type_name("D")
      ->group(group)
      ->excludes(poses);
  check.add_flag("--first", a.first, "Of each step only the earliest collision")
      ->group(group)
      ->excludes(poses);
}

void add_motion_options(CLI::App& check, CheckArguments& a) {
  const char* group = "Which part of the motion";
  check
      .add_option("--frames", a.frames,
                  "Frames A up to, not including, B, every STEP-th; negative ones count from the end")
      ->type_name("A:B[:STEP]")
      ->group(group);
  check.add_option("--substeps", a.substeps, "Cut each step into N linear parts [1]")
      ->type_name("N")
      ->group(group)
      ->excludes(check.get_option("--static"));
  check.add_option("--fps", a.read.fps, "Sampling rate for animated glTF, frames per second [24]")
      ->type_name("RATE")
      ->group(group);
  check
      .add_flag("--weld", a.read.weld,
                "Merge vertices that coincide in the first frame (changes vertex numbers)")
      ->group(group);
}

void add_report_options(CLI::App& check, CheckArguments& a) {
  const char* group = "Where the answer goes";
  check.add_option("--json", a.json, "The whole answer, step by step")->type_name("FILE")->group(group);
  check.add_flag("--pairs", a.pairs, "List every colliding pair: in the JSON file, or here without --json")
      ->group(group);
  check.add_option("--csv", a.csv, "A row per collision")->type_name("FILE")->group(group);
  check
      .add_option(
          "--ply", a.ply,
          "The worst step's mesh, colliding faces marked 1; with %04d in FILE one per step with collisions")
      ->type_name("FILE")
      ->group(group);
  check.add_flag("--quiet", a.quiet, "Print nothing but errors")->group(group);
}

void add_options(CLI::App& check, CheckArguments& a) {
  check.add_option("MOTION", a.motions, "What to check (see below)")->type_name("")->required();
  add_query_options(check, a);
  add_motion_options(check, a);
  add_report_options(check, a);
  check
      .add_option("--threads", a.threads,
                  "At most N threads; the answer is the same for any number [all cores]")
      ->type_name("N");
}

Result<void> require_number(const char* option, double value, bool zero_allowed) {
  if (std::isfinite(value) && (value > 0 || (zero_allowed && value == 0))) return {};
  return fail(
      option,
      fmt::format("{} is not a {} number", value, zero_allowed ? "finite, not negative" : "finite, positive"),
      "give another");
}

Result<void> require_distinct_files(const CheckArguments& a) {
  std::set<std::string> files;
  for (const std::string* path : {&a.json, &a.csv, &a.ply}) {
    if (!path->empty() && !files.insert(*path).second) {
      return fail(*path, "is named for two outputs", "give each its own file");
    }
  }
  return {};
}

Result<CheckSettings> settings_of(const CheckArguments& a) {
  if (const auto ok = require_number("--thickness", a.thickness, true); !ok)
    return tl::unexpected(ok.error());
  if (const auto ok = require_number("--tolerance", a.tolerance, true); !ok)
    return tl::unexpected(ok.error());
  if (const auto ok = require_number("--fps", a.read.fps, false); !ok) return tl::unexpected(ok.error());
  if (a.substeps < 1) return fail("--substeps", "0 parts are none", "give 1 or more");
  if (a.threads < 0 || a.threads > 4096)
    return fail("--threads", fmt::format("{} is not between 1 and 4096", a.threads),
                "give another, or leave it out to use all cores");
  if (const auto ok = require_distinct_files(a); !ok) return tl::unexpected(ok.error());

  CheckSettings settings;
  settings.poses = a.poses;
  settings.substeps = a.substeps;
  settings.step = {.within = !a.between,
                   .between = !a.within,
                   .thickness = a.thickness,
                   .tolerance = a.tolerance,
                   .earliest_only = a.first};
  if (!a.frames.empty()) {
    const auto range = parse_frame_range(a.frames);
    if (!range) return tl::unexpected(range.error());
    settings.frames = *range;
  }
  return settings;
}

using WriterList = std::vector<std::unique_ptr<ReportWriter>>;

Result<void> append(WriterList& writers, Result<std::unique_ptr<ReportWriter>> writer) {
  if (!writer) return tl::unexpected(writer.error());
  writers.push_back(std::move(*writer));
  return {};
}

Result<WriterList> open_writers(const CheckArguments& a, const CheckSettings& settings, Motions motions) {
  WriterList writers;
  if (!a.json.empty()) {
    const auto ok = append(writers, json_report(a.json, motions, {settings, a.read, a.pairs}));
    if (!ok) return tl::unexpected(ok.error());
  }
  if (!a.csv.empty()) {
    if (const auto ok = append(writers, csv_report(a.csv)); !ok) return tl::unexpected(ok.error());
  }
  if (!a.ply.empty()) {
    if (const auto ok = append(writers, ply_report(a.ply, motions, settings)); !ok)
      return tl::unexpected(ok.error());
  }
  if (a.pairs && a.json.empty() && !a.quiet) writers.push_back(pair_listing(motions));
  return writers;
}

Result<int> check(const CheckArguments& a) {
  const auto settings = settings_of(a);
  if (!settings) return tl::unexpected(settings.error());
  std::optional<tbb::global_control> limit;
  if (a.threads > 0)
    limit.emplace(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(a.threads));

  const auto motions = open_motions(a.motions, a.read);
  if (!motions) return tl::unexpected(motions.error());
  // From here on files are open that must not stay behind half written.
  std::signal(SIGINT, interrupt);
  std::signal(SIGTERM, interrupt);
  const auto writers = open_writers(a, *settings, *motions);
  if (!writers) return tl::unexpected(writers.error());

  ProgressBar bar(!a.quiet);
  CheckHooks hooks;
  hooks.progress = [&](const CheckTotals& totals, std::uint64_t expected) { bar.show(totals, expected); };
  hooks.cancel = &interrupted;
  const auto totals = run_check(*motions, *settings, *writers, hooks);
  bar.clear();
  if (!totals) return tl::unexpected(totals.error());
  if (totals->cancelled) {
    print_error({"interrupted", fmt::format("after {} steps", totals->steps), "no report was written"});
    return kExitInterrupted;
  }
  if (!a.quiet) print_output(summary(*motions, *settings, *totals));
  return totals->clean() ? kExitClean : kExitCollisions;
}

}  // namespace

Command add_check(CLI::App& program) {
  CLI::App* command = program.add_subcommand("check", "Find every collision of one or more motions");
  command->footer(kFooter);
  const auto arguments = std::make_shared<CheckArguments>();
  add_options(*command, *arguments);
  return [arguments] { return check(*arguments); };
}

}  // namespace foldproof
