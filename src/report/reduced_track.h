/// Objects that move in the coordinates of a model's subspace.
#pragma once

#include "foldproof/io.h"
#include "foldproof/reduced.h"

namespace foldproof {

/// One object's coordinates and placements, frame by frame. Read as a motion, it computes the vertices.
class ReducedTrack final : public Motion {
 public:
  /// Coordinates: frames x modes, at least one frame. Placements: one per frame, or none at all.
  struct Frames {
    std::vector<double> p;
    std::vector<Eigen::Matrix3d> rotation;
    std::vector<Vec3> translation;
  };
  /// Precondition: the sizes fit.
  ReducedTrack(std::string name, ReducedChecker::Object object, Frames frames);

  const ReducedChecker::Object& object() const { return object_; }
  /// Valid as long as this object.
  ReducedPose pose(Index frame) const;

  const std::string& name() const override { return name_; }
  const Topology& topology() const override;
  Index frame_count() const override;
  Result<void> read_frame(Index k, std::span<double> out) override;

 private:
  std::string name_;
  ReducedChecker::Object object_;
  Frames frames_;
};

}  // namespace foldproof
