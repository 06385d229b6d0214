/// Solvers: what an implicit solver asks of collision detection while it takes its Newton steps.
///
/// The terms are those of incremental potential contact and the conventions those of ipc-toolkit: a collision
/// mesh with edges and faces as index matrices, edges without a face and points without an edge, a filter of
/// which vertices may collide, candidates by index for barriers, step sizes for line searches
/// (docs/solvers.md maps the names).
#pragma once

#include <functional>

#include "foldproof/check.h"

namespace foldproof {

/// Which pairs of vertices may collide. A pair of features counts when at least one vertex of the one may
/// collide with at least one vertex of the other, as in ipc-toolkit. Immutable, cheap to copy.
class CollisionFilter {
 public:
  /// All may.
  CollisionFilter() = default;
  /// Those for which the function says so. It is symmetric, does not throw, and is called by several threads
  /// at once, a few times per pair of features whose boxes come near each other.
  explicit CollisionFilter(std::function<bool(Index, Index)> can_collide);
  /// The cheap form. `group_of_vertex`: any small numbers, one per vertex. Two vertices may collide unless
  /// their groups, in either order, stand in `apart`; {g, g} keeps the group g from colliding with itself.
  /// Memory: a bit per pair of groups. Error: a group in `apart` that no vertex has; a group number above
  /// 10,000.
  static Result<CollisionFilter> groups(std::vector<Index> group_of_vertex,
                                        std::span<const std::array<Index, 2>> apart);
  /// Patches that collide with each other and never with themselves.
  static Result<CollisionFilter> patches(std::vector<Index> patch_of_vertex);

  bool all_may() const { return groups_ == nullptr && can_collide_ == nullptr; }
  bool operator()(Index i, Index j) const;
  /// Whether any vertex of `a` and any of `b` that are not the same may collide.
  bool any(std::span<const Index> a, std::span<const Index> b) const;
  /// Number of vertices that the filter was made for; kNoIndex when it is for any number.
  Index vertex_count() const;

 private:
  struct Groups;
  std::shared_ptr<const Groups> groups_;
  std::shared_ptr<const std::function<bool(Index, Index)>> can_collide_;
};

struct CollisionMeshSettings {
  CollisionFilter filter;
  /// Vertices in no edge and no face are points that collide. Off: they take no part, as the inside of a
  /// volume should.
  bool points = true;
  HierarchySettings hierarchy;
};

/// What may collide: faces, edges without a face, points without either. Immutable once made; any number of
/// checkers may share it.
class CollisionMesh {
 public:
  /// `rest_positions`: vertex_count x 3, row-major, the pose that decides how the hierarchy is split (any
  /// does). `edges`: two vertex ids each, in either order. `faces`: three vertex ids each. Edges of faces
  /// that are not among `edges` are appended behind them, so an empty matrix, or one with only the
  /// codimensional edges, will do. Error: an id out of range, an edge twice or from a vertex to itself,
  /// nothing that could collide, a filter for another number of vertices, positions that are not finite.
  /// Cost: as Hierarchy::build.
  static Result<CollisionMesh> make(std::span<const double> rest_positions, std::vector<Edge> edges,
                                    std::vector<Triangle> faces, CollisionMeshSettings settings = {});

  Index vertex_count() const { return hierarchy_->topology().vertex_count(); }
  /// As given, in the order and direction given; then the edges of faces that were missing, the smaller
  /// vertex first, in lexicographic order.
  std::span<const Edge> edges() const { return edges_; }
  std::span<const Triangle> faces() const { return hierarchy_->topology().triangles().first(face_count_); }
  /// Edges in no face, ascending.
  std::span<const Index> codim_edges() const { return codim_edges_; }
  /// Vertices in no edge and no face, ascending; empty when CollisionMeshSettings::points is off.
  std::span<const Index> codim_points() const { return codim_points_; }
  const CollisionFilter& filter() const { return filter_; }

  /// One hierarchy over everything: triangles are the faces, then each edge of codim_edges() as (a, b, b),
  /// then each point of codim_points() as (p, p, p).
  const std::shared_ptr<const Hierarchy>& hierarchy() const { return hierarchy_; }
  bool is_codim_point(Index vertex) const { return is_point_[vertex] != 0; }
  /// The row of edges() that is the topology's edge number `edge`.
  Index edge_of(Index edge) const { return edge_rows_[edge]; }

