#include "reduced/feature_ball.h"

#include <algorithm>
#include <cmath>

#include "foldproof/ccd.h"

namespace foldproof {

// The mean motion of the first leaf: what both have in common parts nothing.
void FeatureBall::set_reference(const ReducedMotion& motion, std::array<Index, 2> leaves) {
  reference_.assign(motion.modes(), Vec3::Zero());
  const auto places = motion.leaf_vertices(leaves[0]);
  for (const Index v : places) {
    const auto row = motion.row(v);
    for (Index k = 0; k < motion.modes(); ++k)
      reference_[k] += Vec3(row[3 * k], row[3 * k + 1], row[3 * k + 2]) *
                       (motion.deviations()[k] / static_cast<double>(places.size()));
  }
}

FeatureBall::Feature FeatureBall::feature(const ReducedMotion& motion, const CentrePose& pose,
                                          std::span<const Index> v) const {
  Feature f;
  f.count = static_cast<int>(v.size());
  f.low = Vec3::Constant(std::numeric_limits<double>::infinity());
  f.high = -f.low;
  f.grow = Vec3::Zero();
  for (std::size_t i = 0; i < v.size(); ++i) {
    f.v[i] = v[i];
    f.low = f.low.cwiseMin(pose.at(v[i]));
    f.high = f.high.cwiseMax(pose.at(v[i]));
    const auto row = motion.row(v[i]);
    Vec3 square = Vec3::Zero();
    double row_size = 0;
    for (Index k = 0; k < motion.modes(); ++k) {
      const Vec3 own = Vec3(row[3 * k], row[3 * k + 1], row[3 * k + 2]) * motion.deviations()[k];
      square += (own - reference_[k]).cwiseAbs2();
      row_size += own.squaredNorm() + reference_[k].squaredNorm();
    }
    // R5: what the differences may be off by.
    const Vec3 error = Vec3::Constant(kSumError * std::sqrt(row_size));
    f.grow = f.grow.cwiseMax(square.cwiseSqrt() * (1 + kSumError) + error);
  }
  return f;
}

void FeatureBall::read(const ReducedMotion& motion, const CentrePose& pose, Index leaf, Leaf& out) const {
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

// At least this radius, by the axis whose gap lasts longest. 0: the boxes are not apart.
double FeatureBall::by_boxes(const Feature& a, const Feature& b, double error) const {
  double best = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double apart = std::max(a.low[axis] - b.high[axis], b.low[axis] - a.high[axis]);
    const double grow = a.grow[axis] + b.grow[axis] + 1e-300;
    best = std::max(best, (apart - gap_ * (1 + kSumError) - error) / grow);
  }
  return best * (1 - kRadiusMargin);
}

// Of a vertex and a face, or two edges; the plane between their closest points leaves the widest gap.
TwoSets FeatureBall::sets_of(const CentrePose& pose, const Feature& a, const Feature& b) {
  const std::span<const Index> of_a(a.v.data(), static_cast<std::size_t>(a.count));
  const std::span<const Index> of_b(b.v.data(), static_cast<std::size_t>(b.count));
  FourPoints x;
  std::size_t k = 0;
  for (const auto set : {of_a, of_b}) {
    for (const Index v : set) x[k++] = pose.at(v);
  }
  return {of_a, of_b, (a.count == 1 ? vertex_face_closest : edge_edge_closest)(x).difference};
}

// The least likely pairs first, so that boxes are enough for most of the others.
double FeatureBall::smallest(const ReducedMotion& motion, const CentrePose& pose, std::span<const Feature> a,
                             std::span<const Feature> b, double least) {
  const bool is_same = a.data() == b.data();
  const double error = kSumError * pose.largest + 4 * pose.rounding;
  candidates_.clear();
  for (Index i = 0; i < a.size(); ++i) {
    for (Index j = is_same ? i + 1 : 0; j < b.size(); ++j) {
      const auto end = a[i].v.begin() + a[i].count;
      const bool incident = std::any_of(b[j].v.begin(), b[j].v.begin() + b[j].count,
                                        [&](Index v) { return std::find(a[i].v.begin(), end, v) != end; });
      if (incident) continue;
      const double radius = by_boxes(a[i], b[j], error);
      if (radius < least) candidates_.push_back({radius, i, j});
    }
  }
  std::sort(candidates_.begin(), candidates_.end(), [](const Candidate& x, const Candidate& y) {
    return std::tuple(x.radius, x.a, x.b) < std::tuple(y.radius, y.a, y.b);
  });
  for (const Candidate& c : candidates_) {
    if (c.radius >= least || least <= at_least_) break;
    const double by_plane = plane_.radius(motion, pose, sets_of(pose, a[c.a], b[c.b]), gap_, least);
    least = std::min(least, std::max(c.radius, by_plane));
  }
  return least;
}

double FeatureBall::radius(const ReducedMotion& motion, const CentrePose& pose, std::array<Index, 2> leaves,
                           double gap, double at_least, double enough) {
  gap_ = gap;
  at_least_ = at_least;
  set_reference(motion, leaves);
  read(motion, pose, leaves[0], leaf_a_);
  const bool is_same = leaves[0] == leaves[1];
  if (!is_same) read(motion, pose, leaves[1], leaf_b_);
  const Leaf& other = is_same ? leaf_a_ : leaf_b_;
  double least = smallest(motion, pose, leaf_a_.vertices, other.triangles, enough);
  if (!is_same) least = smallest(motion, pose, other.vertices, leaf_a_.triangles, least);
  return smallest(motion, pose, leaf_a_.edges, other.edges, least);
}

}  // namespace foldproof
