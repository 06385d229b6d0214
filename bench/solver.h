/// What implicit solvers ask of a single pose or step: long steps, bounds, and pairs within a distance.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "foldproof/base.h"

namespace foldproof::bench {

struct SolverPlan {
  Index side = 120;  ///< Cells along a side of each of two sheets; 4 * side^2 triangles.
  bool processor_time = false;
};

/// Two wavy sheets, one above the other; a row per question, its fastest time of three. *impact*: the upper
/// one falls far through the lower, beside the step that ends at the contact; *slide*: they pass each other;
/// *far*: everything moves far. *distance*: minimum_distance with a bound. *close*: close_pairs beside
/// candidates, from none to all of which are close. Error: a question has no answer.
Result<nlohmann::json> measure_solver(const SolverPlan& plan);

}  // namespace foldproof::bench
