/// Reduced motion: shapes described by a few coordinates p, and how far p may move before anything can touch.
///
/// x(p) = mean + basis p. Around a center in the space of p every pair of nodes of the hierarchy has a ball.
/// While p stays inside it, the two nodes are proven not to touch (paper, Eq. 8; docs/soundness.md, R1-R7).
/// Balls are convex, so a step whose two ends lie inside is free throughout, and no vertex is read.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <vector>

#include "foldproof/check.h"
#include "foldproof/statistics.h"

namespace foldproof {

/// x(p) = mean + basis p over a hierarchy, laid out so that single vertices are cheap. Immutable.
///
/// Evaluated the same way everywhere: per coordinate the sum starts with the mean and adds basis_k * p_k for
/// k = 0, 1, ... in double, one rounding per product and sum. Basis values are those of the subspace rounded
/// to single precision.
class ReducedMotion {
 public:
  /// Error: the subspace is not one of this mesh, has no modes or more than 1024, has numbers that are not
  /// finite or deviations that are not positive. Cost: O(vertices * modes), in time and in memory (4 bytes).
  static Result<ReducedMotion> make(std::shared_ptr<const Hierarchy> hierarchy, const Pca& subspace);

  const std::shared_ptr<const Hierarchy>& hierarchy() const { return hierarchy_; }
  Index modes() const { return modes_; }
  /// Of the norm |q| = sqrt(sum (q_k / deviation_k)^2), the Mahalanobis distance.
  std::span<const double> deviations() const { return deviations_; }

  /// All vertices by the user's ids, 3 * vertex_count numbers. Precondition: sizes fit.
  void positions(std::span<const double> p, std::span<double> out) const;
  /// One vertex by its index in leaf order.
  void vertex(Index v, std::span<const double> p, double (&x)[3]) const {
    const float* row = &basis_[std::size_t{v} * modes_ * 3];
    for (int axis = 0; axis < 3; ++axis) x[axis] = mean_[3 * std::size_t{v} + axis];
    for (Index k = 0; k < modes_; ++k) {
      for (int axis = 0; axis < 3; ++axis) x[axis] += double{row[3 * k + axis]} * p[k];
    }
  }
  /// How a vertex moves with each mode: modes x 3 numbers.
  std::span<const float> row(Index v) const {
    return std::span(basis_).subspan(std::size_t{v} * modes_ * 3, std::size_t{modes_} * 3);
  }
  /// The vertices of a leaf's triangles: indices in leaf order, ascending.
  std::span<const Index> leaf_vertices(Index leaf) const {
    return std::span(leaf_vertices_).subspan(leaf_begin_[leaf], leaf_begin_[leaf + 1] - leaf_begin_[leaf]);
  }
  /// An upper bound of the magnitudes of all coordinates of x(p), mesh units.
  double max_coordinate(std::span<const double> p) const;
  /// The rounding error of a computed coordinate of x(p), at most; mesh units.
  double rounding(std::span<const double> p) const { return rounding_at(max_coordinate(p)); }
  /// The same from the value of max_coordinate().
  double rounding_at(double max_coordinate) const;

