/// How many steps a search should cover.
#pragma once

#include <optional>

#include "foldproof/base.h"

namespace foldproof::inline internal {

/// How far vertices may deviate from the predicted positions in a step that an earlier search covers, in mean
/// edge lengths. With more slack, charts of thin triangles fail and candidates grow; with less, steps leave
/// it sooner.
inline constexpr double kSlack = 0x1p-10;

/// Learns from the motion so far how many steps are worth looking ahead. A heuristic for speed: it depends on
/// counts only, never on clocks. Lengths are in mean edge lengths.
class LookAheadPolicy {
 public:
  /// The last search covers a step. The step ends `steps` steps after the start of the search, with this
  /// deviation from the positions predicted for then.
  void note_hit(double deviation, double steps);
  /// A step needs a search: returns how many steps it should cover, this one included, at most `max_steps`.
  /// `deviation` and `steps` as in note_hit; the last prediction is extended to this step. No `steps`: the
  /// motion repeats a step, from which nothing can be learned, and the answer is 1.
  Index choose_steps(double deviation, std::optional<double> steps, double max_steps = 32);
  /// The cost of that search, in any unit.
  void note_cost(double cost);

 private:
  double expected_straight_steps(double deviation, double steps);
  void update_curvature(double deviation, double steps);

  double straight_steps_ = 1;                     // since the motion last turned
  double mean_straight_steps_ = 0;                // between two turns; 0 before the first turn
  double curvature_ = 0;                          // deviation of a step from the one before it
  int turns_ = 0;                                 // in a row
  double single_cost_ = 0;                        // of a search for one step; 0: not known
  double multi_cost_ = 0, multi_steps_ = 0;       // of a search for several, and how many
  double step_limit_ = 4;                         // grows while looking ahead pays
  double covered_share_ = 1;                      // of the planned steps, those that a search covered
  double planned_steps_ = 1, covered_steps_ = 1;  // of the last search
};

}  // namespace foldproof::inline internal
