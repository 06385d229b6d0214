#include "report/reduced_track.h"

namespace foldproof {

ReducedTrack::ReducedTrack(std::string name, ReducedChecker::Object object, Frames frames)
    : name_(std::move(name)), object_(std::move(object)), frames_(std::move(frames)) {}

const Topology& ReducedTrack::topology() const { return object_.shape->motion()->hierarchy()->topology(); }

Index ReducedTrack::frame_count() const {
  return static_cast<Index>(frames_.p.size() / object_.shape->motion()->modes());
}

ReducedPose ReducedTrack::pose(Index frame) const {
  const Index modes = object_.shape->motion()->modes();
  ReducedPose pose{std::span(frames_.p).subspan(std::size_t{frame} * modes, modes)};
  if (!frames_.rotation.empty()) pose.rotation = frames_.rotation[frame];
  if (!frames_.translation.empty()) pose.translation = frames_.translation[frame];
  return pose;
}

Result<void> ReducedTrack::read_frame(Index k, std::span<double> out) {
  pose_vertices(*object_.shape->motion(), pose(k), out);
  return {};
}

}  // namespace foldproof
