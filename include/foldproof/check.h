/// Queries: all collisions of a set of moving objects during one step, or all crossings in one pose.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "foldproof/bvh.h"
#include "foldproof/ccd.h"

namespace foldproof {

class ChartLibrary;  // opaque: what a trained model gives

struct StepSettings {
  bool within = true;    ///< Collisions of each object with itself.
  bool between = true;   ///< Collisions of every two objects. One of the two must be on.
  double thickness = 0;  ///< Mesh units, >= 0. A distance up to this is a collision.
  double tolerance = 0;  ///< Mesh units. How far beyond `thickness` a reported pair may be. 0: 2^-30 of the
                         ///< largest side of the scene's bounding box during the step.
  /// List at most this many pairs of each kind, those with the smallest ids; all are counted. Limits the
  /// memory of the answer. Does not apply to `earliest_only`.
  std::uint64_t max_listed = 10'000'000;
  /// Use certificates where they pay: pairs of leaves that they prove free of collisions need no test. The
  /// checker estimates from counts whether they pay. Never changes the answer.
  bool certificates = true;
  /// Look ahead: while a motion continues in straight lines, one search covers several steps. It extrapolates
  /// the trajectories and caches the candidates; a later step whose vertices are close enough to the
  /// predicted positions only tests these. Never changes the answer. Has no effect without certificates.
  bool look_ahead = true;
  /// Report only the pair with the earliest time of impact (ties: smallest ids).
  bool earliest_only = false;
  /// Fill the answer's `explanation`. Certificates are then used even where they do not pay, and no search
  /// looks ahead. Takes about as long again as finding the pairs of leaves, which the answer's times do not
  /// include.
  bool explain = false;
  /// STATISTICAL, may miss collisions; for comparisons with methods that predict. Per object and node of its
  /// hierarchy, not 0 where the caller declares, without proof, that the node does not touch itself in this
  /// query. Believed where the object's charts (Object::charts) have one of the node; then nothing else is
  /// proven but that boxes are apart. Null: nothing is declared.
  const std::vector<std::vector<std::uint8_t>>* declared_free = nullptr;

  bool operator==(const StepSettings&) const = default;
};

/// Vertex and face, by the user's ids.
struct VertexFaceCollision {
  Index vertex_object, vertex, face_object, face;
  double toi;     ///< In [0,1] of the step. No collision before it, proven.
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

/// Work counters of a query. They depend on settings and input only, with certificates also on those of
/// earlier steps; never on the machine or the number of threads, except `undecided` with `earliest_only`.
/// Where an earlier search covers the step (StepResult::search_steps), only candidates are counted. A long
/// step is searched in several stretches of its time, and all of them are counted.
struct Work {
  /// Hierarchies whose boxes were refitted: in a search those of all objects, none in a step that an earlier
  /// search covers. A ReducedChecker refits where it computes all vertices of an object, to check it alone.
  std::uint64_t refits = 0;
  std::uint64_t node_tests = 0;          ///< Pairs of nodes visited.
  std::uint64_t certificate_tests = 0;   ///< Certificates evaluated.
  std::uint64_t certificate_passes = 0;  ///< Certificates that proved their pair separated.
  std::uint64_t leaf_pairs = 0;  ///< Pairs of leaves, a leaf with itself included, whose features are tested.
  std::uint64_t candidates_vf = 0;  ///< Feature pairs passed to the narrow phase.
  std::uint64_t candidates_ee = 0;
  std::uint64_t undecided = 0;  ///< Narrow-phase answers Answer::Undecided, which count as hits.

  Work& operator+=(const Work& more);
};

/// Wall time of one query and of its stages, in milliseconds. `update`: positions and refit; `traverse`:
/// broad phase and culling, in a search that looks ahead also finding candidates; `narrow`: finding them and
/// testing them.
struct StageTimes {
  double total = 0, update = 0, traverse = 0, narrow = 0;

