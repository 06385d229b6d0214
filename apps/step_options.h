/// Options of check, view, report and sweep: motions, models, and what counts as a collision.
#pragma once

#include "options.h"

namespace foldproof {

struct StepArguments {
  StepArguments() { motion.read.still = true; }

  std::vector<std::string> motions, models;
  std::vector<std::pair<std::string, std::string>> ignore;
  MotionOptions motion;
  Index substeps = 1;
  double thickness = 0, tolerance = 0;
  std::uint64_t limit = StepSettings().max_listed;
  bool within = false, between = false, no_certificates = false, steps_only = false, poses = false;
  bool still_pairs = false;
  int threads = 0;
  FileArguments files;
};

/// Adds all options, in groups, and registers the files that are read.
void add_step_options(const Subcommand& command, StepArguments& arguments);

/// Adds all options except MOTION, --within, --between and --limit.
void add_setting_options(const Subcommand& command, StepArguments& arguments);

/// Converts all options except the models. Error: a number out of range, an invalid range of frames.
Result<CheckSettings> step_settings(const StepArguments& arguments);

/// Motions, and settings with the models that fit them.
struct OpenedMotions {
  std::vector<std::unique_ptr<Motion>> motions;
  CheckSettings settings;
};

/// By read_motions.
Result<OpenedMotions> open_motions(const StepArguments& arguments, bool quiet = false);

}  // namespace foldproof