 private:
  std::shared_ptr<const Hierarchy> hierarchy_;
  Index modes_ = 0;
  std::vector<Index> ids_;  // leaf order, then vertices in no triangle
  std::vector<double> mean_, deviations_;
  std::vector<float> basis_;       // [vertex][mode][axis]
  std::vector<double> max_basis_;  // per mode: the largest magnitude
  double max_mean_ = 0;
  std::vector<Index> leaf_begin_, leaf_vertices_;
};

/// A point in the space of p around which balls are built.
struct ReducedCenter {
  std::vector<double> p;
  /// Balls of this radius are large enough and not refined further; in the norm of ReducedMotion::deviations.
  /// 0: sqrt(modes) + 4, which covers nearly all of a normal distribution around the mean.
  double max_radius = 0;
};

struct ReducedSettings {
  /// Mesh units. Features that are proven separated are farther apart than this. Balls therefore apply to
  /// queries whose thickness plus tolerance (rounding included) is at most this. 0: 2^-24 of the mesh's size.
  double clearance = 0;
  Index pairs_per_leaf = 16;      ///< Limits the pairs of nodes with a ball, per leaf.
  Index max_triangles = 120'000;  ///< Of a patch that a single chart proves.
};

struct ReducedHooks {
  std::function<void(double)> progress = {};  ///< Called with an upper bound of the share of work done.
  const std::atomic<bool>* cancel = nullptr;  ///< true ends the work in an error.
};

/// The balls of a ReducedShape, to keep them: proving them again takes long. Whoever brings them back vouches
/// for them, as no radius can be checked in less time than it takes to prove it (docs/soundness.md, R9).
struct ReducedBalls {
  struct Pair {
    Index a, b;       ///< Nodes of the hierarchy, a == b for one with itself.
    Index begin = 0;  ///< The first of the pairs that it splits into, which are consecutive and follow it.
    Index count = 0;  ///< Of these: 0, 2 or 3.
  };
  double clearance = 0;      ///< Mesh units.
  std::vector<Pair> pairs;   ///< A tree; first the root with itself.
  std::vector<float> radii;  ///< Per pair and center; 0: no ball.
};

/// Two leaves, or one with itself, that no ball around a center certifies: they touch there, or come closer
/// than the clearance.
struct UncertifiedPair {
  Index leaf_a, leaf_b;
  bool touches;       ///< In the center's pose two of their triangles meet beyond what they share.
  double radius = 0;  ///< Within this radius they are proven separated nevertheless.
};

/// The radius that is certified around a center, and the pairs of leaves that it says nothing about.
struct CertifiedRadius {
  double radius;
  std::vector<UncertifiedPair> uncertified;  ///< Ascending.
};

/// What the two ends of a step in the space of p prove.
enum class ReducedProof : std::uint8_t {
  Unproven,               ///< Nothing.
  FreeExceptUncertified,  ///< The same as Free, but for the pairs of ReducedShape::never_certified().
  Free,                   ///< No two features without a common vertex touch.
};

/// Balls for all pairs of nodes that matter. Immutable; thousands of instances and any number of threads may
/// share one.
class ReducedShape {
 public:
  /// At least one center. Error: a center of wrong size or with numbers that are not finite, no center,
  /// cancelled. The same input gives the same shape for any number of threads. Cost: about 20 us per triangle
  /// and center, spread over all threads.
  static Result<ReducedShape> build(std::shared_ptr<const ReducedMotion> motion,
                                    std::vector<ReducedCenter> centers, const ReducedSettings& settings = {},
                                    const ReducedHooks& hooks = {});

  /// The shape that had these balls, in little time. Trusts their radii. Error: as build; balls of another
  /// hierarchy or another number of centers, radii that are no distances.
  static Result<ReducedShape> from_balls(std::shared_ptr<const ReducedMotion> motion,
                                         std::vector<ReducedCenter> centers, ReducedBalls balls);
  const ReducedBalls& balls() const;

  const std::shared_ptr<const ReducedMotion>& motion() const;
  std::span<const ReducedCenter> centers() const;
  double clearance() const;

  /// The certified radius around a center: no p closer to it makes two features touch, except perhaps in the
  /// pairs of uncertified(center). At most the center's max_radius.
  double radius(Index center) const;
  /// The norm of p - center, rounded up.
  double distance(Index center, std::span<const double> p) const;
  /// The pairs that radius() says nothing about. Ascending.
  std::span<const UncertifiedPair> uncertified(Index center) const;
  /// The radius when pairs of leaves with a ball smaller than `at_least` count as uncertified too. So a few
  /// pairs that nearly touch do not limit the radius of the whole shape. The radius may exceed `at_least`,
  /// and be smaller, where pairs of inner nodes limit it. Cost: O(pairs of nodes).
  CertifiedRadius certified(Index center, double at_least) const;
  /// Pairs of leaves that are certified around no center; queries always test them.
  std::span<const std::array<Index, 2>> never_certified() const;

