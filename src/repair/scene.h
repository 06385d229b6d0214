/// What is repaired, as one mesh: the objects' vertices, faces and edges one after the other.
#pragma once

#include <tuple>

#include "foldproof/eigen.h"
#include "foldproof/repair.h"

namespace foldproof::inline internal {

/// Lists of numbers, one per vertex.
struct Lists {
  std::vector<std::size_t> begin;  ///< And an end.
  std::vector<Index> items;
  std::span<const Index> operator[](Index i) const {
    return std::span(items).subspan(begin[i], begin[i + 1] - begin[i]);
  }
};

/// A vertex and a face, or two edges, by vertices of the scene: v f0 f1 f2, or a0 a1 b0 b1. A line stands for
/// the face (a, b, b), a point for (p, p, p).
struct FeaturePair {
  bool edges;
  std::array<Index, 4> v;
  // Not <=>, which arrays of Emscripten's standard library lack.
  bool operator<(const FeaturePair& other) const {
    return std::tie(edges, v) < std::tie(other.edges, other.v);
  }
  bool operator==(const FeaturePair&) const = default;
  double distance(const FourPoints& x) const {
    return (edges ? edge_edge_closest : vertex_face_closest)(x).distance;
  }
};

struct RepairSceneObject {
  Index vertices, triangles;  ///< Where they begin in the scene.
};

class RepairScene {
 public:
  static Result<RepairScene> make(const RepairInput& input);

  Index vertex_count() const { return static_cast<Index>(movable_.size()); }
  std::size_t size() const { return 3 * movable_.size(); }
  /// Faces, lines and points, by vertices of the scene.
  std::span<const Triangle> triangles() const { return triangles_; }
  const Triangle& triangle(Index object, Index triangle) const {
    return triangles_[begin_[object].triangles + std::size_t{triangle}];
  }
  std::span<const Edge> edges() const { return edges_; }
  const Lists& neighbors() const { return neighbors_; }
  /// Whether triangles name it and it may move.
  bool is_movable(Index v) const { return movable_[v] != 0; }
  std::span<const std::uint8_t> movable() const { return movable_; }
  const std::vector<Object>& objects() const { return objects_; }
  std::vector<const Topology*> topologies() const;
  const Parts& parts() const { return parts_; }
  /// For errors.
  const std::string& name(Index object) const { return names_[object]; }
  /// The caller's; null: none.
  const std::shared_ptr<const PairFilter>& given_filter() const { return given_filter_; }
  /// The caller's, and pairs that cannot move are ignored.
  const std::shared_ptr<const PairFilter>& filter() const { return filter_; }
  /// The caller's, and all other pairs are ignored; null: everything may move.
  const std::shared_ptr<const PairFilter>& fixed_filter() const { return fixed_filter_; }
  /// By object; `views` keeps it.
  Positions positions(std::span<const double> x, std::vector<std::span<const double>>& views) const;
  /// Object of a vertex, of a triangle.
  Index object_of_vertex(Index v) const;
  const RepairSceneObject& begin(Index object) const { return begin_[object]; }
  /// Moves copies to the vertices that they were merged into.
  void move_copies(std::span<double> x) const;
  FeaturePair pair_of(const VertexFaceCollision& c) const;
  FeaturePair pair_of(const EdgeEdgeCollision& c) const;
  /// Appends all pairs that collide.
  void pairs_of(const StepResult& step, std::vector<FeaturePair>& out) const;

 private:
  std::vector<Object> objects_;
  std::vector<RepairSceneObject> begin_;  // one more at the end
  std::vector<Triangle> triangles_;
  std::vector<Edge> edges_;
  std::vector<std::uint8_t> movable_;
  std::vector<std::pair<Index, Index>> copies_;  // and the vertices that they were merged into
  Lists neighbors_;
  Parts parts_;
  std::vector<std::string> names_;
  std::shared_ptr<const PairFilter> given_filter_, filter_, fixed_filter_;
};

/// Asks StepChecker about straight ways between poses of the scene.
class Prover {
 public:
  Prover(const RepairScene& scene, std::shared_ptr<const PairFilter> filter, double thickness)
      : scene_(&scene), checker_(scene.objects(), std::move(filter)) {
    settings_.thickness = thickness;
    settings_.look_ahead = false;  // ways of one frame do not continue each other
  }
  void set_thickness(double thickness) { settings_.thickness = thickness; }
  /// The pairs that collide on the way, at most StepSettings::max_listed.
  Result<const StepResult*> check(std::span<const double> x0, std::span<const double> x1);
  /// Appends the pairs that come within a distance on the way.
  Result<void> find_near(std::span<const double> x0, std::span<const double> x1, double distance,
                         std::vector<FeaturePair>& out);
  /// Pairs of triangles that cross.
  Result<const StaticResult*> check_pose(std::span<const double> x);
  /// Whether nothing touches: nothing crosses, nothing is within the thickness.
  Result<bool> is_free(std::span<const double> x);

 private:
  const RepairScene* scene_;
  StepChecker checker_;
  StepSettings settings_;
  StepResult step_;
  StaticResult pose_;
  std::vector<std::span<const double>> from_, to_;
};

inline Vec3 at(std::span<const double> x, Index v) { return Vec3::load(&x[3 * std::size_t{v}]); }
inline void put(std::span<double> x, Index v, const Vec3& p) { p.store(&x[3 * std::size_t{v}]); }
inline FourPoints points_of(std::span<const double> x, const std::array<Index, 4>& v) {
  return {at(x, v[0]), at(x, v[1]), at(x, v[2]), at(x, v[3])};
}

}  // namespace foldproof::inline internal
