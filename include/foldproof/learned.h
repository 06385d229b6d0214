/// What training learns about a mesh besides charts: a subspace of its shapes, key points that tell a shape,
/// groups of poses, what key points say about charts, and how well all of it fits (docs/learning.md). All of
/// it proposes; nothing here proves anything.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <optional>

#include "foldproof/certificate.h"
#include "foldproof/check.h"
#include "foldproof/io.h"
#include "foldproof/keypoints.h"

namespace foldproof {

/// How a shape is rebuilt.
enum class SubspaceKind : std::uint8_t {
  Pca,       ///< x = mean + basis p.
  KernelPca  ///< The same, then drawn to the training poses by kernel PCA.
};

struct LearnSettings {
  SubspaceKind subspace = SubspaceKind::Pca;
  SubspaceSize size;
  KeyPointSettings key_points;
  Index most_clusters = 8;
  /// More are learned from evenly spread ones: leave-one-out costs the third power of their number for each.
  Index most_poses = 256;
};

/// How well a training pose is represented; distances in mesh units.
struct LearnedPose {
  Index pose = 0;      ///< Its number among the model's poses.
  PoseError trained;   ///< By what was learned from all poses.
  PoseError left_out;  ///< By what the other poses teach, with the same key points.
};

/// How well a region is represented: the triangles below a node of the hierarchy. Distances in mesh units, of
/// its vertices from what the other poses make of each pose.
struct LearnedRegion {
  Index node = 0;
  double mean = 0, worst = 0;
  Index worst_vertex = 0;  ///< The user's id.
  Index worst_pose = 0;    ///< Its number among the model's poses.
};

/// What key points say about charts (paper, Eq. 3). The certificate of a node is its margin (1: as drawn;
/// above 0: proven; at least -1), the largest of its charts.
struct CertificateMap {
  /// Where a threshold comes from.
  enum class Source : std::uint8_t {
    Node,   ///< The discriminant of the node's own poses.
    Level,  ///< That of all nodes on its level, as the node has hardly a pose of one kind.
    None    ///< Neither: 0, where the margin itself changes its sign.
  };
  std::vector<Index> nodes;        ///< Whole levels of the hierarchy from the root down, those with a chart.
  Eigen::VectorXd anchor;          ///< The mean's key positions.
  Cca cca;                         ///< From key positions in place() to margins, one per node.
  std::vector<double> thresholds;  ///< Per node: a predicted margin above it is taken for proven.
  std::vector<Source> sources;     ///< Per node.
  // How well poses are told that stay out while the map is made, an eighth of them at a time; over nodes that
  // are proven in some poses and not in others, both kinds counting alike. 0.5 is a coin's.
  double right = 0;     ///< Share told right.
  double guessed = 0;   ///< Share that is right when every node is said to do what it does more often.
  double believed = 0;  ///< Share not proven of what is taken for proven.

  /// What belief costs, tried on poses that stay out: who believes a margin that is predicted more than
  /// `excess` above the node's threshold, believes the share `missed` of all pairs of pose and node that are
  /// not proven. One wrong belief more is counted than there was: few examples do not show small shares.
  struct Trust {
    double excess, missed;
  };
  std::vector<Trust> trust;  ///< Excess ascending from 0, `missed` falling.
  /// The least excess at which at most that share is missed; none when no excess is enough.
  std::optional<double> excess_for(double miss_rate) const;

  /// Key positions moved rigidly onto the anchor (least squares; Umeyama 1991): the prediction does not
  /// depend on where the mesh stands and how it is turned.
  Eigen::VectorXd place(const VectorView& key_positions) const;
  /// Margins that are to be expected, one per node.
  Eigen::VectorXd margins(const VectorView& key_positions) const { return cca.predict(place(key_positions)); }
};

/// Immutable once made; any number of threads may use it. Positions are absolute, mesh units.
struct Learned {
  LearnSettings settings;
  double size = 0;                  ///< Largest side of the box around the first pose, mesh units.
  Pca pca;                          ///< Always there: reduced motion is linear.
  std::optional<KernelPca> kernel;  ///< With SubspaceKind::KernelPca.
  std::vector<LearnedPose> poses;   ///< Those learned from, ascending.
  Eigen::MatrixXd coordinates;      ///< Their p, a column each.
  KeyPoints key_points;
  Clusters clusters;                                   ///< Of `coordinates`.
  std::shared_ptr<const CertificateMap> certificates;  ///< Null when no node has a chart.
  std::vector<LearnedRegion> regions;                  ///< Some 64 that make up the mesh, by node.
};

/// What the other poses represent badly when it is left out: a mean distance of more than twice the median.
/// Places in Learned::poses, worst first.
std::vector<Index> badly_represented_poses(const Learned& learned);
/// The same for regions: places in Learned::regions.
std::vector<Index> badly_represented_regions(const Learned& learned);

/// Predicts certificates from the key points at both ends of a step (paper, Eq. 3), for Mode::Paper. They
/// prove nothing. Null where no certificates were learned.
std::shared_ptr<const NodePredictor> predicted_certificates(std::shared_ptr<const Learned> learned);

/// Vertices that are rebuilt from key points, or p.
class Predictor {
 public:
  explicit Predictor(std::shared_ptr<const Learned> learned);

