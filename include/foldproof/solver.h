/// Queries of implicit solvers: step sizes, candidates and intersections for Newton steps.
///
/// The terms are those of incremental potential contact, the conventions those of ipc-toolkit, whose names
/// docs/solvers.md maps.
#pragma once

#include <functional>

#include "foldproof/check.h"

namespace foldproof {

/// Which pairs of vertices may collide. A pair of features counts when at least one vertex of the one may
/// collide with at least one vertex of the other, as in ipc-toolkit. Immutable, cheap to copy.
class CollisionFilter {
 public:
  /// Any two vertices may collide.
  CollisionFilter() = default;
  /// Two vertices may collide if the function returns true. It is symmetric and does not throw. Several
  /// threads call it at once, a few times per pair of features whose boxes come close.
  explicit CollisionFilter(std::function<bool(Index, Index)> can_collide);
  /// The cheap form. `group_of_vertex`: numbers up to 10,000. Two vertices may collide unless their groups,
  /// in either order, are a pair in `excluded`; {g, g} excludes collisions within group g. Error: a group in
  /// `excluded` that no vertex has; a larger number.
  static Result<CollisionFilter> groups(std::vector<Index> group_of_vertex,
                                        std::span<const std::array<Index, 2>> excluded);
  /// The groups are patches of the surface: each may collide with the others, but not with itself.
  static Result<CollisionFilter> patches(std::vector<Index> patch_of_vertex);

  /// Whether any two vertices may collide.
  bool allows_all() const { return groups_ == nullptr && can_collide_ == nullptr; }
  bool operator()(Index i, Index j) const;
  /// Whether some vertex of `a` and another of `b` may collide.
  bool allows_any(std::span<const Index> a, std::span<const Index> b) const;
  /// The group of each vertex; empty where there are none.
  std::span<const Index> vertex_groups() const;
  /// How many vertices the filter was made for; kNoIndex: any number.
  Index vertex_count() const;

 private:
  struct Groups;
  std::shared_ptr<const Groups> groups_;
  std::shared_ptr<const std::function<bool(Index, Index)>> can_collide_;
};

struct CollisionMeshSettings {
  CollisionFilter filter;
  /// Vertices in no edge and no face collide as points; else they are ignored, as the inside of a volume.
  bool points = true;
  HierarchySettings hierarchy;
};

/// What may collide: faces, edges without a face, points without either. Immutable once made; any number of
/// checkers may share it.
class CollisionMesh {
 public:
  /// `rest_positions`: vertex_count x 3, row-major; the hierarchy is split by this pose (any will do), and
  /// ClosePair::mollifier_threshold depends on its lengths.
  /// `edges`: two vertex ids each, in either order. `faces`: three vertex ids each. Edges of faces that
  /// `edges` lacks are appended, so an empty matrix, or one with only the codimensional edges, is enough.
  /// Error: an id out of range, an edge twice or of one vertex, a face of one vertex, nothing that could
  /// collide, a filter for another number of vertices, positions that are not finite.
  static Result<CollisionMesh> make(std::span<const double> rest_positions, std::vector<Edge> edges,
                                    std::vector<Triangle> faces, CollisionMeshSettings settings = {});

  Index vertex_count() const { return hierarchy_->topology().vertex_count(); }
  /// The given edges as they were; then the missing edges of faces in lexicographic order, the smaller vertex
  /// first.
  std::span<const Edge> edges() const { return edges_; }
  std::span<const Triangle> faces() const {
    return hierarchy_->topology().triangles().first(hierarchy_->topology().face_count());
  }
  /// Edges in no face, and vertices in neither (none when CollisionMeshSettings::points is off), ascending.
  std::span<const Index> codim_edges() const { return codim_edges_; }
  std::span<const Index> codim_points() const { return codim_points_; }
  const CollisionFilter& filter() const { return filter_; }

