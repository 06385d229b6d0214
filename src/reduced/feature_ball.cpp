#include "reduced/feature_ball.h"

#include <algorithm>
#include <cmath>

#include "foldproof/ccd.h"

namespace foldproof::internal {

// The mean motion of the first leaf. Motion that both leaves share does not change their distance.
void FeatureBall::set_reference(const ReducedMotion& motion, std::array<Index, 2> leaves) {
  reference_.assign(motion.modes(), Vec3::Zero());
  const auto vertices = motion.leaf_vertices(leaves[0]);
  for (const Index v : vertices) {
    const auto row = motion.row(v);
    for (Index k = 0; k < motion.modes(); ++k)
      reference_[k] += Vec3(row[3 * k], row[3 * k + 1], row[3 * k + 2]) *
                       (motion.deviations()[k] / static_cast<double>(vertices.size()));
  }
}

FeatureBall::Feature FeatureBall::feature(const ReducedMotion& motion, const CenterPose& pose,
                                          std::span<const Index> v) const {
  Feature f;
  f.count = static_cast<int>(v.size());
  f.low = Vec3::Constant(std::numeric_limits<double>::infinity());
  f.high = -f.low;
  f.growth = Vec3::Zero();
  for (std::size_t i = 0; i < v.size(); ++i) {
    f.v[i] = v[i];
    f.low = f.low.cwiseMin(pose.at(v[i]));
    f.high = f.high.cwiseMax(pose.at(v[i]));
    const auto row = motion.row(v[i]);
    Vec3 square = Vec3::Zero();
    double row_size = 0;
    for (Index k = 0; k < motion.modes(); ++k) {
      const Vec3 own = Vec3(row[3 * k], row[3 * k + 1], row[3 * k + 2]) * motion.deviations()[k];
      const Vec3 relative = own - reference_[k];
      square += relative.cwiseProduct(relative);
      row_size += own.squaredNorm() + reference_[k].squaredNorm();
    }
    // R5: rounding of the differences.
    const double error = kSumError * std::sqrt(row_size);
    const Vec3 growth(std::sqrt(square.x()), std::sqrt(square.y()), std::sqrt(square.z()));
    f.growth = f.growth.cwiseMax(growth * (1 + kSumError) + Vec3::Constant(error));
  }
  return f;
}

void FeatureBall::read(const ReducedMotion& motion, const CenterPose& pose, Index leaf, Leaf& out) const {
  const Hierarchy& h = *motion.hierarchy();
  const auto &begin = h.leaves()[leaf], &end = h.leaves()[leaf + 1];
  out.vertices.clear();
  out.edges.clear();
  out.triangles.clear();
  for (Index v = begin.vertices; v < end.vertices; ++v)
    out.vertices.push_back(feature(motion, pose, {&v, 1}));
  for (Index e = begin.edges; e < end.edges; ++e) out.edges.push_back(feature(motion, pose, h.edges()[e]));
  for (Index t = begin.triangles; t < end.triangles; ++t)
    out.triangles.push_back(feature(motion, pose, h.triangles()[t]));
}

// A radius within which the boxes stay separated, by the best axis. 0: they are not separated at the center.
double FeatureBall::radius_by_boxes(const Feature& a, const Feature& b, double error) const {
  double best = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double separation = std::max(a.low[axis] - b.high[axis], b.low[axis] - a.high[axis]);
    const double growth = a.growth[axis] + b.growth[axis] + 1e-300;
    best = std::max(best, (separation - gap_ * (1 + kSumError) - error) / growth);
  }
  return best * (1 - kRadiusMargin);
}

// For a vertex and a face, or two edges: the plane between their closest points has the widest gap.
TwoSets FeatureBall::sets_of(const CenterPose& pose, const Feature& a, const Feature& b) {
  const std::span<const Index> of_a(a.v.data(), static_cast<std::size_t>(a.count));
  const std::span<const Index> of_b(b.v.data(), static_cast<std::size_t>(b.count));
  FourPoints x;
  std::size_t k = 0;
  for (const auto set : {of_a, of_b}) {
    for (const Index v : set) x[k++] = pose.at(v);
  }
  return {of_a, of_b, (a.count == 1 ? vertex_face_closest : edge_edge_closest)(x).difference};
}

// Takes the pairs with the smallest radius by boxes first, so that boxes decide most of the others.
double FeatureBall::min_radius(const ReducedMotion& motion, const CenterPose& pose,
                               std::span<const Feature> a, std::span<const Feature> b, double smallest) {
  const bool is_same = a.data() == b.data();
  const double error = kSumError * pose.max_coordinate + 4 * pose.rounding;
  candidates_.clear();
  for (Index i = 0; i < a.size(); ++i) {
    for (Index j = is_same ? i + 1 : 0; j < b.size(); ++j) {
      const auto end = a[i].v.begin() + a[i].count;
      const bool incident = std::any_of(b[j].v.begin(), b[j].v.begin() + b[j].count,
                                        [&](Index v) { return std::find(a[i].v.begin(), end, v) != end; });
      if (incident) continue;
      const double radius = radius_by_boxes(a[i], b[j], error);
      if (radius < smallest) candidates_.push_back({radius, i, j});
    }
  }
  std::sort(candidates_.begin(), candidates_.end(), [](const Candidate& x, const Candidate& y) {
    return std::tuple(x.radius, x.a, x.b) < std::tuple(y.radius, y.a, y.b);
  });
  for (const Candidate& c : candidates_) {
    if (c.radius >= smallest || smallest <= known_) break;
    const double by_plane = plane_.radius(motion, pose, sets_of(pose, a[c.a], b[c.b]), gap_, smallest);
    smallest = std::min(smallest, std::max(c.radius, by_plane));
  }
  return smallest;
}

double FeatureBall::radius(const ReducedMotion& motion, const CenterPose& pose, std::array<Index, 2> leaves,
                           double gap, double known, double max_radius) {
  gap_ = gap;
  known_ = known;
  set_reference(motion, leaves);
  read(motion, pose, leaves[0], leaf_a_);
  const bool is_same = leaves[0] == leaves[1];
  if (!is_same) read(motion, pose, leaves[1], leaf_b_);
  const Leaf& other = is_same ? leaf_a_ : leaf_b_;
  double radius = min_radius(motion, pose, leaf_a_.vertices, other.triangles, max_radius);
  if (!is_same) radius = min_radius(motion, pose, other.vertices, leaf_a_.triangles, radius);
  return min_radius(motion, pose, leaf_a_.edges, other.edges, radius);
}

}  // namespace foldproof::internal
