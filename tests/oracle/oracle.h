/// The independent truth: decides by exact rational arithmetic what the library decides in floating point.
///
/// Nothing here is shared with the library but the types of its arguments. Every double is an integer times a
/// power of two, so a pair becomes integers once and for all, and each question becomes the sign of an
/// integer.
#pragma once

#include <boost/multiprecision/cpp_int.hpp>
#include <span>

#include "foldproof/ccd.h"

namespace foldproof::oracle {

using Rational = boost::multiprecision::cpp_rational;

/// Which two features the four points of a pair are.
enum class Kind { VertexFace, EdgeEdge };

/// Part of a step: [0, latest], or [0, latest) when open.
struct Span {
  double latest = 1;
  bool open = false;
};

/// Exactly: do the closed features have a point in common at some time of the span? Coordinates may be any
/// finite doubles. Cost: tens of microseconds; milliseconds when all points stay in one plane.
bool touches(Kind kind, const FourPoints& x0, const FourPoints& x1, const Span& span = {});

/// Exactly: the squared distance of the features at time t of the step, 0 <= t <= 1, in squared mesh units.
Rational squared_distance(Kind kind, const FourPoints& x0, const FourPoints& x1, double t);

/// Is the distance at time t at most `bound` (mesh units)? Exact.
bool within_distance(Kind kind, const FourPoints& x0, const FourPoints& x1, double t, const Rational& bound);

/// How the smallest distance over a span compares with a bound.
enum class Approach {
  Within,  ///< Proven: at most `bound` at some time of the span.
  Beyond,  ///< Proven: more than `bound` all the time.
  Close,   ///< Comes within bound + margin; which side of the bound it is was not settled.
};

/// Brackets the smallest distance by exact distances at midpoints and the speed of the points. `margin` > 0
/// (mesh units) says when to stop; a search of more than some thousand intervals gives Close.
Approach approach(Kind kind, const FourPoints& x0, const FourPoints& x1, double bound, double margin,
                  const Span& span = {});

/// The same function as the library's, evaluated by integers.
int orientation(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

/// Exactly: do the convex hulls of two point sets have a point in common? Carathéodory: when they do, the
/// origin lies in the hull of at most four differences.
bool hulls_intersect(std::span<const Vec3> a, std::span<const Vec3> b);

/// Exactly: are the three points on one line?
bool collinear(const Vec3& a, const Vec3& b, const Vec3& c);

/// Exactly: do the triangles (a, b, c) and (a, b, d) have a point in common outside the segment ab?
bool meet_beyond_edge(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

}  // namespace foldproof::oracle