  /// Scratch of one caller.
  struct Scratch {
    std::vector<Index> stack;
    std::vector<std::array<Index, 2>> unproven;  ///< Pairs of nodes of the hierarchy.
    std::uint64_t visited = 0;                   ///< Nodes of the pair tree that the last call visited.
    std::uint64_t proven = 0;                    ///< How many of them a ball proved.
  };
  /// Whether a step from p0 to p1 is free while all vertices move straight, as ReducedMotion::positions
  /// rounds them. Coordinates that are not finite, or too few, prove nothing, nor do those so large that this
  /// rounding exceeds a quarter of the clearance. Cost: two norms per center, then two comparisons per pair
  /// of nodes visited: a single pair inside a root's ball. Allocates nothing once the scratch has its size.
  ReducedProof proven_free(std::span<const double> p0, std::span<const double> p1, Scratch& scratch) const;
  /// The same answer. The pairs of nodes that stay unproven are in scratch.unproven; never_certified() is not
  /// among them. Where no center is near, the pair of the roots stands for all pairs.
  ReducedProof find_unproven(std::span<const double> p0, std::span<const double> p1, Scratch& scratch) const;

  struct Impl;  ///< For the library itself: src/reduced/shape.h.
  const Impl& impl() const { return *impl_; }

 private:
  std::shared_ptr<const Impl> impl_;
};

/// One object of a reduced motion at one end of a step: its vertices are at rotation x(p) + translation.
///
/// Evaluated in double, one rounding per operation: coordinate i is ((r_i0 x + r_i1 y) + r_i2 z) + t_i with
/// x, y, z from ReducedMotion. By default the vertices are at x(p) itself.
struct ReducedPose {
  std::span<const double> p;  ///< One number per mode.
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Vec3 translation = Vec3::Zero();
};

/// All vertices of a posed object, by the user's ids: 3 * vertex_count numbers. Precondition: sizes fit.
void pose_vertices(const ReducedMotion& motion, const ReducedPose& pose, std::span<double> out);

/// Answers queries on objects that move in reduced coordinates. It reads no vertex where nothing is near, so
/// its cost does not depend on the size of the meshes. Far from every center balls may leave more than two
/// pairs of nodes unproven per leaf. Then the object's vertices are computed, and it is checked as
/// StepChecker does, with charts. Owns scratch of the meshes' size. A second step of the same kind and size
/// allocates nothing; with charts, once no more are built. A call that throws, for want of memory, makes the
/// next one start afresh. One checker per thread.
class ReducedChecker {
 public:
  struct Object {
    /// `charts`: trained with the shape's hierarchy; null where there are none.
    Object(std::shared_ptr<const ReducedShape> shape, std::shared_ptr<const ChartLibrary> charts = nullptr)
        : shape(std::move(shape)), charts(std::move(charts)) {}
    std::shared_ptr<const ReducedShape> shape;
    std::shared_ptr<const ChartLibrary> charts;
  };
  explicit ReducedChecker(std::vector<Object> objects);
  ~ReducedChecker();
  ReducedChecker(ReducedChecker&&) noexcept;
  ReducedChecker& operator=(ReducedChecker&&) noexcept;

  /// What StepChecker::check answers, bit for bit, for the vertices of all objects at both ends
  /// (pose_vertices) and the tolerance of this answer. The automatic tolerance is 2^-30 of a box that holds
  /// everything but is found without reading vertices, hence up to a few times larger. All vertices move
  /// straight from start to end, also where rotations differ. Balls apply to objects whose rotation is the
  /// same at both ends, and up to thickness plus tolerance of the shape's clearance; boxes do the rest.
  /// StepSettings::explain has no effect. Error: wrong sizes, numbers that are not finite, a matrix that is
  /// no rotation, charts of another hierarchy.
  [[nodiscard]] Result<void> check(std::span<const ReducedPose> start, std::span<const ReducedPose> end,
                                   const StepSettings& settings, StepResult& out);

 private:
  struct Impl;
  std::vector<Object> objects_;
  std::unique_ptr<Impl> impl_;
};

/// The share of a normal distribution with the modes' deviations that lies within a radius of its mean: the
/// chi-square distribution with that many degrees of freedom, at radius^2.
double normal_share(double radius, Index modes);

}  // namespace foldproof
