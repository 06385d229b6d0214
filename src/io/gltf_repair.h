/// A repaired motion in the glTF file that it came from.
#pragma once

#include "foldproof/io.h"

namespace foldproof::io {

/// Error: `source` is not a glTF file, it is compressed, or names images that would not be found from `path`;
/// `path` is not GLB.
Result<void> require_gltf_can_be_repaired(const std::string& path, const std::string& source);

/// What is said of a repaired motion in the file: asset.extras.foldproof.
struct GltfRepairNote {
  std::string verdict;
  bool free = false;
};

/// Writes the file `source` again, as GLB: the same nodes, materials, textures, skins, names and animations.
/// What was moved gets a morph target for each frame in which it was, by sparse accessors, and an animation
/// of the targets' weights in the clip that was read. `repaired`: frames of the source from `first_frame` on,
/// as read with `options`. Positions of a frame are those of `repaired`, but for rounding to single
/// precision. Normals stay as they are. Error: what reading returns; a vertex that was moved and that its
/// joints or its node's scale flatten; too many morph targets.
Result<void> write_gltf_repair(const std::string& path, const std::string& source, const ReadOptions& options,
                               Motion& repaired, Index first_frame, const GltfRepairNote& note);

}  // namespace foldproof::io
