#pragma once

#include <fmt/format.h>

#include <string>

namespace foldproof::testing {

/// The OBJ of a cube of two triangles a side; `place(x, y, z)` gives the coordinates of the corner (x, y, z)
/// of the unit cube.
template <class Place>
std::string cube_at(Place place) {
  std::string text;
  for (int v = 0; v < 8; ++v) {
    const auto x = place(v & 1, v >> 1 & 1, v >> 2);
    text += fmt::format("v {:.6g} {:.6g} {:.6g}\n", x[0], x[1], x[2]);
  }
  return text +
         "f 1 3 2\nf 2 3 4\nf 5 6 7\nf 6 8 7\nf 1 2 5\nf 2 6 5\nf 3 7 4\nf 4 7 8\nf 1 5 3\nf 3 5 7\nf 2 4 6\n"
         "f 4 8 6\n";
}

}  // namespace foldproof::testing
