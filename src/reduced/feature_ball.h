/// How far reduced coordinates may go before features of two leaves touch, looked at one pair of features at
/// a time.
#pragma once

#include "reduced/plane_ball.h"

namespace foldproof {

/// Scratch: one per thread.
class FeatureBall {
 public:
  /// A radius around the pose's centre within which every two features of two leaves, or of one with itself,
  /// that have no common vertex are farther apart than `gap`: the smallest over the pairs that the leaves own
  /// (docs/soundness.md, R7). The search ends once it falls to `at_least` or below; `enough`: more need not
  /// be looked for. Cost: some hundred pairs of features, nearly all by their boxes, a plane for the others.
  double radius(const ReducedMotion& motion, const CentrePose& pose, std::array<Index, 2> leaves, double gap,
                double at_least, double enough);

 private:
  struct Feature {
    std::array<Index, 3> v;  // places in leaf order
    int count;
    Vec3 low, high;  // at the centre
    Vec3 grow;       // per axis, of any of its vertices against the leaves' common motion
  };
  struct Candidate {
    double radius;  // by the boxes
    Index a, b;
  };
  struct Leaf {
    std::vector<Feature> vertices, edges, triangles;
  };
  void set_reference(const ReducedMotion& motion, std::array<Index, 2> leaves);
  void read(const ReducedMotion& motion, const CentrePose& pose, Index leaf, Leaf& out) const;
  Feature feature(const ReducedMotion& motion, const CentrePose& pose, std::span<const Index> v) const;
  static TwoSets sets_of(const CentrePose& pose, const Feature& a, const Feature& b);
  double by_boxes(const Feature& a, const Feature& b, double error) const;
  double smallest(const ReducedMotion& motion, const CentrePose& pose, std::span<const Feature> a,
                  std::span<const Feature> b, double least);

  double gap_ = 0, at_least_ = 0;
  std::vector<Vec3> reference_;  // per mode and deviation
  Leaf leaf_a_, leaf_b_;
  std::vector<Candidate> candidates_;
  PlaneBall plane_;
};

}  // namespace foldproof
