/// Which of a file's animations is shown.
#pragma once

#include "io/gltf_scene.h"

namespace foldproof::io {

/// An animation of a glTF file.
struct GltfClip {
  std::string name;  ///< As the file names it; may be empty.
  std::vector<GltfChannel> channels;
  double duration = 0;  ///< Time of the last key of any channel, seconds.
};

/// Gives the scene the channels of the clip of a name, or of "animations[1]", its duration, and what it says
/// of it; without a name, of the longest, the first of those that are equally long. A scene without clips
/// stays as it is. Error, about `file`: no clip has this name.
Result<void> show_clip(std::vector<GltfClip> clips, const std::string& name, const std::string& file,
                       GltfScene& scene);

}  // namespace foldproof::io