  StageTimes& operator+=(const StageTimes& more);
};

/// Why the features of a leaf were tested. If several reasons apply, the last one in this list.
enum class Reason : std::uint8_t {
  /// They were not tested: certificates or boxes prove each pair of leaves separated, or it is ignored.
  Certified,
  /// No chart has been tried yet, neither of the patch nor of one that contains it. Without a model, always
  /// so in a checker's first step.
  NotBuilt,
  /// The patch or one that contains it has charts, but none of them holds in this step.
  TestFailed,
  /// The last attempt at a chart failed: ChartOutcome::Overlapping.
  Overlapping,
  /// The last attempt at a chart failed: ChartOutcome::TooCurved.
  TooCurved,
  /// A leaf without a common vertex, maybe of another object, is near, and no separating plane was found.
  NearOther,
  /// StepSettings::certificates is false.
  Off,
};
inline constexpr std::array<const char*, 7> kReasonNames{
    "certified", "not_built", "test_failed", "overlapping", "too_curved", "near_other", "off"};
/// A number per reason.
using ReasonCounts = std::array<std::uint64_t, kReasonNames.size()>;

/// What certificates did in a query. Reuse it: its buffers are kept.
struct Explanation {
  /// Per triangle of the user. All triangles of a leaf have the same values.
  struct Object {
    /// Depth in the hierarchy, 0 for the root, of the highest node above this triangle whose chart proves
    /// that its patch does not touch itself. 127 stands for larger depths, too. -1 when there is none: also
    /// when certificates are off or only collisions between objects are reported.
    std::vector<std::int8_t> level;
    /// How far that chart is from failing, in [0,1]: 1 where the patch looks as it did when the chart was
    /// built, near 0 where the proof barely holds. 0 where level is -1.
    std::vector<float> margin;
    std::vector<Reason> reason;
  };
  std::vector<Object> objects;
  /// Pairs of leaves whose boxes are not separated, a leaf with itself included, that were tested for each
  /// reason; their sum is Work::leaf_pairs. Under Certified: those that were not tested.
  ReasonCounts leaf_pairs{};
};

/// Answer of a step. Sorted by ids; bit-identical for any number of threads. Reuse it: its buffers are kept.
struct StepResult {
  std::vector<VertexFaceCollision> vertex_face;  ///< At most StepSettings::max_listed.
  std::vector<EdgeEdgeCollision> edge_edge;      ///< The same.
  std::uint64_t vertex_face_count = 0;           ///< How many there are, listed or not.
  std::uint64_t edge_edge_count = 0;
  double tolerance = 0;     ///< The tolerance that was used, mesh units.
  Index search_steps = 1;   ///< How many steps the search of this step covers, itself included; 0: an earlier
                            ///< search covered it (StepSettings::look_ahead).
  double earliest_toi = 1;  ///< 1 when nothing collides.
  Work work;
  StageTimes milliseconds;
  Explanation explanation;  ///< With StepSettings::explain.

  bool complete = false;  ///< The query came to its end: it failed neither with an error nor an exception.

  std::uint64_t count() const { return vertex_face_count + edge_edge_count; }
  /// Nothing collides; false also where the query failed.
  bool clean() const { return complete && count() == 0; }
  /// False when there are more than StepSettings::max_listed.
  bool lists_all() const { return vertex_face.size() + edge_edge.size() == count(); }
};

/// Answer of a static query. Sorted by ids.
struct StaticResult {
  std::vector<TriangleCrossing> crossings;  ///< At most StepSettings::max_listed.
  std::uint64_t crossing_count = 0;         ///< How many there are, listed or not.
  Work work;
  StageTimes milliseconds;
  Explanation explanation;  ///< With StepSettings::explain.

  bool complete = false;  ///< As in StepResult.

  /// Nothing crosses; false also where the query failed.
  bool clean() const { return complete && crossing_count == 0; }
};

/// Positions of all objects at one time, mesh units: vertex_count x 3 row-major doubles per object. A view:
/// it does not own them.
class Positions {
 public:
  /// No object.
  Positions() = default;
  /// One object.
  Positions(std::span<const double> x) : one_(x), size_(1) {}
  Positions(const std::vector<double>& x) : Positions(std::span<const double>(x)) {}
  /// Several objects.
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

/// One object of a query. Thousands of objects may share a hierarchy and charts. Model::object makes one from
/// a trained model. Precondition: pointers are not null.
class Object {
 public:
  /// Untrained: charts are built during the run.
  Object(std::shared_ptr<const Hierarchy> hierarchy);
  Object(Hierarchy hierarchy);
  /// With trained charts and their hierarchy.
  Object(std::shared_ptr<const ChartLibrary> charts);

