/// Animated GLB, as modelers export it.
#pragma once

#include "foldproof/io.h"

namespace foldproof {

/// Writes a mesh with a morph target per frame after the first, and an animation from frame to frame, 24 per
/// second; single precision. For motions of few frames: it keeps all of them in memory.
Result<void> write_glb(const std::string& path, Motion& motion);

}  // namespace foldproof
