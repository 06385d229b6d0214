/// `foldproof check --reduced`: motions described by coordinates of a model's subspace.
#pragma once

#include "report/report.h"

namespace foldproof {

/// Opens the motions that `files` describe, MODEL COORDINATES for each object, and sets `reduced` and
/// `models` of the settings. Proves the balls of all models, with a progress bar unless `quiet`; Ctrl-C is an
/// error.
Result<std::vector<std::unique_ptr<Motion>>> open_reduced(const std::vector<std::string>& files, bool quiet,
                                                          CheckSettings& settings);

}  // namespace foldproof
