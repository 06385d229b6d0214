#include "step_options.h"

#include <fmt/format.h>

#include <algorithm>

#include "commands.h"
#include "terminal.h"

namespace foldproof {
namespace {

constexpr const char* kCountsGroup = "What counts";

}  // namespace

void add_step_options(CLI::App& command, StepArguments& a) {
  a.files.reads(command.add_option("MOTION", a.motions, "What to check (see below)"))
      ->type_name("")
      ->required();

  const char* counts = kCountsGroup;
  auto* within =
      command.add_flag("--within", a.within, "Only collisions of each object with itself")->group(counts);
  command.add_flag("--between", a.between, "Only collisions between objects")
      ->group(counts)
      ->excludes(within);
  add_setting_options(command, a);
  command
      .add_option(
          "--limit", a.limit,
          fmt::format("List and mark at most N pairs of each kind in a step, those with the smallest ids; "
                      "all are counted [{}]",
                      a.limit))
      ->type_name("N")
      ->group(counts);
}

void add_setting_options(CLI::App& command, StepArguments& a) {
  const char* counts = kCountsGroup;
  command
      .add_option("--thickness", a.thickness,
                  "Closer than or equal to this is a collision, in mesh units [0]")
      ->type_name("D")
      ->group(counts);
  command
      .add_option(
          "--tolerance", a.tolerance,
          "How far beyond the thickness a reported pair may be, in mesh units [2^-30 of the scene's size]")
      ->type_name("D")
      ->group(counts);

  command
      .add_flag("--steps-only", a.steps_only,
                "Only what comes into contact between frames: do not ask what crosses in the first frame")
      ->group(counts);

  add_motion_options(command, a.motion);
  command.add_option("--substeps", a.substeps, "Cut each step into N linear parts [1]")
      ->type_name("N")
      ->group(kMotionGroup);

  const char* speed = "Speed (the answer is the same with any of these)";
  auto* model =
      a.files
          .reads(command.add_option("--model", a.models,
                                    "What 'foldproof train' found out: once for all objects of that mesh, or "
                                    "once for each object in order"))
          ->type_name("FILE")
          ->allow_extra_args(false)
          ->group(speed);
  command.add_flag("--no-certificates", a.no_certificates, "Test everything, also what can be proven free")
      ->group(speed)
      ->excludes(model);
  add_threads_option(command, a.threads, "At most N threads [all cores]");
  command.get_option("--threads")->group(speed);
}

Result<CheckSettings> step_settings(const StepArguments& a) {
  if (const auto ok = require_number("--thickness", a.thickness, true); !ok)
    return tl::unexpected(ok.error());
  if (const auto ok = require_number("--tolerance", a.tolerance, true); !ok)
    return tl::unexpected(ok.error());
  const auto frames = frame_range_of(a.motion);
  if (!frames) return tl::unexpected(frames.error());
  if (a.substeps < 1) return fail("--substeps", "0 parts are none", "give 1 or more");
  CheckSettings settings;
  settings.substeps = a.substeps;
  settings.steps_only = a.steps_only;
  settings.step = {.within = !a.between,
                   .between = !a.within,
                   .thickness = a.thickness,
                   .tolerance = a.tolerance,
                   .max_listed = a.limit,
                   .certificates = !a.no_certificates};
  settings.frames = *frames;
  return settings;
}

Result<std::vector<std::shared_ptr<const Model>>> load_models(std::span<const std::string> paths,
                                                              Motions motions) {
  std::vector<std::shared_ptr<const Model>> models;
  for (const std::string& path : paths) {
    auto model = load_model(path);
    if (!model) return tl::unexpected(model.error());
    models.push_back(std::make_shared<const Model>(std::move(*model)));
  }
  if (models.size() != 1 || motions.size() < 2) return models;
  const auto model = models[0];
  const auto fits = [&](const auto& motion) { return model->hierarchy()->topology() == motion->topology(); };
  if (std::none_of(motions.begin(), motions.end(), fits)) {
    return fail(paths[0], "is a model of none of these meshes", "train a model on one of them");
  }
  models.clear();
  for (const auto& motion : motions) models.push_back(fits(motion) ? model : nullptr);
  return models;
}

Result<OpenedMotions> open_motions(const StepArguments& a) {
  auto settings = step_settings(a);
  if (!settings) return tl::unexpected(settings.error());
  auto motions = open_motions(a.motions, a.motion.read);
  if (!motions) return tl::unexpected(motions.error());
  auto models = load_models(a.models, *motions);
  if (!models) return tl::unexpected(models.error());
  settings->models = std::move(*models);
  return OpenedMotions{std::move(*motions), std::move(*settings)};
}

}  // namespace foldproof
