/// Scenes in which two features come exactly as near as asked, with coordinates of many digits.
#pragma once

#include "adversary/parts.h"

namespace foldproof::adversary {

/// Two objects whose coordinates are integers. A feature of the one is exactly `thickness` away from one of
/// the other (0: touches), and everything else mostly farther. `across` leads from the one to the other.
struct Kiss {
  std::array<Mesh, 2> objects;
  double thickness = 0;
  Vec3 across = Vec3::UnitZ();
};
Kiss make_kiss(Source& source);

/// A vertex before a face whose normal underflows when it is squared, at the thickness or a little nearer.
Kiss make_tiny_kiss(Source& source);

}  // namespace foldproof::adversary
