/// What a barrier solver asks most: the candidates of poses that follow each other.
#pragma once

#include "competitor.h"
#include "scene.h"
#include "table.h"

namespace foldproof::bench {

struct CandidatePlan {
  std::vector<PeerEntry> peers;  ///< Of each family the fastest variant counts.
  Index poses = 40;              ///< That follow each other, after `warm_up`.
  Index warm_up = 10;
  Index peer_poses = 4;
  bool processor_time = false;
};

/// Rows: scene, what one pose to the next is (a fortieth of a frame on a smooth curve, as a simulation's
/// step; a four-thousandth, as a Newton iteration that hardly moves), inflation in mean edges; and the
/// geometric mean. Error: a scene cannot be read; more than the pairs whose boxes are near are listed, or
/// fewer.
Result<Table> measure_candidates(const std::vector<SceneInfo>& scenes, const CandidatePlan& plan);

}  // namespace foldproof::bench
