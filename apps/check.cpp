#include <fmt/chrono.h>
#include <fmt/format.h>

#include <ctime>
#include <limits>

#include "base/try.h"
#include "commands.h"
#include "file_watch.h"
#include "reduced_motions.h"
#include "report/json_reports.h"
#include "run_and_summarize.h"
#include "step_options.h"
#include "terminal.h"

namespace foldproof {
namespace {

constexpr const char* kCheckFooter =
    R"(  pose.obj                        a single frame, checked as a motion of one step without movement
Several motions are several objects. They need equally many frames, or a single one, which stands still.
With --reduced, instead of motions: MODEL COORDINATES for each object, coordinates of the model's subspace by frame:
  p.csv                           a row per frame: one number per mode, then maybe a placement: a quaternion w x y z
                                  and a translation x y z
  p.npz                           the array 'p', frames x modes, maybe 'rotation', frames x 3 x 3, and 'translation'
  tracks.csv  tracks.npz          or tracks of the model's key points, as 'foldproof predict' takes them

The check first finds the triangles that cross in the first frame, exactly, then the collisions of each step. Only both
together prove that nothing intersects at any time. --steps-only skips the first part; then crossings from the start
remain unknown.

Exit code: 0 no collision and no crossing in the first frame, 1 collisions or crossings, 2 error.

Examples:
  foldproof check walk.glb                        every collision between all frames
  foldproof check body.npz shirt.npz --between    only those between the two
  foldproof check walk.glb --frames 10:21         the ten steps from frame 10 to frame 20
  foldproof check walk.glb --substeps 10          each step in ten straight parts
  foldproof check pose.obj                        triangles that cross in one pose
  foldproof check walk.glb --static               triangles that cross in each frame, not between frames
  foldproof check walk.glb --model body.model     faster, with a model from 'foldproof train'
  foldproof check cloth/ --thickness 0.001        closer than 0.001 mesh units counts
  foldproof check --reduced body.model p.csv      a motion given by coordinates of the model's subspace
  foldproof check walk.glb --json a.json --pairs  every pair with its time of impact, to a file
  foldproof check walk.glb --json - | jq .totals  the report on standard output, the summary on standard error
  foldproof check walk.glb --ply worst.ply        the worst step's mesh, colliding faces marked 1, those that cross
                                                  in the first frame 2, both 3
  foldproof check walk.glb --contacts --unit m    what goes through what, in which frames, how deep
  foldproof check walk.glb --watch                checks again each time that the file is exported
  foldproof check walk.glb --vtk walk.pvd         the motion with its collisions, for ParaView)";

struct CheckArguments : StepArguments {
  std::string json, csv, contacts_csv, ply, vtk, mode = "proven";
  std::vector<std::string> parts;
  std::string unit;
  double miss_rate = 0.01;
  bool first = false, all_contacts = false, pairs = false, quiet = false, reduced = false, watch = false;
};

void add_query_options(const Subcommand& check, CheckArguments& a) {
  check.add_flag("--first", a.first, "Find only the earliest collision of each step, and no contacts")
      .group(check.option("--thickness").group())
      .excludes(check.option("--static"));
}

void add_mode_options(const Subcommand& check, CheckArguments& a) {
  const char* group = "Reliability";
  check
      .add_option("--mode", a.mode,
                  "proven: no collision is missing. paper: STATISTICAL, can miss collisions; trusts the "
                  "certificates that key points predict, as the paper does, and counts misses [proven]")
      .one_of({"proven", "paper"})
      .group(group);
  check
      .add_option(
          "--miss-rate", a.miss_rate,
          "With --mode paper: trust predictions only as far as they would have missed at most this share of "
          "what is not proven in the training poses, by cross-validation; new motions miss more [0.01]")
      .type_name("SHARE")
      .between(0.0, 1.0)
      .group(group);
}

void add_report_options(const Subcommand& check, CheckArguments& a) {
  const char* group = "Output";
  using Output = FileArguments::Output;
  const auto add = [&](const char* option, std::string& file, const char* description,
                       Output output = Output::File, std::vector<std::string> endings = {}) {
    a.files.writes(check.add_option(option, file, description), output, std::move(endings))
        .type_name("FILE")
        .group(group);
  };
  add("--json", a.json, "The complete answer, step by step; - is standard output", Output::Text);
  check
      .add_flag("--pairs", a.pairs,
                "List every colliding pair: in the JSON file, or on standard output without --json")
      .group(group);
  add("--csv", a.csv, "A row per collision", Output::Text);
  add("--ply", a.ply,
      "The worst step's mesh, colliding faces marked 1, crossing ones of the first frame 2, both 3; with "
      "%04d in FILE, one per step with collisions",
      Output::Numbered, {".ply"});
  add("--vtk", a.vtk,
      "For ParaView: every step's mesh, colliding faces marked; FILE ends in .pvd, the meshes go into a "
      "directory beside it",
      Output::Collection);
  check
      .add_flag("--contacts", a.all_contacts,
                fmt::format("List all contacts in the summary, not only the {} worst", kFewContacts))
      .group(group);
  add("--contacts-csv", a.contacts_csv, "A row per contact and frame: triangles, curves, areas, depth",
      Output::Text);
  a.files
      .reads(
          check.add_option("--parts", a.parts,
                           "Names of an object's parts, for contacts: a text file with a name per triangle; "
                           "one for each object, in order [those that the motion's file names]"))
      .type_name("FILE")
      .one_value_each_time()
      .group(group);
  check.add_option("--unit", a.unit, "What a mesh unit is, such as cm: named beside lengths [m for glTF]")
      .type_name("NAME")
      .group(group);
  check.add_flag("-q,--quiet", a.quiet, "Print nothing but errors").group(group);
}

void add_check_options(const Subcommand& check, CheckArguments& a) {
  add_step_options(check, a);
  check.option("--clip").description(
      "The animation of a glTF, by its name, or as 'animations[1]'; all: one after the other [the longest]");
  check.add_flag("--reduced", a.reduced, "Coordinates of a model's subspace instead of motions (see below)");
  check.add_flag("--watch", a.watch, "Check again each time that a file has changed, until Ctrl-C");
  add_query_options(check, a);
  add_mode_options(check, a);
  add_report_options(check, a);
  // Contacts join all collisions of a step.
  for (const char* option : {"--contacts", "--contacts-csv", "--parts"})
    check.option("--first").excludes(check.option(option));
}

// A statistical answer goes only into outputs that label it as such.
Result<void> require_mode_fits(const CheckArguments& a) {
  if (a.mode != "paper" && a.miss_rate != CheckArguments().miss_rate)
    return fail(ErrorCode::InvalidArgument, "--miss-rate", "goes with --mode paper",
                "leave it out; without that mode nothing is missed");
  if (a.mode != "paper") return {};
  const auto conflict = [](const char* option) {
    return fail(ErrorCode::InvalidArgument, "--mode paper", fmt::format("does not go with {}", option),
                "omit one of them; --json labels its answer as statistical");
  };
  if (!a.csv.empty()) return conflict("--csv");
  if (a.all_contacts) return conflict("--contacts");
  if (!a.contacts_csv.empty()) return conflict("--contacts-csv");
  if (!a.ply.empty()) return conflict("--ply");
  if (!a.vtk.empty()) return conflict("--vtk");
  if (a.pairs && a.json.empty()) return conflict("--pairs without --json");
  if (a.first) return conflict("--first");
  if (a.no_certificates) return conflict("--no-certificates");
  if (a.models.empty())
    return fail(ErrorCode::InvalidArgument, "--mode paper", "needs a model",
                "give --model one that 'foldproof train' made of at least 3 poses");
  return {};
}

// Refuses options that --reduced does not support.
Result<void> require_reduced_fits(const CheckArguments& a) {
  const bool other = a.poses || a.substeps != 1 || !a.models.empty() || a.mode == "paper" ||
                     !a.ignore.empty() || a.motion.read.weld != Weld::ByFormat ||
                     a.motion.read.mesh_files != MeshFiles::ByName || !a.motion.read.clip.empty() ||
                     a.motion.read.fps != ReadOptions().fps;
  if (!a.reduced || !other) return {};
  return fail(ErrorCode::InvalidArgument, "--reduced",
              "does not go with --static, --substeps, --model, --mode paper, --ignore, --weld, --fps, "
              "--separate, --sequence or --clip",
              "leave them out, or check the motion that 'foldproof predict' writes");
}

Result<CheckSettings> check_settings_of(const CheckArguments& a) {
  auto settings = FOLDPROOF_TRY(step_settings(a));
  FOLDPROOF_TRY(a.files.check());
  FOLDPROOF_TRY(require_mode_fits(a));
  FOLDPROOF_TRY(require_reduced_fits(a));
  if (a.mode == "paper") settings.paper_miss_rate = a.miss_rate;
  settings.step.earliest_only = a.first;
  return settings;
}

using WriterList = std::vector<std::unique_ptr<ReportWriter>>;

constexpr const char* kAllClips = "all";

/// One of the checks that --clip all asks for.
struct OneOfClips {
  const std::string& clip;
  JsonReports* json;  ///< Where its report goes; null: nowhere.
};

Result<void> append(WriterList& writers, Result<std::unique_ptr<ReportWriter>> writer) {
  writers.push_back(FOLDPROOF_TRY(std::move(writer)));
  return {};
}

Result<WriterList> open_writers(const CheckArguments& a, const CheckSettings& settings, Motions motions,
                                const OneOfClips* one) {
  WriterList writers;
  if (one != nullptr && one->json != nullptr) {
    writers.push_back(one->json->add(one->clip, motions, {settings, a.motion.read, a.pairs}));
  } else if (!a.json.empty()) {
    FOLDPROOF_TRY(append(writers, json_report(a.json, motions, {settings, a.motion.read, a.pairs})));
  }
  if (!a.csv.empty()) {
    FOLDPROOF_TRY(append(writers, csv_report(a.csv)));
  }
  if (!a.contacts_csv.empty()) {
    FOLDPROOF_TRY(append(writers, contacts_csv(a.contacts_csv, motions, settings)));
  }
  if (!a.ply.empty()) {
    FOLDPROOF_TRY(append(writers, ply_report(a.ply, motions, settings)));
  }
  if (!a.vtk.empty()) {
    FOLDPROOF_TRY(append(writers, vtk_report(a.vtk, motions, settings)));
  }
  if (a.pairs && a.json.empty() && !a.quiet) writers.push_back(pair_listing(motions));
  return writers;
}

Result<std::vector<ObjectParts>> read_all_parts(std::span<const std::string> paths, Motions motions) {
  std::vector<ObjectParts> parts;
  if (paths.empty()) return parts;
  if (paths.size() != motions.size()) {
    return fail(ErrorCode::InvalidArgument, "--parts",
                fmt::format("is given {} times for {}", paths.size(), counted(motions.size(), "object")),
                "give it once for each object, in order");
  }
  for (std::size_t i = 0; i < paths.size(); ++i)
    parts.push_back(FOLDPROOF_TRY(read_parts(paths[i], motions[i]->topology())));
  return parts;
}

/// `one`: null unless this is one of several clips.
Result<int> check_motions(const CheckArguments& a, const OneOfClips* one = nullptr) {
  auto settings = FOLDPROOF_TRY(check_settings_of(a));
  std::optional<ThreadLimit> limit;
  FOLDPROOF_TRY(limit_threads(a.threads, limit));

  std::vector<std::unique_ptr<Motion>> motions;
  if (a.reduced) {
    motions = FOLDPROOF_TRY(open_reduced(a.motions, a.quiet, settings));
  } else {
    motions = FOLDPROOF_TRY(read_motions(a.motions, a.motion.read, a.quiet));
    settings.models = FOLDPROOF_TRY(load_models(a.models, motions));
  }
  settings.parts = FOLDPROOF_TRY(read_all_parts(a.parts, motions));
  settings.unit = a.unit;
  // From here on an interrupt must not leave incomplete files behind.
  watch_for_interrupt();
  const auto writers = FOLDPROOF_TRY(open_writers(a, settings, motions, one));
  return run_and_summarize(motions, a.motion.read, settings, writers, a.quiet,
                           a.all_contacts ? std::numeric_limits<std::size_t>::max() : kFewContacts);
}

/// The clips of the only file that has some.
Result<std::vector<std::string>> clips_of(const CheckArguments& a) {
  const auto refuse = [](std::string problem, std::string remedy) {
    return fail(ErrorCode::InvalidArgument, "--clip all", std::move(problem), std::move(remedy));
  };
  for (const auto& [option, file] : std::initializer_list<std::pair<const char*, const std::string&>>{
           {"--csv", a.csv}, {"--contacts-csv", a.contacts_csv}, {"--ply", a.ply}, {"--vtk", a.vtk}}) {
    if (!file.empty())
      return refuse(fmt::format("does not go with {}, which is about one check", option),
                    "name a clip; --json lists all");
  }
  ReadOptions read = a.motion.read;
  read.clip.clear();
  const auto motions = FOLDPROOF_TRY(read_motions(a.motions, read, a.quiet));
  std::vector<std::string> clips;
  for (const auto& motion : motions) {
    if (!clips.empty() && !motion->info().clips.empty())
      return refuse("is about one file, but several have animations",
                    "check them one at a time, or name a clip");
    if (clips.empty()) clips = motion->info().clips;
  }
  if (clips.empty())
    return refuse("is given, but no file has animations", "leave it out; only .gltf and .glb have them");
  return clips;
}

/// Checks one clip after the other. The exit code is the worst.
Result<int> check_all_clips(CheckArguments a) {
  FOLDPROOF_TRY(check_settings_of(a));
  const auto clips = FOLDPROOF_TRY(clips_of(a));
  std::optional<JsonReports> json;
  if (!a.json.empty()) json = FOLDPROOF_TRY(JsonReports::open(a.json));
  int worst = kExitClean;
  for (const std::string& clip : clips) {
    a.motion.read.clip = clip;
    const OneOfClips one{clip, json ? &*json : nullptr};
    worst = std::max(worst, FOLDPROOF_TRY(check_motions(a, &one)));
    if (worst == kExitInterrupted) return worst;
  }
  if (json) FOLDPROOF_TRY(json->finish(worst == kExitClean));
  return worst;
}

Result<int> check_once(const CheckArguments& a) {
  return a.motion.read.clip == kAllClips ? check_all_clips(a) : check_motions(a);
}

Result<int> check_and_watch(const CheckArguments& a) {
  FOLDPROOF_TRY(check_settings_of(a));  // what watching cannot cure
  const std::atomic<bool>& interrupted = watch_for_interrupt();
  FileWatch files(a.files, interrupted);
  while (true) {
    files.settle();
    const auto result = check_once(a);
    if (interrupted) return kExitInterrupted;
    if (!result) {
      if (files.is_changing()) continue;  // it was half written
      print_error(result.error());
    }
    FOLDPROOF_TRY(flush_output());
    if (!a.quiet) print_notice("\nWaiting for a file to change. Ctrl-C ends this.\n");
    const std::string changed = files.wait();
    if (interrupted) return kExitInterrupted;
    if (!a.quiet)
      print_notice(fmt::format("{:%H:%M:%S} {} has changed.\n", fmt::localtime(std::time(nullptr)), changed));
  }
}

}  // namespace

Command add_check(CommandLine& program) {
  const Subcommand command = program.add_subcommand("check", "Find every collision of one or more motions");
  command.footer(std::string(kMotionHelp) + kCheckFooter);
  const auto arguments = std::make_shared<CheckArguments>();
  add_check_options(command, *arguments);
  return [arguments] { return arguments->watch ? check_and_watch(*arguments) : check_once(*arguments); };
}

}  // namespace foldproof
