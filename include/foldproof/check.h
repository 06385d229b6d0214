/// Queries: every collision of a set of moving objects during one step, or every crossing in one pose.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "foldproof/bvh.h"
#include "foldproof/ccd.h"

namespace foldproof {

class ChartLibrary;  // foldproof/certificate.h

/// How far an answer can be relied on.
enum class Mode : std::uint8_t {
  Proven,  ///< No collision is missing.
  /// STATISTICAL, can miss collisions: the certificates of nodes are predicted from key points and believed,
  /// as the paper has it (Eq. 3 and 8). Nothing is proven but what boxes keep apart. For comparison.
  Paper,
};

struct StepSettings {
  bool within = true;    ///< Collisions of each object with itself.
  bool between = true;   ///< Collisions of every two objects.
  double thickness = 0;  ///< Mesh units, >= 0. Closer than or equal to this is a collision.
  double tolerance = 0;  ///< Mesh units. How far beyond `thickness` a reported pair may be. 0: 2^-30 of the
                         ///< largest side of the box around everything during the step.
  /// List at most so many pairs of each kind, those with the smallest ids; all are counted nevertheless. The
  /// answer takes memory for about as many. Does not apply to `earliest_only`.
  std::uint64_t max_listed = 10'000'000;
  Mode mode = Mode::Proven;
  /// Mode::Paper: believe only as much as would have missed at most this share of what was not proven in
  /// poses that training held out (CertificateMap::Trust). In [0,1].
  double miss_rate = 0.01;
  /// Use certificates where they pay: they prove pairs of leaves free of contact, which then need no test. A
  /// checker measures from counts whether they pay, and backs off while they do not. Never changes the
  /// answer.
  bool certificates = true;
  /// Look ahead: while a motion continues in straight lines, one search covers several steps. It extrapolates
  /// the trajectories and keeps the candidates; a later step whose vertices are close enough to the predicted
  /// ones only tests these. Never changes the answer. Has no effect without certificates.
  bool ahead = true;
  bool earliest_only =
      false;  ///< Report only the pair with the earliest time of impact (ties: smallest ids).
  /// Fill the answer's `explanation`: what certificates did. They are then used even where they do not pay,
  /// and no search looks ahead. Takes about as long again as finding the pairs of leaves; the answer's times
  /// leave that out.
  bool explain = false;
};

/// Vertex and face, by the user's ids.
struct VertexFaceCollision {
  Index vertex_object, vertex, face_object, face;
  double toi;     ///< In [0,1] of the step. Proven free of contact before it.
  Answer answer;  ///< Hit or Undecided.
};

/// Two edges as vertex ids, the smaller first in each; within one object the lexicographically smaller edge
/// is a.
struct EdgeEdgeCollision {
  Index object_a;
  Edge a;
  Index object_b;
  Edge b;
  double toi;
  Answer answer;
};

/// Two triangles that cross, the smaller (object, triangle) first.
struct TriangleCrossing {
  Index object_a, triangle_a, object_b, triangle_b;
};

/// What a query did. Depends on settings and input only, with certificates also on that of earlier steps;
/// never on the machine or the number of threads, except undecided with `earliest_only`. Where an earlier
/// search covered the step (StepResult::searched), only candidates are counted.
struct Work {
  std::uint64_t node_tests = 0;          ///< Pairs of nodes visited.
  std::uint64_t certificate_tests = 0;   ///< Certificates evaluated.
  std::uint64_t certificate_passes = 0;  ///< Certificates that proved their pair apart.
  std::uint64_t leaf_pairs = 0;  ///< Pairs of leaves, a leaf with itself included, whose features are tested.
  std::uint64_t candidates_vf = 0;  ///< Feature pairs passed to the narrow phase.
  std::uint64_t candidates_ee = 0;
  std::uint64_t undecided = 0;  ///< Narrow-phase answers that count as hits without being shown to be one.

