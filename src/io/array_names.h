/// Names of a motion's NumPy arrays, in lower case, the usual one first (docs/formats.md).
#pragma once

#include <array>
#include <string_view>

namespace foldproof::io {

inline constexpr std::array<std::string_view, 6> kVertexNames{"vertices", "verts", "positions",
                                                              "points",   "v",     "x"};
inline constexpr std::array<std::string_view, 5> kFaceNames{"faces", "triangles", "tris", "cells", "f"};

}  // namespace foldproof::io
