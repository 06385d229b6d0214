#include "model/learned_file.h"

namespace foldproof::internal {
namespace {

using flatbuffers::FlatBufferBuilder;
using flatbuffers::Offset;
template <class T>
using Numbers = Offset<flatbuffers::Vector<T>>;

template <class Matrix>
Numbers<double> numbers(FlatBufferBuilder& builder, const Matrix& matrix) {
  return builder.CreateVector(matrix.data(), static_cast<std::size_t>(matrix.size()));
}

file::Distance to_file(const VertexDistance& d) { return {d.mean, d.worst, d.worst_vertex}; }
file::PoseError to_file(const PoseError& e) {
  return {to_file(e.projection), to_file(e.cueing), to_file(e.total)};
}

file::LearnSettings to_file(const LearnSettings& s) {
  return {s.size.energy,
          s.key_points.first_share,
          s.key_points.max_share,
          s.key_points.tolerance,
          s.size.modes,
          s.key_points.max_rounds,
          s.max_clusters,
          s.max_poses,
          static_cast<std::uint32_t>(s.subspace)};
}

Offset<file::Subspace> write(FlatBufferBuilder& builder, const Pca& pca) {
  const Eigen::MatrixXf basis = pca.basis.cast<float>();  // exact: they are floats
  const auto mean = numbers(builder, pca.mean), deviations = numbers(builder, pca.deviations),
             energy = numbers(builder, pca.energy);
  const auto columns = builder.CreateVector(basis.data(), static_cast<std::size_t>(basis.size()));
  return file::CreateSubspace(builder, mean, columns, deviations, energy);
}

Offset<file::Kernel> write(FlatBufferBuilder& builder, const KernelPca& kernel) {
  const auto pca = write(builder, kernel.pca);
  const auto samples = numbers(builder, kernel.samples), weights = numbers(builder, kernel.weights),
             row_means = numbers(builder, kernel.row_means), deviations = numbers(builder, kernel.deviations),
             energy = numbers(builder, kernel.energy);
  return file::CreateKernel(builder, pca, samples, kernel.width, weights, row_means, deviations, energy);
}

Offset<file::Clusters> write(FlatBufferBuilder& builder, const Clusters& clusters) {
  const auto of = builder.CreateVector(clusters.cluster_of), medoids = builder.CreateVector(clusters.medoids);
  return file::CreateClusters(builder, of, numbers(builder, clusters.centers), medoids, clusters.spread,
                              clusters.silhouette);
}

Offset<file::Certificates> write(FlatBufferBuilder& builder, const CertificateMap& map) {
  std::vector<std::uint8_t> sources;
  for (const auto source : map.sources) sources.push_back(static_cast<std::uint8_t>(source));
  const auto nodes = builder.CreateVector(map.nodes);
  const auto anchor = numbers(builder, map.anchor), mean_x = numbers(builder, map.cca.mean_x),
             mean_y = numbers(builder, map.cca.mean_y), weights = numbers(builder, map.cca.weights),
             loadings = numbers(builder, map.cca.loadings),
             correlations = numbers(builder, map.cca.correlations);
  const auto thresholds = builder.CreateVector(map.thresholds);
  const auto source_vector = builder.CreateVector(sources);
  std::vector<double> excesses, miss_rates;
  for (const CertificateMap::CalibrationPoint& point : map.calibration) {
    excesses.push_back(point.excess);
    miss_rates.push_back(point.miss_rate);
  }
  const auto excess_vector = builder.CreateVector(excesses);
  const auto miss_rate_vector = builder.CreateVector(miss_rates);
  return file::CreateCertificates(builder, nodes, anchor, mean_x, mean_y, weights, loadings, correlations,
                                  thresholds, source_vector, map.balanced_accuracy, map.majority_accuracy,
                                  map.false_discovery_rate, excess_vector, miss_rate_vector);
}

std::uint64_t bytes_of(const Pca& pca) {
  return 8 * static_cast<std::uint64_t>(pca.mean.size()) + 4 * static_cast<std::uint64_t>(pca.basis.size()) +
         16 * static_cast<std::uint64_t>(pca.deviations.size());
}

}  // namespace

Offset<file::Learned> write_learned(FlatBufferBuilder& builder, const Learned& learned) {
  std::vector<file::LearnedPose> poses;
  for (const LearnedPose& p : learned.poses) {
    poses.emplace_back(p.pose, to_file(p.trained), to_file(p.leave_one_out));
  }
  std::vector<file::Region> regions;
  for (const LearnedRegion& r : learned.regions) {
    regions.emplace_back(r.mean, r.worst, r.node, r.worst_vertex, r.worst_pose);
  }
  const auto subspace = write(builder, learned.pca);
  const auto kernel = learned.kernel ? write(builder, *learned.kernel) : 0;
  const auto clusters = write(builder, learned.clusters);
  const auto certificates = learned.certificates ? write(builder, *learned.certificates) : 0;
  const auto pose_vector = builder.CreateVectorOfStructs(poses);
  const auto region_vector = builder.CreateVectorOfStructs(regions);
  const auto coordinates = numbers(builder, learned.coordinates);
  const auto key_points = builder.CreateVector(learned.key_points.vertices),
             key_rounds = builder.CreateVector(learned.key_points.round_ends);
  const auto key_errors = builder.CreateVector(learned.key_points.errors);
  const file::LearnSettings settings = to_file(learned.settings);
  return file::CreateLearned(builder, &settings, learned.size, subspace, kernel, pose_vector, coordinates,
                             key_points, key_rounds, key_errors, clusters, certificates, region_vector);
}

std::uint64_t bound_of_learned_bytes(const Learned& learned) {
  std::uint64_t numbers =
      static_cast<std::uint64_t>(learned.coordinates.size() + learned.clusters.centers.size()) +
      4 * learned.key_points.vertices.size() + 32 * learned.poses.size() + 8 * learned.regions.size() + 4096;
  std::uint64_t bytes = bytes_of(learned.pca);
  if (learned.kernel) {
    bytes += bytes_of(learned.kernel->pca);
    numbers += static_cast<std::uint64_t>(learned.kernel->samples.size() + learned.kernel->weights.size()) +
               4 * learned.poses.size();
  }
  if (learned.certificates) {
    const CertificateMap& map = *learned.certificates;
    numbers += static_cast<std::uint64_t>(map.cca.weights.size() + map.cca.loadings.size() +
                                          2 * map.anchor.size() + map.cca.correlations.size()) +
               4 * map.nodes.size() + 2 * map.calibration.size();
  }
  return bytes + 8 * numbers;
}

}  // namespace foldproof::internal
