/// `foldproof check --reduced`: motions described by coordinates of a model's subspace.
#pragma once

#include <string>
#include <vector>

#include "foldproof/check.h"

namespace foldproof {

struct ReducedCheckArguments {
  std::vector<std::string> files;  ///< MODEL COORDINATES, once per object.
  StepSettings step;
  bool steps_only = false;  ///< Do not ask what crosses in the first frame.
  std::string csv;
  bool quiet = false;
};

/// Checks all steps and prints what was found; the exit code.
Result<int> check_reduced(const ReducedCheckArguments& arguments);

}  // namespace foldproof
