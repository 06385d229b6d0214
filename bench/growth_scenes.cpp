#include <fmt/format.h>

#include <array>

#include "base/try.h"
#include "generated.h"
#include "scene.h"
#include "subdivide.h"

namespace foldproof::bench {
namespace {

constexpr Index kFrames = 6;

const SceneInfo& lion() {
  static const SceneInfo poses{"", SceneKind::Motion, {"lion-poses/pose_00.obj"}};
  return poses;
}

// `kFrames` frames of a scene from `first` on, of the vertices that `topology` has.
Result<std::unique_ptr<Motion>> part_of(const char* scene, Index first, const Topology* topology = nullptr) {
  auto motion = open_scene(*find_scene(scene));
  if (!motion) return motion;
  const Topology& all = (*motion)->topology();
  if (topology == nullptr) topology = &all;
  std::vector<std::vector<double>> frames(kFrames);
  for (Index k = 0; k < kFrames; ++k) {
    frames[k].resize(std::size_t{3} * all.vertex_count());
    FOLDPROOF_TRY((*motion)->read_frame(first + k, frames[k]));
    frames[k].resize(std::size_t{3} * topology->vertex_count());
  }
  return memory_motion(scene, *topology, std::move(frames));
}

// The motion is Loop's subdivision of the poses' mesh, whose vertices come first.
Result<std::unique_ptr<Motion>> coarse_lion() {
  auto poses = open_scene(lion());
  if (!poses) return poses;
  return part_of("lion-anim", 18, &(*poses)->topology());
}

// Frames in which the hand closes and does not touch itself yet.
Result<std::unique_ptr<Motion>> coarse_hand() { return part_of("hand-anim", 5); }

Result<std::unique_ptr<Motion>> refined(Result<std::unique_ptr<Motion>> motion, int levels) {
  for (int level = 0; level < levels && motion; ++level) motion = refine(**motion);
  return motion;
}

std::vector<SceneInfo> make_growth_scenes() {
  std::vector<SceneInfo> scenes;
  std::vector<std::string> files = lion().files;
  const auto& anim = find_scene("lion-anim")->files;
  files.insert(files.end(), anim.begin(), anim.end());
  Index triangles = 9'996;
  for (int levels = 0; levels <= 5; ++levels, triangles *= 3)
    scenes.push_back({fmt::format("lion-{}", triangles), SceneKind::Growth, files,
                      [levels] { return refined(coarse_lion(), levels); }, triangles});
  triangles = 70'292;
  for (int levels = 0; levels <= 3; ++levels, triangles *= 3)
    scenes.push_back({fmt::format("hand-{}", triangles), SceneKind::Growth, find_scene("hand-anim")->files,
                      [levels] { return refined(coarse_hand(), levels); }, triangles});
  for (const Index side : {71, 100, 224, 316, 707, 1000})
    scenes.push_back({fmt::format("cloth-{}", 2 * side * side),
                      SceneKind::Growth,
                      {},
                      [side] { return Result<std::unique_ptr<Motion>>(waving_cloth(side)); },
                      2 * side * side});
  return scenes;
}

}  // namespace

const std::vector<SceneInfo>& growth_scenes() {
  static const std::vector<SceneInfo> scenes = make_growth_scenes();
  return scenes;
}

}  // namespace foldproof::bench