  Work& operator+=(const Work& more);
};

/// Wall time of one query and of its stages, in milliseconds. `update`: motion; `traverse`: broad phase,
/// culling and boxes of features; `narrow`: candidates and narrow phase.
struct StageTimes {
  double total = 0, update = 0, traverse = 0, narrow = 0;

  StageTimes& operator+=(const StageTimes& more);
};

/// Why the features of a leaf were tested. If several reasons apply, the last of them in this list.
enum class Reason : std::uint8_t {
  Certified,  ///< They were not: each pair of leaves is proven apart, by certificates or by its boxes.
  NotDrawn,  ///< Nothing has been tried yet: there is no chart of the patch or of one around it, and its turn
             ///< is still to come. So it is with everything in a checker's first step.
  TestFailed,  ///< The patch or one around it has charts, and none of them holds in this step.
  Tangled,     ///< When last tried, no chart could be drawn: ChartOutcome::Tangled.
  TooCurved,   ///< The same: ChartOutcome::TooCurved.
  NearOther,  ///< A leaf without a common vertex, maybe of another object, is near, and no plane between them
              ///< was found.
  Off,        ///< StepSettings::certificates is false.
};
inline constexpr std::array<const char*, 7> kReasonNames{"certified",  "not_drawn",  "test_failed", "tangled",
                                                         "too_curved", "near_other", "off"};
/// A number per reason.
using ReasonCounts = std::array<std::uint64_t, kReasonNames.size()>;

/// What certificates did in a query. Reused: buffers are kept.
struct Explanation {
  /// By the user's triangles; those of one leaf have everything in common.
  struct Object {
    /// Depth in the hierarchy, the root's is 0, of the node whose chart proves that nothing below it touches
    /// anything else below it, this triangle's leaf included; the highest there is. 127 stands for all from
    /// there on. -1 when no node does, or when nobody asked: certificates off, or only collisions between
    /// objects wanted.
    std::vector<std::int8_t> level;
    /// How far that chart is from failing, in [0,1]: 1 where the patch looks as it did when it was drawn,
    /// near 0 where the proof barely holds. 0 where level is -1.
    std::vector<float> margin;
    std::vector<Reason> reason;
  };
  std::vector<Object> objects;
  /// Of the pairs of leaves whose boxes are not apart, a leaf with itself included, those tested for each
  /// reason; their sum is Work::leaf_pairs. Under Certified: those not tested.
  ReasonCounts leaf_pairs{};
};

/// Answer of a step. Sorted by ids; bit-identical for any number of threads. Reuse it: its buffers are kept.
struct StepResult {
  std::vector<VertexFaceCollision> vertex_face;  ///< At most StepSettings::max_listed.
  std::vector<EdgeEdgeCollision> edge_edge;      ///< The same.
  std::uint64_t vertex_face_count = 0;           ///< How many there are, listed or not.
  std::uint64_t edge_edge_count = 0;
  double tolerance = 0;  ///< The tolerance that was used, mesh units.
  Index searched = 1;    ///< How many steps this one's search covers, itself included; 0: an earlier search
                         ///< covered it (StepSettings::ahead).
  double earliest_toi = 1;  ///< 1 when nothing collides.
  Work work;
  StageTimes milliseconds;
  Explanation explanation;  ///< With StepSettings::explain.

  std::uint64_t count() const { return vertex_face_count + edge_edge_count; }
  bool clean() const { return count() == 0; }
};

/// Answer of a static query. Sorted by ids.
struct StaticResult {
  std::vector<TriangleCrossing> crossings;  ///< At most StepSettings::max_listed.
  std::uint64_t crossing_count = 0;         ///< How many there are, listed or not.
  Work work;
  StageTimes milliseconds;
  Explanation explanation;  ///< With StepSettings::explain.

