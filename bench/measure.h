/// Runs foldproof and its peers on the same steps of a scene, one after the other within each step.
#pragma once

#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "competitor.h"
#include "foldproof/check.h"
#include "scene.h"

namespace foldproof::bench {

/// Foldproof as it is used: with certificates that it finds on the way, with those of a model that was
/// trained on every tenth frame of the motion, or with none.
enum class Way { Certificates, Trained, Plain };
inline constexpr std::array<Way, 3> kWays = {Way::Certificates, Way::Trained, Way::Plain};

struct Plan {
  /// A simulation runs for thousands of steps: what is measured is a checker that is used to the motion.
  Sampling sampling{.steps = 40, .all = false, .warm_up = 40};
  std::vector<StepSize> sizes{kStepSizes.begin(),
                              kStepSizes.end()};  ///< Smooth ones: motions of the data only.
  std::vector<PeerEntry> peers;
  Index peer_steps = 8;      ///< Peers run on this many of the steps, evenly spread.
  bool one_variant = false;  ///< Of each family's variants only the one that is fastest on the first step.
  bool trained = true;       ///< Foldproof also with a trained model.
  bool plain = true;         ///< Foldproof also without certificates.
  Index growth_largest = kNoIndex;  ///< Triangles that the growth scenes have at most.
  HierarchySettings hierarchy;
  int rounds = 1;       ///< How often all steps are run. A step's time is its fastest round.
  bool verify = false;  ///< Compare the candidates of all peers with each other and with foldproof's answer.
  bool memory = true;   ///< Measure foldproof's peak memory.
  bool peer_memory = false;
  bool processor_time =
      false;        ///< Not wall time: what a busy machine gave this process, all threads together.
  int threads = 1;  ///< For foldproof; peers always have one.
};

struct StepRecord {
  StepChoice step;
  double floor_milliseconds = 0;
  struct OfFoldproof {
    double milliseconds = NAN;  ///< Of the whole call, by the bench's own clock. NAN: did not run.
    Work work;
    StageTimes stages;
    std::uint64_t allocations = 0;  ///< Calls of operator new.
    Index searched = 1;             ///< StepResult::search_steps.
  };
  std::array<OfFoldproof, kWays.size()> ways;
  const OfFoldproof& of(Way way) const { return ways[static_cast<std::size_t>(way)]; }
  std::uint64_t collisions_vf = 0, collisions_ee = 0;
  struct OfPeer {
    double milliseconds = NAN;  ///< NAN: did not run.
    std::uint64_t candidates_vf = 0, candidates_ee = 0;
  };
  std::vector<OfPeer> peers;  ///< In the plan's order; empty when none ran on this step.
};

struct SceneRecord {
  std::string name;
  SceneKind kind = SceneKind::Motion;
  StepSize size = StepSize::Full;
  Index vertices = 0, edges = 0, triangles = 0, frames = 0;
  double build_milliseconds = 0;    ///< Foldproof's hierarchy, once per topology.
  double train_seconds = 0;         ///< Of the model, once per motion.
  Index references = 0;             ///< Its poses; 0 when nothing was trained.
  std::vector<StepRecord> warm_up;  ///< Of new checkers, right before those measured; at least one.
  std::vector<StepRecord> steps;
  std::map<std::string, double> peak_bytes;  ///< Foldproof ("foldproof") and peers by name.
};

/// Records of one scene, one per step size.
Result<std::vector<SceneRecord>> measure(const SceneInfo& scene, const Plan& plan);

/// A hierarchy for a motion, from its first frame.
Result<std::shared_ptr<const Hierarchy>> build_hierarchy(Motion& motion, const HierarchySettings& settings);

/// Milliseconds by the wall, or what this process got of its processors.
double now_milliseconds(bool processor_time);

}  // namespace foldproof::bench
