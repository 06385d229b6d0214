/// Parts that scenes are made of.
#pragma once

#include "adversary/case.h"

namespace foldproof::adversary {

struct Mesh {
  std::vector<Vec3> vertices;
  std::vector<Triangle> triangles;

  void add(const Mesh& other);
  /// Of a random triangle, or the origin.
  Vec3 random_point(Source& source) const;
};

/// One part around the origin: its longest side is about `size`. Any axis may be up.
Mesh make_part(Source& source, double size);

/// Ratios from 1e-6 to 1e6; some of them near those at which integers change their width.
double ratio(Source& source);

}  // namespace foldproof::adversary
