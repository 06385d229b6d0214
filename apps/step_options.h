/// What check, view and report ask for alike: motions, models, and what counts as a collision.
#pragma once

#include "options.h"

namespace foldproof {

struct StepArguments {
  std::vector<std::string> motions, models;
  MotionOptions motion;
  Index substeps = 1;
  double thickness = 0, tolerance = 0;
  std::uint64_t limit = StepSettings().max_listed;
  bool within = false, between = false, no_certificates = false, steps_only = false;
  int threads = 0;
  FileArguments files;
};

/// Adds all of them, in groups, and notes what is read.
void add_step_options(CLI::App& command, StepArguments& arguments);

/// Adds all but the motions, and which objects are checked against which.
void add_setting_options(CLI::App& command, StepArguments& arguments);

/// Everything but the models. Error: a number beyond its range, frames that are no range.
Result<CheckSettings> step_settings(const StepArguments& arguments);

/// A model per motion, none where none was named. One for all serves those whose mesh it is of, and there
/// must be one.
Result<std::vector<std::shared_ptr<const Model>>> load_models(std::span<const std::string> paths,
                                                              Motions motions);

/// Motions, and settings with the models that fit them.
struct OpenedMotions {
  std::vector<std::unique_ptr<Motion>> motions;
  CheckSettings settings;
};
Result<OpenedMotions> open_motions(const StepArguments& arguments);

}  // namespace foldproof