 private:
  std::shared_ptr<const Hierarchy> hierarchy_;
  CollisionFilter filter_;
  Index face_count_ = 0;
  std::vector<Edge> edges_;
  std::vector<Index> codim_edges_, codim_points_, edge_rows_;
  std::vector<std::uint8_t> is_point_;
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

/// Pairs of features that may be near each other. No list holds a pair twice; their order is that of the
/// mesh's hierarchy, the same whatever else was asked. Reuse it: its buffers are kept.
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

struct ContactSettings {
  bool certificates = true;  ///< Leave out what certificates prove: less work, no other answers.
  /// Mesh units. Pairs closer than the minimum distance plus this may count as contact. 0: 2^-30 of the
  /// largest side of the box around everything during the step.
  double tolerance = 0;
  /// A step that would come into contact goes this share of the way there, in (0,1]. Below 1 a solver that
  /// starts where its last step ended is never caught at once, as it would be within the tolerance.
  double conservative_rescaling = 0.8;
};

/// Yes, no, or an error. It does not turn into bool, so `if (checker.has_intersections(x))` does not compile:
/// a Result would be true for both answers.
class [[nodiscard]] Verdict {
 public:
  Verdict(Result<bool> answer) : answer_(std::move(answer)) {}
  bool is_yes() const { return answer_.has_value() && *answer_; }
  bool is_no() const { return answer_.has_value() && !*answer_; }
  bool is_error() const { return !answer_.has_value(); }
  /// Precondition: is_error.
  const Error& error() const { return answer_.error(); }
  /// To pass it on.
  const Result<bool>& result() const { return answer_; }

 private:
  Result<bool> answer_;
};

/// How far a step may go.
struct StepSize {
  double share;  ///< In [0,1]; proven free of contact.
  /// What keeps it from going farther.
  enum class Limit : std::uint8_t {
    None,       ///< Nothing: the share is 1.
    Contact,    ///< Contact on the way.
    Start,      ///< x0 itself is in contact, or closer than min_distance plus the tolerance: the share is 0.
    Undecided,  ///< No share could be proven free, though x0 is not shown to be in contact: the share is 0.
                ///< Beside needles, or where the tolerance is not far above the rounding of positions.
  } limit;
};
inline constexpr std::array<const char*, 4> kStepLimitNames{"none", "contact", "start", "undecided"};

/// Answers a solver's questions about one collision mesh. It keeps its front, its charts, its lists of
/// candidates and its scratch from call to call, so asking about the same x0 and many x1 is cheap, as it is
/// about poses that follow each other; and calls of the same kind and size allocate nothing. One checker per
/// thread; threads inside come from oneTBB.
///
/// Positions are vertex_count x 3, row-major, mesh units; during a step vertices go straight from x0 to x1.
/// *Contact* of a pair that counts: at some time of the step its distance is <= min_distance (0: it touches).
/// The pairs that count, if the filter says so and they have no vertex in common: a vertex and a face, two
/// edges, a codimensional edge and a codimensional point, two codimensional points. All calls: an error for
/// wrong sizes, coordinates that are not finite, a length that is none. Soundness: docs/soundness.md,
/// "Solvers".
class ContactChecker {
 public:
  explicit ContactChecker(std::shared_ptr<const CollisionMesh> mesh, const ContactSettings& settings = {});
  ~ContactChecker();
  ContactChecker(ContactChecker&&) noexcept;
  ContactChecker& operator=(ContactChecker&&) noexcept;

  const CollisionMesh& mesh() const;
  ContactSettings& settings();

  /// A share s in [0,1] of the step that is proven free of contact, rounding included: what `step_towards`
  /// gives for s has is_step_collision_free. The same whatever certificates prove. Cost: that of a step, and
  /// of a second one when s < 1.
  Result<StepSize> collision_free_step_size(std::span<const double> x0, std::span<const double> x1,
                                            double min_distance = 0);

  /// Yes: proven that no pair that counts comes into contact. No: one does, comes within the tolerance of it,
  /// or could not be settled.
  Verdict is_step_collision_free(std::span<const double> x0, std::span<const double> x1,
                                 double min_distance = 0);

  /// Every pair that counts and whose distance is <= inflation at some time of the step, and others: all
  /// whose moving boxes no axis separates by more than that, on the same side at both ends. Which these are
  /// does not depend on earlier calls. (ipc-toolkit inflates each of two boxes: its radius is half of this.)
  /// Cost: once that of looking at all leaves; then what moved relative to its neighbours is listed anew, and
  /// pairs that are listed, with a little room, are tested.
  Result<void> candidates(std::span<const double> x0, std::span<const double> x1, double inflation,
                          Candidates& out);
  /// The same in one pose.
  Result<void> candidates(std::span<const double> x, double inflation, Candidates& out);

  /// Whether two elements (faces, codimensional edges, codimensional points) have a point in common, decided
  /// exactly. Neighbours: as StepChecker::check_static, but codimensional elements with a common vertex never
  /// do. The filter is asked about all pairs of their vertices that are not both common to them.
  Verdict has_intersections(std::span<const double> x);

  /// The least distance of all pairs that count, if it is <= bound; else infinity. Mesh units; too small by
  /// less than 64 units in the last place of the largest coordinate difference of the pair, and too large by
  /// less than that or, beside needles and edges that are nearly parallel, 2^-26 of it. A face pierced by an
  /// edge is not at distance 0: see has_intersections. Cost: as candidates with the answer for inflation.
  Result<double> minimum_distance(std::span<const double> x, double bound);

  /// Of the last call.
  const Work& work() const;
  const StageTimes& milliseconds() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// A share of the way, as collision_free_step_size means it: x0 + share * (x1 - x0), one rounding per
/// operation, and x1 itself for 1. Precondition: equal sizes. `out` may be x0 or x1.
void step_towards(std::span<const double> x0, std::span<const double> x1, double share,
                  std::span<double> out);

}  // namespace foldproof
