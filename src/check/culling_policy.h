/// Whether certificates save more work than they cost.
#pragma once

#include <cstdint>

namespace foldproof::inline internal {

/// Decides for each step whether to use certificates; in dense contact most of them fail. Compares the cost
/// of steps with and without them, and backs off while they save too little. A heuristic for speed: it
/// depends on counts only, never on clocks, and does not affect answers.
class CullingPolicy {
 public:
  /// Work of a step.
  struct Counts {
    std::uint64_t node_tests = 0, leaf_pairs = 0;
    std::uint64_t leaves = 0;           ///< Of all objects.
    double swept_extent_ratio = 1;      ///< See StepMotion; only read when is_unmeasured().
    std::uint64_t chart_triangles = 0;  ///< In the charts that were tested.
    std::uint64_t planes = 0;           ///< Tested planes,
    std::uint64_t failed_planes = 0;    ///< and those of them that do not separate.
  };

  /// Begins a step; returns whether it should use certificates. The first step does not, unless charts
  /// `pay_at_once`: a single step should not pay for what only later steps would gain.
  bool begin_step(bool pay_at_once);
  /// Whether the step after this one will use them.
  bool uses_next() const { return back_off_ == 0; }
  /// Whether no step has been measured yet.
  bool is_unmeasured() const { return cost_with_ == 0 && cost_without_ == 0; }
  void end_step(const Counts& counts);

 private:
  void judge();
  void back_off();

  bool begun_ = false, used_ = false;
  double cost_with_ = 0, cost_without_ = 0;  // of a step; 0: not known
  int used_steps_ = 0;                       // steps with certificates since the last back-off
  int since_without_ = 0;                    // steps since the last one without them
  int back_off_ = 0, next_back_off_ = 0;     // steps without them from now on; length of the next back-off
  double cost_at_back_off_ = 0;              // cost_without_ then
};

}  // namespace foldproof::inline internal