  const Learned& learned() const { return *learned_; }
  const KeyPointMap& key_point_map() const { return map_; }
  /// All vertices from the key points' positions. Cost: O(modes * vertices).
  Eigen::VectorXd from_key_points(const VectorView& key_positions) const;
  /// The best that the subspace has for a whole pose.
  Eigen::VectorXd from_all_points(const VectorView& x) const;
  /// What is lost by the subspace and by key points.
  PoseError error(const VectorView& x) const;

 private:
  Eigen::VectorXd rebuild(const Eigen::VectorXd& p) const;
  std::shared_ptr<const Learned> learned_;
  KeyPointMap map_;
};

struct LearnHooks {
  std::function<void(double)> progress = {};  ///< Called with the share of the work that is done.
  const std::atomic<bool>* cancel = nullptr;  ///< true ends learning in an error, soon.
};

/// What learning looks at.
struct LearnInput {
  std::vector<Index> poses;  ///< Numbers among the model's poses, ascending; at least 3.
  Eigen::MatrixXd samples;   ///< Their positions, by the user's vertex ids, a column each.
  std::vector<Index> nodes;  ///< As predictable_nodes gives them.
  Eigen::MatrixXd margins;   ///< Of these nodes, a column per pose.
};

/// The same input gives the same result for any number of threads. Memory: about four times the samples.
/// Error: poses that are all the same, numbers that are not finite, cancelled, settings beyond their range.
Result<Learned> learn(const Hierarchy& hierarchy, const LearnInput& input, const LearnSettings& settings,
                      const LearnHooks& hooks = {});

/// Nodes whose margins are worth predicting: those with a chart, by whole levels from the root down, at most
/// `most`. Ascending.
std::vector<Index> predictable_nodes(const ChartLibrary& charts, Index most = 2048);

/// Measures margins. Scratch: one per thread; uses the caller's oneTBB arena.
class MarginMeter {
 public:
  explicit MarginMeter(std::shared_ptr<const ChartLibrary> charts);
  ~MarginMeter();
  MarginMeter(MarginMeter&&) noexcept;
  /// The margin of each node in a pose; -1 without a chart. `positions` by the user's vertex ids, finite.
  Eigen::VectorXd of(std::span<const Index> nodes, std::span<const double> positions);

 private:
  struct Scratch;
  std::unique_ptr<Scratch> scratch_;
};

/// Positions of key points, frame by frame.
struct KeyPointTracks {
  std::string name;  ///< For people.
  Index frames = 0, points = 0;
  std::vector<double> positions;  ///< frames x points x 3, points in the order of the key points.
};

/// Reads tracks: an NPZ with the array `keypoints` (frames x points x 3, or points x 3), or a CSV with either
/// the columns frame, vertex, x, y, z in any order of rows, or x y z of each point and a row per frame.
Result<KeyPointTracks> read_key_point_tracks(const std::string& path, std::span<const Index> vertices);

/// Takes the key points out of a motion of the same mesh.
Result<KeyPointTracks> tracks_of(Motion& motion, std::span<const Index> vertices,
                                 std::span<const Index> frames);

/// The motion that tracks tell, rebuilt frame by frame as it is read.
std::unique_ptr<Motion> predicted_motion(std::string name, Topology topology,
                                         std::shared_ptr<const Predictor> predictor, KeyPointTracks tracks);

/// A pose that would teach much.
struct Suggestion {
  enum class Why : std::uint8_t {
    Frame,       ///< A frame of the motion that neither the model nor the suggestions before it can tell.
    OneExample,  ///< A direction that only one training pose shows: half of what it alone does.
    OneSided,    ///< A mode that training poses show to one side only: the other side, as far.
  };
  Why why;
  Index number;             ///< Of the frame, of the pose among the model's, or of the mode.
  VertexDistance distance;  ///< From the nearest thing that the model and suggestions before it know.
  double left = 0;          ///< Frame: mean distance over the motion once the model knows this pose too.
  std::vector<double> positions;  ///< The pose, by the user's vertex ids.
};

/// Without a motion all there is to go by are the training poses: which directions have one example, and
/// which modes lean to one side. At most `count`, largest distance first.
std::vector<Suggestion> suggest_poses(const Learned& learned, Index count);

/// Frames of a motion, chosen one after the other: always the one farthest from the linear subspace, to which
/// it then belongs. Fewer than `count` when the rest is rounding. Reads the motion count + 1 times. Error: a
/// motion of another vertex count, a frame that cannot be read, cancelled.
Result<std::vector<Suggestion>> suggest_frames(const Learned& learned, Motion& motion,
                                               std::span<const Index> frames, Index count,
                                               const LearnHooks& hooks = {});

}  // namespace foldproof
