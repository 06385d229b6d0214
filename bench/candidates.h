/// What a barrier solver asks most: the candidates of poses that follow each other.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "competitor.h"
#include "scene.h"

namespace foldproof::bench {

struct CandidatePlan {
  std::vector<PeerEntry> peers;
  Index poses = 40;  ///< That follow each other, after `warm_up`.
  Index warm_up = 10;
  Index peer_poses = 4;
  bool processor_time = false;
};

/// Rows: scene, what one pose to the next is (a fortieth of a frame on a smooth curve, as a simulation's
/// step; a four-thousandth, as a Newton iteration that hardly moves), inflation in mean edges. Error: a scene
/// cannot be read; more than the pairs whose boxes are near are listed, or fewer.
Result<nlohmann::json> measure_candidates(const std::vector<SceneInfo>& scenes, const CandidatePlan& plan);

}  // namespace foldproof::bench
