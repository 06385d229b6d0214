// Prints: from 4 of 123 vertices, the others follow to 0.00
// Reconstructs a pose of a bending strip from a few of its vertices.
#include "foldproof/keypoints.h"

#include <cstdio>

#include "strip.h"

int main() {
  using namespace foldproof;
  const std::size_t size = bent_strip(0).size();
  Eigen::MatrixXd poses(size, 8);  // a column per pose
  for (int k = 0; k < 8; ++k) {
    const std::vector<double> x = bent_strip(0.1 * k);
    poses.col(k) = Eigen::Map<const Eigen::VectorXd>(x.data(), x.size());
  }
  const auto subspace = pca(poses);
  if (!subspace) return std::puts(subspace.error().line().c_str()), 1;
  const std::vector<Index> vertices{0, 39, 78, 117};
  const KeyPointMap map(*subspace, vertices);
  const Eigen::VectorXd x = poses.col(5);
  const auto reconstructed = subspace->reconstruct(map.coordinates(map.gather(x)));
  std::printf("from %zu of %zu vertices, the others follow to %.2f\n", vertices.size(), size / 3,
              vertex_distance(x, reconstructed).worst);
}
