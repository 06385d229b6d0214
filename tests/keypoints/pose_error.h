#pragma once

#include "foldproof/keypoints.h"

namespace foldproof::testing {

inline PoseError pose_error(const Pca& subspace, const KeyPointMap& map, const VectorView& x) {
  const Eigen::VectorXd best = subspace.reconstruct(subspace.project(x));
  const Eigen::VectorXd from_key_points = subspace.reconstruct(map.coordinates(map.gather(x)));
  return {vertex_distance(x, best), vertex_distance(best, from_key_points),
          vertex_distance(x, from_key_points)};
}

}  // namespace foldproof::testing
