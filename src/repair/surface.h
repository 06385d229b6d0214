/// How a surface resists a correction: each vertex holds to its place, and its neighborhood to its shape. The
/// energy of positions x, relative to target positions t, is
///   1/2 sum_i a_i |x_i - t_i|^2  +  falloff^2 / 2 sum_ij w_ij |(x_i - x_j) - R_i (t_i - t_j)|^2
/// with areas a_i and cotangent weights w_ij relative to the mean area, and rotations R_i that minimize it
/// (Sorkine and Alexa, As-rigid-as-possible surface modeling, 2007).
#pragma once

#include <Eigen/Core>

#include "repair/barrier.h"

namespace foldproof::inline internal {

/// Where the linear solver ends: at changes below this, or below this share of what is asked for at first.
struct LinearTolerance {
  double change, share;
};

class ElasticSurface {
 public:
  /// `falloff`: how far a correction spreads along the surface, mesh units. `rest`: gives areas and weights.
  ElasticSurface(const RepairScene& scene, std::span<const double> rest, double falloff);

  /// Only these vertices are unknown; all others are at the target. Ascending.
  void set_active(std::vector<Index> active);
  std::span<const Index> active() const { return active_; }

  /// Fits the rotations of active vertices to x.
  void fit_rotations(std::span<const double> x, std::span<const double> target);
  /// Takes the corrections of x, a pose near the target `from`, along to another target: each turns as the
  /// surface around it does. No vertex is active afterwards.
  void carry(std::span<const double> from, std::span<const double> to, std::span<double> x);
  /// Energy of x without the part that no x changes, with rotations as fitted last, and of the barrier.
  double energy(std::span<const double> x, std::span<const double> target, std::span<const NearPair> pairs,
                double stiffness) const;
  /// One step of Newton's method, with rotations as fitted last and normals as in `pairs`: the minimum of the
  /// energy's quadratic model, by conjugate gradients until no vertex is farther than about `tolerance` from
  /// it. Fills `out` with the target, active vertices with the minimum.
  void minimize(std::span<const double> x, std::span<const double> target, std::span<const NearPair> pairs,
                double stiffness, const LinearTolerance& tolerance, std::span<double> out);

 private:
  struct Neighbor {
    Index vertex;
    double weight;  // falloff^2 w_ij
  };
  // What a pair adds to the system: curvature (w n)(w n)^T.
  struct Contact {
    double curvature;
    Vec3 normal;
    std::array<Index, 4> vertices;
    std::array<double, 4> w;  // 0 where it is not active
  };
  std::span<const Neighbor> neighbors(Index v) const {
    return std::span(neighbors_).subspan(begin_[v], begin_[v + std::size_t{1}] - begin_[v]);
  }
  void build_contacts(std::span<const double> x, std::span<const double> target,
                      std::span<const NearPair> pairs, double stiffness);
  template <class Value>
  Vec3 row(Index v, const Value& value) const;
  void multiply(std::span<const Vec3> u, std::span<Vec3> out) const;
  double follow_direction(double step, double rz, double& largest);

  std::vector<double> diagonal_;  // the area, and all weights
  std::vector<std::size_t> begin_;
  std::vector<Neighbor> neighbors_;
  std::vector<Index> active_;
  // All below by vertex. Of those that are not active, these are 0:
  std::vector<std::uint8_t> is_active_;
  std::vector<Eigen::Matrix3d> rotations_;  // minus the identity
  std::vector<Vec3> d_, p_;
  // and these are not used:
  std::vector<Vec3> turned_;              // right-hand side of the rotations
  std::vector<Eigen::Matrix3d> inverse_;  // of the diagonal blocks
  std::vector<Vec3> rhs_, r_, z_, q_;
  std::vector<Contact> contacts_;
};

/// Lengths of a scene that do not depend on where it is and how it is turned.
struct SceneSize {
  double edge = 0;  ///< The median length of edges that may move.
  double size = 0;  ///< Twice the largest distance of what may move from its middle.
};
SceneSize scene_size(const RepairScene& scene, std::span<const double> x);

}  // namespace foldproof::inline internal
