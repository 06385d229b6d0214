/// Features and scenes that come exactly as near as asked, or nearly so, with coordinates of many digits.
#pragma once

#include "adversary/parts.h"
#include "oracle/oracle.h"

namespace foldproof::adversary {

/// Two features no farther apart than `thickness`, by how they are made. `across` leads from the one to the
/// other, with integers; the first feature may be moved along it.
struct Contact {
  oracle::Kind kind = oracle::Kind::VertexFace;
  FourPoints points;
  double thickness = 0;
  Vec3 across{0, 0, 1};
};
/// Integers; exactly `thickness` apart (0: they touch).
Contact make_contact(Source& source);
/// A vertex before a face whose normal underflows when it is squared, at the thickness or a little nearer.
Contact make_tiny_contact(Source& source);
/// A vertex in a long face that is so thin that products underflow inside its normal.
Contact make_thin_contact(Source& source);

/// Two triangles in one plane. A corner of one is beside a side of the other, on this side or that, by so
/// little that doubles do not tell.
std::array<std::array<Vec3, 3>, 2> make_flat_pair(Source& source);

/// Two objects with such a contact, everything else mostly farther, or with a flat pair.
struct TouchingObjects {
  std::array<Mesh, 2> objects;
  double thickness = 0;
  Vec3 across{0, 0, 1};
};
TouchingObjects make_touching_objects(Source& source);
TouchingObjects make_tiny_touching_objects(Source& source);

}  // namespace foldproof::adversary
