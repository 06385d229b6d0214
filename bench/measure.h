/// Runs foldproof and its peers on the same steps of a scene, one after the other within each step.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "competitor.h"
#include "foldproof/query.h"
#include "scene.h"

namespace foldproof::bench {

struct Plan {
  Sampling sampling;
  std::vector<StepSize> sizes = {StepSize::Full, StepSize::Tenth};
  std::vector<PeerEntry> peers;
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
  double milliseconds = 0;  ///< Of the whole call, by the bench's own clock.
  Work work;
  StageTimes stages;
  std::uint64_t collisions_vf = 0, collisions_ee = 0;
  struct OfPeer {
    double milliseconds = 0;
    std::uint64_t candidates_vf = 0, candidates_ee = 0;
  };
  std::vector<OfPeer> peers;  ///< In the plan's order.
};

struct SceneRecord {
  std::string name;
  SceneKind kind = SceneKind::Motion;
  StepSize size = StepSize::Full;
  Index vertices = 0, edges = 0, triangles = 0, frames = 0;
  double build_milliseconds = 0;  ///< Foldproof's hierarchy, once per topology.
  std::vector<StepRecord> steps;
  std::map<std::string, double> peak_bytes;  ///< Foldproof ("foldproof") and peers by name.
};

/// Records of one scene, one per step size.
Result<std::vector<SceneRecord>> measure(const SceneInfo& scene, const Plan& plan);

/// Foldproof's side of a scene: its hierarchy and its checker.
class FoldproofRunner {
 public:
  Result<void> build(const Topology& topology, std::span<const double> positions,
                     const HierarchySettings& settings);
  Result<void> step(std::span<const double> x0, std::span<const double> x1);
  const StepResult& result() const { return result_; }

 private:
  std::optional<StepChecker> checker_;
  StepResult result_;
};

}  // namespace foldproof::bench
