/// Meshes that the program makes itself, for those who have no data at hand. Nothing here was captured or
/// modelled after anything.
#pragma once

#include <vector>

#include "foldproof/mesh.h"

namespace foldproof {

/// A closed cylinder of length 10 and radius 0.5 along x, whose middle third bends.
class Cylinder {
 public:
  /// Around at least 3, along at least 3.
  Cylinder(Index around, Index along);

  const Topology& topology() const { return topology_; }
  /// `angle`: how far the ends turn against each other; past about 1.05 pi they meet. `towards`: the
  /// direction around the axis into which it bends, 0 is +y. Both in radians.
  std::vector<double> pose(double angle, double towards) const;

 private:
  Index around_, along_;
  Topology topology_;
};

/// A four-legged creature of smooth capsules, 3.5 long, that faces +x and has bones.
class Creature {
 public:
  enum Bone {
    kBody,
    kNeck,
    kHead,
    kTail,
    kForeRightThigh,
    kForeRightShin,
    kForeLeftThigh,
    kForeLeftShin,
    kHindRightThigh,
    kHindRightShin,
    kHindLeftThigh,
    kHindLeftShin,
    kBones
  };
  /// Per bone how far it has turned at its joint: axis times angle.
  using Turns = std::array<Vec3, kBones>;
  static Turns rest();

  /// `cell`: about the length of an edge; 0.05 makes some 11,000 triangles.
  explicit Creature(double cell);

  const Topology& topology() const { return topology_; }
  /// Linear blend skinning.
  std::vector<double> pose(const Turns& turns) const;

 private:
  Topology topology_;
  std::vector<Vec3> rest_;
  std::vector<std::array<float, kBones>> weights_;
};

}  // namespace foldproof
