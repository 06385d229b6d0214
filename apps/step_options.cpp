#include "step_options.h"

#include <fmt/format.h>

#include "base/try.h"
#include "commands.h"
#include "terminal.h"

namespace foldproof {
namespace {

constexpr const char* kCollisionGroup = "What is a collision";

void check_poses(StepArguments& a) {
  a.poses = true;
  // A directory holds poses, which may be far from each other.
  if (a.motion.read.mesh_files == MeshFiles::ByName) a.motion.read.mesh_files = MeshFiles::Poses;
}

}  // namespace

void add_step_options(const Subcommand& command, StepArguments& a) {
  a.files.reads(command.add_option("MOTION", a.motions, "What to check (see below)"))
      .type_name("")
      .required();

  const char* group = kCollisionGroup;
  const Option within =
      command.add_flag("--within", a.within, "Only collisions of each object with itself").group(group);
  command.add_flag("--between", a.between, "Only collisions between objects").group(group).excludes(within);
  add_setting_options(command, a);
  command
      .add_flag("--still-pairs", a.still_pairs,
                "Count what objects of a single frame, which stand still beside those that move, cross among "
                "themselves, and test them in every step")
      .group(group);
  command
      .add_option(
          "--limit", a.limit,
          fmt::format("List and mark at most N pairs of each kind in a step, those with the smallest ids; "
                      "all are counted [{}]",
                      a.limit))
      .type_name("N")
      .group(group);
}

void add_setting_options(const Subcommand& command, StepArguments& a) {
  const char* group = kCollisionGroup;
  command
      .add_option("--thickness", a.thickness,
                  "Closer than or equal to this is a collision, in mesh units [0]")
      .type_name("D")
      .group(group);
  command
      .add_option(
          "--tolerance", a.tolerance,
          "How far beyond the thickness a reported pair may be, in mesh units [2^-30 of the scene's size]")
      .type_name("D")
      .group(group);

  command
      .add_option(
          "--ignore", a.ignore,
          "Leave out pairs of two objects or parts, by name; of one with itself: --ignore A A. Several "
          "times for several pairs")
      .type_name("A B")
      .one_value_each_time()
      .group(group);
  command
      .add_flag("--steps-only", a.steps_only,
                "Find only contacts between frames: do not test for crossings in the first frame")
      .group(group);
  const Option poses = command
                           .add_flag(
                               "--static", [&a] { check_poses(a); },
                               "Find triangles that cross in each frame instead, exactly")
                           .group(group);

  add_motion_options(command, a.motion);
  command
      .add_option("--substeps", a.substeps,
                  "Cut each step into N linear parts, through poses rounded to doubles [1]")
      .type_name("N")
      .group(kMotionGroup);
  for (const char* option : {"--thickness", "--tolerance", "--substeps", "--steps-only"})
    command.option(option).excludes(poses);

  const char* speed = "Speed (these do not change the answer)";
  const Option model =
      a.files
          .reads(command.add_option("--model", a.models,
                                    "A model from 'foldproof train': one for all objects of its mesh, or one "
                                    "for each object, in order"))
          .type_name("FILE")
          .one_value_each_time()
          .group(speed);
  command.add_flag("--no-certificates", a.no_certificates, "Test everything, even what can be proven free")
      .group(speed)
      .excludes(model);
  add_threads_option(command, a.threads, "At most N threads [all cores]");
  command.option("--threads").group(speed);
}

Result<CheckSettings> step_settings(const StepArguments& a) {
  FOLDPROOF_TRY(require_number("--thickness", a.thickness, true));
  FOLDPROOF_TRY(require_number("--tolerance", a.tolerance, true));
  const auto frames = FOLDPROOF_TRY(frame_range_of(a.motion));
  if (a.substeps < 1)
    return fail(ErrorCode::InvalidArgument, "--substeps", "must not be 0", "give 1 or more");
  CheckSettings settings;
  settings.poses = a.poses;
  settings.substeps = a.substeps;
  settings.steps_only = a.steps_only;
  settings.still_pairs = a.still_pairs;
  for (const auto& [first, second] : a.ignore) settings.ignore.push_back({first, second});
  settings.step = {.within = !a.between,
                   .between = !a.within,
                   .thickness = a.thickness,
                   .tolerance = a.tolerance,
                   .max_listed = a.limit,
                   .certificates = !a.no_certificates};
  settings.frames = frames;
  return settings;
}

Result<OpenedMotions> open_motions(const StepArguments& a, bool quiet) {
  auto settings = FOLDPROOF_TRY(step_settings(a));
  auto motions = FOLDPROOF_TRY(read_motions(a.motions, a.motion.read, quiet));
  settings.models = FOLDPROOF_TRY(load_models(a.models, motions));
  return OpenedMotions{std::move(motions), std::move(settings)};
}

}  // namespace foldproof