  bool clean() const { return crossing_count == 0; }
};

/// Positions of all objects at one time, mesh units: vertex_count x 3 row-major doubles per object. A view;
/// it does not keep what it refers to.
class Positions {
 public:
  /// Of no object.
  Positions() = default;
  /// Of one object.
  Positions(std::span<const double> x) : one_(x), size_(1) {}
  Positions(const std::vector<double>& x) : Positions(std::span<const double>(x)) {}
  /// Of several.
  Positions(std::span<const std::span<const double>> all) : all_(all.data()), size_(all.size()) {}
  Positions(const std::vector<std::span<const double>>& all) : Positions(std::span(all)) {}
  template <std::size_t n>
  Positions(const std::span<const double> (&all)[n]) : all_(all), size_(n) {}

  /// How many objects.
  std::size_t size() const { return size_; }
  std::span<const double> operator[](std::size_t object) const { return all_ ? all_[object] : one_; }

 private:
  std::span<const double> one_;
  const std::span<const double>* all_ = nullptr;
  std::size_t size_ = 0;
};

/// Predicts, without proof, which nodes of a hierarchy do not touch themselves during a step. Only
/// Mode::Paper uses it. `predicted_certificates` (foldproof/learned.h) makes the one that the paper
/// describes.
class NodePredictor {
 public:
  virtual ~NodePredictor() = default;
  /// Sets free[node] to 1 where the node is predicted not to touch itself, else to 0. `miss_rate`: see
  /// StepSettings. Called by one thread at a time for each checker.
  virtual void predict(std::span<const double> x0, std::span<const double> x1, double miss_rate,
                       std::span<std::uint8_t> free) const = 0;
};

/// One object of a query. Thousands may share a hierarchy and charts. A trained model makes one with
/// Model::object. Precondition: pointers are not null, except `predictor`.
class Object {
 public:
  /// Untrained: charts are made during the run.
  Object(std::shared_ptr<const Hierarchy> hierarchy);
  Object(Hierarchy hierarchy);
  /// With trained charts, which know their hierarchy. Mode::Paper needs a predictor.
  Object(std::shared_ptr<const ChartLibrary> charts,
         std::shared_ptr<const NodePredictor> predictor = nullptr);

  const std::shared_ptr<const Hierarchy>& hierarchy() const { return hierarchy_; }
  /// Null when untrained.
  const std::shared_ptr<const ChartLibrary>& charts() const { return charts_; }
  const std::shared_ptr<const NodePredictor>& predictor() const { return predictor_; }

 private:
  std::shared_ptr<const Hierarchy> hierarchy_;
  std::shared_ptr<const ChartLibrary> charts_;
  std::shared_ptr<const NodePredictor> predictor_;
};

/// Answers queries on a fixed set of objects. Keeps its scratch, so a second step of the same size allocates
/// nothing; with certificates, once no more charts are made and searches that look ahead find no more than
/// before. Use one checker per thread. Threads inside a query come from oneTBB: limit them with
/// tbb::global_control or a task arena of your own.
class StepChecker {
 public:
  explicit StepChecker(std::vector<Object> objects);
  ~StepChecker();
  StepChecker(StepChecker&&) noexcept;
  StepChecker& operator=(StepChecker&&) noexcept;

  /// Every vertex-face and edge-edge pair without a common vertex that comes into contact while all vertices
  /// go from x0 to x1 along straight lines. Soundness: no pair that touches is missing; a reported pair comes
  /// within thickness + tolerance (docs/soundness.md). Error: wrong sizes, coordinates that are not finite.
  Result<void> check(Positions x0, Positions x1, const StepSettings& settings, StepResult& out);

  /// Every pair of triangles that has a point in common beyond the vertices and edges they share, decided
  /// with exact arithmetic. `thickness`, `tolerance` and `earliest_only` do not apply. Of two triangles with
  /// a common edge: folded flat onto each other. With one common vertex: the side opposite to it meets the
  /// other triangle, so that another vertex at the common vertex's place counts. The same three vertices
  /// twice: always. Of triangles that name the same vertices in the same order one is looked at, so that many
  /// copies cost little; an Explanation says of all of them what holds for that one.
  Result<void> check_static(Positions x, const StepSettings& settings, StaticResult& out);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace foldproof
