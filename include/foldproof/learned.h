/// What training learns about a mesh besides charts: a subspace of its shapes, key points from which a shape
/// is reconstructed, clusters of poses, a map that predicts certificates, and the errors of all of these
/// (docs/learning.md). These are estimates; nothing here proves anything.
#pragma once

#include <memory>
#include <optional>

#include "foldproof/bvh.h"
#include "foldproof/io.h"
#include "foldproof/keypoints.h"

namespace foldproof {

/// How a shape is reconstructed.
enum class SubspaceKind : std::uint8_t {
  Pca,       ///< x = mean + basis p.
  KernelPca  ///< The same, then pulled towards the training poses by kernel PCA.
};

struct LearnSettings {
  SubspaceKind subspace = SubspaceKind::Pca;
  SubspaceSize size;
  KeyPointSettings key_points;
  Index max_clusters = 8;
  /// Of more poses, an evenly spaced selection is used: the cost of leave-one-out is their number to the 4th.
  Index max_poses = 256;
};

/// The reconstruction errors of a training pose, mesh units.
struct LearnedPose {
  Index pose = 0;           ///< Index into Model::poses.
  PoseError trained;        ///< With what was learned from all poses.
  PoseError leave_one_out;  ///< With what the other poses teach, and the same key points.
};

/// The leave-one-out projection errors of a region over all poses, mesh units. A region is the triangles
/// below a node of the hierarchy.
struct LearnedRegion {
  Index node = 0;
  double mean = 0, worst = 0;
  Index worst_vertex = 0;  ///< The user's id.
  Index worst_pose = 0;    ///< Index into Model::poses.
};

/// Predicts certificates from key points (paper, Eq. 3). The certificate of a node is its margin, the largest
/// of its charts: 1 in the pose the chart was built in, positive where it proves the node, at least -1.
struct CertificateMap {
  /// Where a threshold comes from.
  enum class Source : std::uint8_t {
    Node,   ///< LDA of the node's own predictions.
    Level,  ///< LDA of all nodes on its level, because the node has too few poses of one class.
    None    ///< Neither: 0, the sign change of the margin.
  };
  std::vector<Index> nodes;        ///< The nodes with a chart on the first levels of the hierarchy.
  Eigen::VectorXd anchor;          ///< The mean's key positions.
  Cca cca;                         ///< From aligned key positions to margins, one per node.
  std::vector<double> thresholds;  ///< Per node: predicted as proven when the predicted margin is above.
  std::vector<Source> sources;     ///< Per node: of its threshold.
  // Measured by 8-fold cross-validation, over the nodes that are proven in some poses but not in all.
  double balanced_accuracy = 0;     ///< Of the predictions; 0.5 is chance.
  double majority_accuracy = 0;     ///< The same when each node gets its more frequent outcome.
  double false_discovery_rate = 0;  ///< Share of unproven pairs among those predicted as proven.

  /// When a node is predicted as proven only at a margin more than `excess` above its threshold, the share
  /// `miss_rate` of the unproven pairs of pose and node is still predicted as proven. Measured by
  /// cross-validation, with one miss added, because few examples cannot show small rates. Charts that were
  /// built in the poses of a fold are not left out with it, nor do thresholds change, so new poses miss more.
  struct CalibrationPoint {
    double excess, miss_rate;
  };
  std::vector<CalibrationPoint> calibration;  ///< Excess ascending from 0, miss rate descending.
  /// The smallest excess of at most that miss rate; none when every excess misses more.
  std::optional<double> excess_for(double miss_rate) const;

  /// Key positions aligned rigidly with the anchor (least squares; Umeyama 1991), so that predictions do not
  /// depend on the mesh's position and orientation.
  Eigen::VectorXd align(const VectorView& key_positions) const;
  /// Predicted margins, one per node.
  Eigen::VectorXd margins(const VectorView& key_positions) const { return cca.predict(align(key_positions)); }
};

/// Immutable once made; any number of threads may use it. Positions are absolute, mesh units.
struct Learned {
  LearnSettings settings;
  double size = 0;                  ///< Largest side of the box around the first pose, mesh units.
  Pca pca;                          ///< Always present: reduced motion is linear.
  std::optional<KernelPca> kernel;  ///< With SubspaceKind::KernelPca.
  std::vector<LearnedPose> poses;   ///< The poses learned from, ascending.
  Eigen::MatrixXd coordinates;      ///< Their subspace coordinates p, a column each.
  KeyPoints key_points;
  Clusters clusters;                                   ///< Of `coordinates`.
  std::shared_ptr<const CertificateMap> certificates;  ///< Null when no node has a chart.
  std::vector<LearnedRegion> regions;                  ///< At most 64 that partition the mesh, by node.
};

/// Indices into Learned::poses: those whose mean leave-one-out error is over twice the median, worst first.
std::vector<Index> badly_represented_poses(const Learned& learned);
/// The same of Learned::regions.
std::vector<Index> badly_represented_regions(const Learned& learned);

/// Reconstructs all vertices.
class Predictor {
 public:
  explicit Predictor(std::shared_ptr<const Learned> learned);

  const Learned& learned() const { return *learned_; }
  const KeyPointMap& key_point_map() const { return map_; }
  /// From the key points' positions. Cost: O(modes * vertices).
  Eigen::VectorXd from_key_points(const VectorView& key_positions) const;
  /// From all vertices of a pose: its best reconstruction in the subspace.
  Eigen::VectorXd from_all_points(const VectorView& x) const;
  /// From coordinates of the subspace, one per mode.
  Eigen::VectorXd from_coordinates(const Eigen::VectorXd& p) const;
  /// Of the reconstructions of a pose.
  PoseError error(const VectorView& x) const;

 private:
  std::shared_ptr<const Learned> learned_;
  KeyPointMap map_;
};

/// Positions of key points, frame by frame.
struct KeyPointTracks {
  std::string name;  ///< For messages.
  Index frames = 0, points = 0;
  std::vector<double> positions;  ///< frames x points x 3, points in the order of the key points.
};

/// Reads tracks: an NPZ with the array `keypoints` (frames x points x 3, or points x 3); or a CSV with either
/// the columns frame, vertex, x, y, z and rows in any order, or a row per frame with x y z of each point.
Result<KeyPointTracks> read_key_point_tracks(const std::string& path, std::span<const Index> vertices);

/// The tracks of these vertices in a motion of the same mesh.
Result<KeyPointTracks> extract_tracks(Motion& motion, std::span<const Index> vertices,
                                      std::span<const Index> frames);

/// The motion reconstructed from tracks, frame by frame as it is read.
std::unique_ptr<Motion> predicted_motion(std::string name, Topology topology,
                                         std::shared_ptr<const Predictor> predictor, KeyPointTracks tracks);

}  // namespace foldproof