  /// One hierarchy over everything: the faces, codim_edges() as lines, codim_points() as points.
  const std::shared_ptr<const Hierarchy>& hierarchy() const { return hierarchy_; }
  /// The row in edges() of edge number `edge` of the topology.
  Index edge_row(Index edge) const { return edge_rows_[edge]; }
  /// Of a row of edges(), in mesh units squared.
  double squared_rest_length(Index edge) const { return squared_rest_lengths_[edge]; }

 private:
  std::shared_ptr<const Hierarchy> hierarchy_;
  CollisionFilter filter_;
  std::vector<Edge> edges_;
  std::vector<Index> codim_edges_, codim_points_, edge_rows_;
  std::vector<double> squared_rest_lengths_;
};

struct VertexFaceCandidate {
  Index vertex, face;
  auto operator<=>(const VertexFaceCandidate&) const = default;
};
/// Rows of CollisionMesh::edges(), the smaller first.
struct EdgeEdgeCandidate {
  Index edge_a, edge_b;
  auto operator<=>(const EdgeEdgeCandidate&) const = default;
};
/// A codimensional edge and a codimensional point.
struct EdgeVertexCandidate {
  Index edge, vertex;
  auto operator<=>(const EdgeVertexCandidate&) const = default;
};
/// Two codimensional points, the smaller id first.
struct VertexVertexCandidate {
  Index vertex_a, vertex_b;
  auto operator<=>(const VertexVertexCandidate&) const = default;
};

/// Pairs of features that may be close, none twice, in an order that does not depend on earlier calls. Reuse
/// it.
struct Candidates {
  std::vector<VertexFaceCandidate> vertex_face;
  std::vector<EdgeEdgeCandidate> edge_edge;
  std::vector<EdgeVertexCandidate> edge_vertex;
  std::vector<VertexVertexCandidate> vertex_vertex;

  std::size_t size() const {
    return vertex_face.size() + edge_edge.size() + edge_vertex.size() + vertex_vertex.size();
  }
  bool empty() const { return size() == 0; }
  void clear();
};

/// Two features that are nearest to each other: what a barrier acts on (docs/solvers.md, "A barrier"). With
/// x_k the positions of `vertices`, the sum of weights[k] * x_k is the difference of their closest points.
/// Its length is `distance`, its direction `normal`; so weights[k] * normal is the gradient of the distance
/// at vertex k.
struct ClosePair {
  /// The first feature is the vertex; of two vertices the one with the smaller id.
  enum class Kind : std::uint8_t { VertexVertex, VertexEdge, VertexFace, EdgeEdge };
  Kind kind = Kind::VertexVertex;
  /// How many relevant pairs have these closest features. Incremental potential contact adds up their
  /// barriers. 1 for VertexFace and EdgeEdge.
  Index count = 1;
  /// Of the first feature, then of the second. Where they are fewer than four, the last one is repeated with
  /// weight 0.
  std::array<Index, 4> vertices{};
  /// Barycentric: those of the first feature add up to 1, those of the second to -1. None of a feature's
  /// weights is 0, except where edges are nearly parallel.
  std::array<double, 4> weights{};
  double distance = 0;  ///< Mesh units.
  Vec3 normal;          ///< Of length 1, from the second feature to the first; at distance 0, either way.
  /// Not 0 for edges that are nearly parallel: |a x b|^2 is below this, which is 1e-3 |a|^2 |b|^2 with
  /// lengths at rest (mesh units to the fourth power; none is marked where that underflows). Such a pair
  /// stays EdgeEdge wherever its closest points are, as the mollifier is a function of both edges.
  double mollifier_threshold = 0;

