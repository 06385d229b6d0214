/// Reduced motion: shapes that are told by a few numbers p, and how far p may go before anything can touch.
///
/// x(p) = mean + basis p. Around a centre in the space of p every pair of nodes of the hierarchy has a ball
/// inside which a proof holds that the two do not touch (paper, Eq. 8; docs/soundness.md, R1-R7). Balls are
/// convex, so a step whose two ends lie inside is free all the way, and no vertex has to be looked at.
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
/// The one way to evaluate it, the same everywhere: per coordinate the sum begins with the mean and adds
/// basis_k * p_k for k = 0, 1, ... in double, one rounding per product and sum. Basis values are those of the
/// subspace rounded to single precision.
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
  /// One vertex by its place in leaf order.
  void vertex(Index place, std::span<const double> p, double (&x)[3]) const {
    const float* row = &basis_[std::size_t{place} * modes_ * 3];
    for (int axis = 0; axis < 3; ++axis) x[axis] = mean_[3 * std::size_t{place} + axis];
    for (Index k = 0; k < modes_; ++k) {
      for (int axis = 0; axis < 3; ++axis) x[axis] += double{row[3 * k + axis]} * p[k];
    }
  }
  /// How a vertex moves with each mode: modes x 3 numbers.
  std::span<const float> row(Index place) const {
    return std::span(basis_).subspan(std::size_t{place} * modes_ * 3, std::size_t{modes_} * 3);
  }
  /// Every vertex of the triangles of a leaf, places in leaf order, ascending.
  std::span<const Index> leaf_vertices(Index leaf) const {
    return std::span(leaf_vertices_).subspan(leaf_begin_[leaf], leaf_begin_[leaf + 1] - leaf_begin_[leaf]);
  }
  /// No coordinate of x(p) is larger, mesh units.
  double reach(std::span<const double> p) const;
  /// What a computed coordinate of x(p) may be off by, mesh units.
  double rounding(std::span<const double> p) const { return rounding_at(reach(p)); }
  /// The same from what reach() gives.
  double rounding_at(double reach) const;

 private:
  std::shared_ptr<const Hierarchy> hierarchy_;
  Index modes_ = 0;
  std::vector<Index> ids_;  // leaf order, then vertices in no triangle
  std::vector<double> mean_, deviations_;
  std::vector<float> basis_;     // [vertex][mode][axis]
  std::vector<double> largest_;  // per mode: the largest basis value
  double largest_mean_ = 0;
  std::vector<Index> leaf_begin_, leaf_vertices_;
};

/// A point of the space of p that balls are centred at.
struct ReducedCentre {
  std::vector<double> p;
  /// How large balls need be, in the norm of ReducedMotion::deviations; beyond it nothing is refined. 0:
  /// sqrt(modes) + 4, which nearly all of a normal distribution around the mean keeps to.
  double reach = 0;
};

struct ReducedSettings {
  /// Mesh units. What is proven apart is proven farther apart than this, so it is also the largest thickness
  /// plus tolerance (rounding included) of queries that the balls can serve. 0: 2^-24 of the mesh's size.
  double clearance = 0;
  Index pairs_per_leaf = 16;       ///< Bounds the pairs of nodes that get balls: so many per leaf.
  Index most_triangles = 120'000;  ///< Of a patch that is proven as a whole.
};

struct ReducedHooks {
  std::function<void(double)> progress = {};  ///< Called with the share of the work that is done, at most.
  const std::atomic<bool>* cancel = nullptr;  ///< true ends the work in an error.
};

/// Two leaves, or one with itself, that no ball around a centre proves apart: they touch there, or come
/// nearer to each other than the clearance.
struct LeftOut {
  Index leaf_a, leaf_b;
  bool touches;       ///< In the centre's pose two of their triangles meet beyond what they share.
  double radius = 0;  ///< Within which they are proven apart nevertheless.
};

/// How far a centre reaches, and without which pairs of leaves.
struct CertifiedRadius {
  double radius;
  std::vector<LeftOut> left_out;  ///< Ascending.
};

/// What is known of a step from its ends in the space of p alone.
enum class ReducedProof : std::uint8_t {
  Open,         ///< Nothing.
  FreeButLeft,  ///< No two features touch, but for those of ReducedShape::always_open().
  Free,         ///< No two features without a common vertex touch.
};

