/// Balls of two leaves, from one pair of features at a time.
#pragma once

#include "reduced/plane_ball.h"

namespace foldproof::inline internal {

/// Scratch: one per thread.
class FeatureBall {
 public:
  /// A radius around the pose's center within which every two features of two leaves, or of one with itself,
  /// that have no common vertex are farther apart than `gap`: the smallest over the pairs that the leaves own
  /// (docs/soundness.md, R7), at most `max_radius`. The search stops at `known` or below; such a result
  /// proves nothing. Cost: some hundred pairs of features, nearly all by their boxes, the others by a plane.
  double radius(const ReducedMotion& motion, const CenterPose& pose, std::array<Index, 2> leaves, double gap,
                double known, double max_radius);

 private:
  struct Feature {
    std::array<Index, 3> v;  // indices in leaf order
    int count;
    Vec3 low, high;  // at the center
    Vec3 growth;     // per axis, the largest of its vertices, relative to the reference motion
  };
  struct Candidate {
    double radius;  // by boxes
    Index a, b;
  };
  struct Leaf {
    std::vector<Feature> vertices, edges, triangles;
  };
  void set_reference(const ReducedMotion& motion, std::array<Index, 2> leaves);
  void read(const ReducedMotion& motion, const CenterPose& pose, Index leaf, Leaf& out) const;
  Feature feature(const ReducedMotion& motion, const CenterPose& pose, std::span<const Index> v) const;
  static TwoSets sets_of(const CenterPose& pose, const Feature& a, const Feature& b);
  double radius_by_boxes(const Feature& a, const Feature& b, double error) const;
  double min_radius(const ReducedMotion& motion, const CenterPose& pose, std::span<const Feature> a,
                    std::span<const Feature> b, double smallest);

  double gap_ = 0, known_ = 0;
  std::vector<Vec3> reference_;  // the motion of both leaves together, per mode and deviation
  Leaf leaf_a_, leaf_b_;
  std::vector<Candidate> candidates_;
  PlaneBall plane_;
};

}  // namespace foldproof::internal
