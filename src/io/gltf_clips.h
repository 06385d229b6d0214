/// Which channels of a file's animations are shown together.
#pragma once

#include "io/gltf_scene.h"

namespace foldproof::io {

/// An animation of a glTF file.
struct GltfClip {
  std::string name;  ///< As it is shown to users: "'walk'", or "animations[0]".
  std::vector<GltfChannel> channels;
  double duration = 0;  ///< Time of the last key of any channel, seconds.
};

/// Gives the scene the channels of all clips, its duration, and notes on clips that are left out: all clips
/// play together from time 0. Where two drive the same property, as clips of one character do, the longest
/// wins; the first of those that are equally long.
void play_together(std::vector<GltfClip> clips, GltfScene& scene);

}  // namespace foldproof::io