  bool operator==(const ClosePair&) const = default;
};
inline constexpr std::array<const char*, 4> kClosePairKindNames{"vertex_vertex", "vertex_edge", "vertex_face",
                                                                "edge_edge"};

struct ContactSettings {
  bool certificates = true;  ///< Skip what certificates prove: less work, the same answers.
  /// Mesh units. Pairs closer than the minimum distance plus this may count as collisions. 0: for each pair
  /// 2^-30 of the largest difference of coordinates between its features in x0, and at least what rounding
  /// needs, 2^-44 of that difference during the step.
  double tolerance = 0;
  /// A step that would collide goes this share of the way to the collision, in (0,1]. With 1 it could end
  /// within the tolerance of it, and the next step would start in collision.
  double conservative_rescaling = 0.8;
  /// Rescales gaps too, as ipc-toolkit does: distances less min_distance. A step that would collide leaves
  /// 1 - conservative_rescaling of each pair's gap in x0, or as much as that is of the pair that would
  /// collide first, if that is less; both less twice the tolerance.
  bool rescale_distance = false;
};

/// Yes, no, or an error. It does not convert to bool, as a Result would be true for both answers.
class [[nodiscard]] Verdict {
 public:
  Verdict(Result<bool> answer) : answer_(std::move(answer)) {}
  bool is_yes() const { return answer_.has_value() && *answer_; }
  bool is_no() const { return answer_.has_value() && !*answer_; }
  bool is_error() const { return !answer_.has_value(); }
  /// Precondition: is_error.
  const Error& error() const { return answer_.error(); }
  const Result<bool>& result() const { return answer_; }

 private:
  Result<bool> answer_;
};

/// How far a step may go.
struct StepSize {
  double share;  ///< In [0,1]; up to here the step is proven free of collisions.
  enum class Limit : std::uint8_t {
    None,     ///< It is 1.
    Contact,  ///< It is above 0: something collides on the way, or comes within the tolerance of it.
    Start,    ///< It is 0: in x0 a pair is already closer than min_distance plus the tolerance.
    /// The first pair that stands in the way is undecided, or it is 0 as no step could be proven free. This
    /// happens to very thin triangles, or where the tolerance is hardly above the rounding of positions.
    Undecided,
  } limit;  ///< Why the share is not larger.
  /// Unless the limit is None: the first collision, of those at the same time that of the smallest ids,
  /// vertex and face before edges; its time in [0,1], and the pair's closest features then, not marked as
  /// parallel. With rescale_distance, the first pair down to its share, if that limits the step. The time is
  /// 0 with a share above 0 where a pair is so close beside its long way that only a shorter one can be
  /// proven free.
  double contact_time = 1;
  ClosePair contact = {};
};
inline constexpr std::array<const char*, 4> kStepLimitNames{"none", "contact", "start", "undecided"};

/// Answers a solver's queries about one collision mesh. It keeps what it learned between calls: with the same
/// x0, or with poses that follow each other, they are cheap, and most allocate nothing. A call that throws,
/// for want of memory or from a filter, makes the next one start afresh. One checker per thread. A call uses
/// several threads through oneTBB and may be made in the iterations of a oneTBB loop.
///
/// Positions are vertex_count x 3, row-major, mesh units. During a step vertices move straight from x0 to x1.
/// *Relevant pairs* are a vertex and a face, two edges, a codimensional edge and a codimensional point, and
/// two codimensional points, if they have no vertex in common and the filter allows them. A relevant pair
/// *collides* if its distance is <= min_distance (0: it touches) at some time of the step. Errors of all
/// calls: wrong sizes, coordinates that are not finite, a vertex that moves so far that x1 - x0 overflows,
/// lengths that are negative or not finite. Soundness: docs/soundness.md, "Solvers".
class ContactChecker {
 public:
  /// `filter`: beside the mesh's CollisionFilter, for one object, mesh->hierarchy() (foldproof/filters.h);
  /// null: none.
  explicit ContactChecker(std::shared_ptr<const CollisionMesh> mesh, const ContactSettings& settings = {},
                          std::shared_ptr<const PairFilter> filter = nullptr);
  ~ContactChecker();
  ContactChecker(ContactChecker&&) noexcept;
  ContactChecker& operator=(ContactChecker&&) noexcept;

  const CollisionMesh& mesh() const;
  ContactSettings& settings();