  const std::shared_ptr<const Hierarchy>& hierarchy() const { return hierarchy_; }
  /// Null when untrained.
  const std::shared_ptr<const ChartLibrary>& charts() const { return charts_; }
  /// Its faces with the same three vertices are layers, such as the sides of one surface: they do not cross.
  bool is_layered() const { return layered_; }
  void set_layered(bool layered) { layered_ = layered; }

 private:
  std::shared_ptr<const Hierarchy> hierarchy_;
  std::shared_ptr<const ChartLibrary> charts_;
  bool layered_ = false;
};

/// Which pairs a checker tests; the others are ignored, and cost nothing where whole nodes are. Nodes and ids
/// are those of Object::hierarchy; two of one object come in either order. Never changes. Several threads
/// call it at once; it does not throw.
class PairFilter {
 public:
  virtual ~PairFilter() = default;
  /// Asked first: whether any pair of a feature or triangle below one node with one below the other is
  /// tested. A node with itself: any pair below it. May be true where none is.
  virtual bool nodes(Index object_a, Index node_a, Index object_b, Index node_b) const = 0;
  virtual bool vertex_face(Index vertex_object, Index vertex, Index face_object, Index face) const = 0;
  virtual bool edge_edge(Index object_a, const Edge& a, Index object_b, const Edge& b) const = 0;
  /// Two triangles of a pose.
  virtual bool crossing(Index object_a, Index triangle_a, Index object_b, Index triangle_b) const = 0;
  /// Triangles of an object with the same vertices in the same order are tested as one where this is the same
  /// for them; all answers above must then be, too.
  virtual Index kind(Index /*object*/, Index triangle) const { return triangle; }
};

/// Ignores pairs of labels, each in both orders; {g, g}: within label g. `labels`: per object one per
/// triangle, or a single one for the whole object; objects may have labels in common. A pair of triangles is
/// ignored if its labels are; a pair of features only if every pair of triangles that they belong to is, so a
/// vertex on the border of two parts belongs to both. Error: another number of labels, one above 10,000.
Result<std::shared_ptr<const PairFilter>> ignore_labels(std::span<const Object> objects,
                                                        std::span<const std::vector<Index>> labels,
                                                        std::span<const std::array<Index, 2>> ignored);

/// Answers queries on a fixed set of objects. Keeps its scratch, so a second step of the same size does not
/// allocate; with certificates, once no more charts are built and searches that look ahead find no more
/// candidates than before. A call that throws, for want of memory, makes the next one start afresh. Use one
/// checker per thread. Threads inside a query come from oneTBB: limit them with tbb::global_control or a task
/// arena of your own. A query runs to its end, also inside a task group of yours that is cancelled.
class StepChecker {
 public:
  /// `filter`: null tests all pairs.
  explicit StepChecker(std::vector<Object> objects, std::shared_ptr<const PairFilter> filter = nullptr);
  ~StepChecker();
  StepChecker(StepChecker&&) noexcept;
  StepChecker& operator=(StepChecker&&) noexcept;

  /// Reports every vertex-face and edge-edge pair without a common vertex that collides while all vertices
  /// move from x0 to x1 along straight lines. Soundness: no pair that touches is missing; a reported pair
  /// comes within thickness + tolerance, unless it is undecided (docs/soundness.md). Error: wrong sizes,
  /// coordinates that are not finite, a vertex that moves so far that x1 - x0 overflows.
  [[nodiscard]] Result<void> check(Positions x0, Positions x1, const StepSettings& settings, StepResult& out);

  /// Reports every pair of triangles that cross, by exact arithmetic. `thickness`, `tolerance` and
  /// `earliest_only` do not apply. When two triangles cross depends on the vertices that they have in common:
  /// - none: when they have a point in common;
  /// - one: when the side opposite to it, of either, meets the other triangle;
  /// - two: when they are folded flat onto each other;
  /// - three: always, unless Object::is_layered.
  /// Copies of a triangle (the same vertices in the same order) are tested as one and share an Explanation.
  [[nodiscard]] Result<void> check_static(Positions x, const StepSettings& settings, StaticResult& out);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace foldproof