/// Balls for all pairs of nodes that matter. Immutable; thousands of instances and any number of threads may
/// share one.
class ReducedShape {
 public:
  /// At least one centre. Error: a centre of wrong size or with numbers that are not finite, no centre,
  /// cancelled. The same input gives the same shape for any number of threads. Cost: about 20 us per triangle
  /// and centre, spread over all threads.
  static Result<ReducedShape> build(std::shared_ptr<const ReducedMotion> motion,
                                    std::vector<ReducedCentre> centres, const ReducedSettings& settings = {},
                                    const ReducedHooks& hooks = {});

  const std::shared_ptr<const ReducedMotion>& motion() const;
  std::span<const ReducedCentre> centres() const;
  double clearance() const;

  /// The certified radius around a centre: no p nearer to it makes two features touch, but for those of
  /// left_out(centre). At most the centre's reach is looked for.
  double radius(Index centre) const;
  /// The norm of p - centre, rounded up.
  double distance(Index centre, std::span<const double> p) const;
  /// What radius() leaves out. Ascending.
  std::span<const LeftOut> left_out(Index centre) const;
  /// The same when pairs of leaves that reach less far than `at_least` are left out as well, so that a few
  /// that nearly touch do not speak for the whole shape. More than `at_least` where that is all that limits.
  /// Cost: O(pairs of nodes).
  CertifiedRadius certified(Index centre, double at_least) const;
  /// Pairs of leaves that no centre proves; queries always test them.
  std::span<const std::array<Index, 2>> always_open() const;

  /// Scratch of one caller.
  struct Scratch {
    std::vector<Index> stack;
    std::vector<std::array<Index, 2>> open;  ///< Pairs of nodes of the hierarchy.
    std::uint64_t visits = 0;                ///< Nodes of the pair tree looked at in the last call.
    std::uint64_t proven = 0;                ///< How many of them a ball proved.
  };
  /// Whether a step from p0 to p1 is free, all vertices going straight. Numbers that are not finite, or too
  /// few of them, prove nothing. Cost: two norms, then two comparisons per pair of nodes that is looked at: a
  /// single one inside a root's ball. Allocates nothing once the scratch has its size.
  ReducedProof proven_free(std::span<const double> p0, std::span<const double> p1, Scratch& scratch) const;
  /// The pairs of nodes that stay open, in scratch.open, always_open() not among them; the same answer.
  ReducedProof find_open(std::span<const double> p0, std::span<const double> p1, Scratch& scratch) const;

  struct Impl;  ///< For the library itself: src/reduced/shape.h.
  const Impl& impl() const { return *impl_; }

 private:
  std::shared_ptr<const Impl> impl_;
};

/// One object of a reduced motion at one end of a step: its vertices are at rotation x(p) + translation.
///
/// Evaluated in double, one rounding per operation: coordinate i is ((r_i0 x + r_i1 y) + r_i2 z) + t_i with
/// x, y, z from ReducedMotion. Without a placement that is x(p) itself.
struct ReducedPose {
  std::span<const double> p;  ///< One number per mode.
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Vec3 translation = Vec3::Zero();
};

/// All vertices of a placed shape, by the user's ids: 3 * vertex_count numbers. Precondition: sizes fit.
void place_vertices(const ReducedMotion& motion, const ReducedPose& pose, std::span<double> out);

/// Answers queries on objects that move in reduced coordinates. It looks at no vertex where nothing is near:
/// its cost does not depend on the size of the meshes. An object so far from every centre that balls leave
/// more than two pairs of nodes open per leaf is looked at as StepChecker does, with charts, once its
/// vertices have been computed. Owns scratch of the meshes' size; a second step of the same kind and size
/// allocates nothing, where charts are made, once no more are needed. One checker per thread.
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

  /// What StepChecker::check answers, bit for bit, when it is given the vertices of all objects at both ends
  /// (place_vertices) and the tolerance of this answer. The automatic tolerance is 2^-30 of a box that holds
  /// everything but is found without looking at vertices, hence up to a few times larger. All vertices go
  /// straight between the ends, also where rotations differ. Balls serve objects whose rotation is the same
  /// at both ends, and thickness plus tolerance up to the shape's clearance; what is beyond goes by boxes.
  /// StepSettings::explain has no effect. Error: wrong sizes, numbers that are not finite, a rotation that is
  /// none, charts of another hierarchy.
  Result<void> check(std::span<const ReducedPose> begin, std::span<const ReducedPose> end,
                     const StepSettings& settings, StepResult& out);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// The share of a normal distribution with the modes' deviations that lies within a radius of its mean: the
/// chi-square distribution with that many degrees of freedom, at radius^2.
double normal_share(double radius, Index modes);

}  // namespace foldproof
