/// Whether certificates save more work than they cost.
#pragma once

#include <cstdint>

namespace foldproof {

/// Decides from step to step whether to use certificates; in dense contact most of them fail. It compares the
/// work of steps with and without them and backs off while they save too little. A heuristic for speed: it
/// depends on counts only, never on clocks, and no answer depends on it.
class CullingGain {
 public:
  /// What a step did.
  struct Counts {
    std::uint64_t node_tests = 0, leaf_pairs = 0;
    std::uint64_t leaves = 0;           ///< Of all objects.
    double sweep_growth = 1;            ///< StepMotion::sweep_growth; looked at where knows_nothing().
    std::uint64_t chart_triangles = 0;  ///< In charts that were tested.
    std::uint64_t planes = 0,
                  failed_planes = 0;  ///< Planes that were tested, and those that do not separate.
  };

  /// Whether the step that begins should use certificates. A first step does not, unless charts are there
  /// already (`trained`): a single step should not pay for what later steps would gain.
  bool begin(bool trained);
  /// Whether the step after this one will use them.
  bool used_next() const { return back_off_ == 0; }
  /// Whether no step has been measured yet.
  bool knows_nothing() const { return with_ == 0 && without_ == 0; }
  /// What the step did.
  void took(const Counts& counts);

 private:
  void judge();
  void back_off();

  bool begun_ = false, used_ = false;
  double with_ = 0, without_ = 0;         // effort of a step; 0: not known
  int used_steps_ = 0;                    // steps that used certificates since the last back-off
  int since_without_ = 0;                 // steps since one did not
  int back_off_ = 0, next_back_off_ = 0;  // steps that will not use them; how many the next time
  double effort_at_back_off_ = 0;         // of a step without certificates
};

}  // namespace foldproof
