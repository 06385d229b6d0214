/// Points of doubles as points of integers on one common grid.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "foldproof/base.h"
#include "oracle/polynomial.h"

namespace foldproof::oracle {

using IntPoint = std::array<Int, 3>;

inline IntPoint operator+(const IntPoint& a, const IntPoint& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
inline IntPoint operator-(const IntPoint& a, const IntPoint& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
inline IntPoint operator*(const Int& s, const IntPoint& a) { return {s * a[0], s * a[1], s * a[2]}; }
inline Int dot(const IntPoint& a, const IntPoint& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline IntPoint cross(const IntPoint& a, const IntPoint& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline bool is_zero(const IntPoint& a) { return a[0].is_zero() && a[1].is_zero() && a[2].is_zero(); }

/// integer = coordinate / 2^exponent, exactly, for all points.
struct Grid {
  std::vector<IntPoint> points;
  int exponent = 0;
};

/// The coarsest grid that holds every coordinate. Precondition: finite coordinates.
Grid to_grid(std::span<const Vec3> points);

/// Exactly: does the segment pq contain the origin?
bool segment_holds_origin(const IntPoint& p, const IntPoint& q);
/// Exactly: does the triangle pqr, however degenerate, contain the origin?
bool triangle_holds_origin(const IntPoint& p, const IntPoint& q, const IntPoint& r);

}  // namespace foldproof::oracle