  /// A share of the step that is proven free of collisions, rounding included: the step to the positions that
  /// `step_towards` computes is_step_collision_free. Certificates do not change the answer. Cost: that of a
  /// step, and of a second one when the share is below 1; seldom of more.
  [[nodiscard]] Result<StepSize> collision_free_step_size(std::span<const double> x0,
                                                          std::span<const double> x1,
                                                          double min_distance = 0);

  /// `shares`: one in [0,1] for each vertex, so that one contact does not stop a scene. Moving vertices that
  /// collide on the way, directly or by others, are an island and go one share, all others 1. Proven: on the
  /// way to what `step_towards` computes no relevant pair collides, but those that collide or are undecided
  /// at rest in x0; their islands have the share 0. No gap is rescaled. Cost: two complete steps, and one for
  /// each time that islands meet; after 32 times all go one share.
  [[nodiscard]] Result<void> collision_free_step_sizes(std::span<const double> x0, std::span<const double> x1,
                                                       std::vector<double>& shares, double min_distance = 0);

  /// Yes: proven that no relevant pair collides. No: one does within the tolerance, or is undecided.
  Verdict is_step_collision_free(std::span<const double> x0, std::span<const double> x1,
                                 double min_distance = 0);

  /// Every relevant pair whose distance is <= inflation at some time of the step, and others: all pairs whose
  /// moving boxes no axis separates by more than the inflation, on the same side at both ends. The result
  /// does not depend on earlier calls. (ipc-toolkit inflates each of two boxes: its radius is half of this.)
  /// Cost: later calls rebuild the lists of leaves that moved relative to each other, and test what is
  /// listed.
  [[nodiscard]] Result<void> candidates(std::span<const double> x0, std::span<const double> x1,
                                        double inflation, Candidates& out);
  [[nodiscard]] Result<void> candidates(std::span<const double> x, double inflation, Candidates& out);

  /// All relevant pairs whose distance is <= `distance` (>= 0; infinity: all), each by its closest features,
  /// and those once. Proven: none is missing, rounding included. A pair that is farther away may be listed,
  /// too, where features are so much closer than large that rounding leaves no proof: its barrier is 0.
  /// `active`: none, or vertex_count numbers; pairs none of whose closest features' vertices has one that is
  /// not 0 are left out. The order depends on the mesh and the pose alone. Error: a distance that is negative
  /// or NaN. Cost: about as candidates().
  [[nodiscard]] Result<void> close_pairs(std::span<const double> x, double distance,
                                         std::vector<ClosePair>& out,
                                         std::span<const std::uint8_t> active = {});

  /// Whether two elements (faces, codimensional edges, codimensional points) have a point in common, decided
  /// exactly. For neighbors see StepChecker::check_static; codimensional elements with a common vertex never
  /// count. The filter is called for all pairs of their vertices that are not both common to them; of two
  /// faces with the same three vertices, for all pairs of different ones.
  Verdict has_intersections(std::span<const double> x);

  /// The smallest distance of all relevant pairs if it is <= bound (>= 0, or infinity), else infinity. Mesh
  /// units. Its error is less than 64 units in the last place of the pair's largest coordinate difference;
  /// for very thin triangles and nearly parallel edges it may be too large by up to 2^-26 of that. A face
  /// that an edge pierces is not at distance 0: see has_intersections. Cost: as candidates() with the answer
  /// as inflation.
  [[nodiscard]] Result<double> minimum_distance(std::span<const double> x, double bound);

  /// Of the last call.
  const Work& work() const;
  const StageTimes& milliseconds() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// The positions at a share of the step, as collision_free_step_size assumes them: x0 + share * (x1 - x0),
/// one rounding per operation, and x1 itself for 1. Precondition: equal sizes. `out` may be x0 or x1.
void step_towards(std::span<const double> x0, std::span<const double> x1, double share,
                  std::span<double> out);
/// With a share for each vertex.
void step_towards(std::span<const double> x0, std::span<const double> x1, std::span<const double> shares,
                  std::span<double> out);

}  // namespace foldproof
