#include "adversary/truth.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace foldproof::adversary {
namespace {

// 64 bits of mantissa, and exponents that no product of three coordinates leaves.
using Real = long double;
using Point = std::array<Real, 3>;

Point minus(const Vec3& a, const Vec3& b) {
  return {Real(a[0]) - b[0], Real(a[1]) - b[1], Real(a[2]) - b[2]};
}
Point minus(const Point& a, const Point& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Point cross(const Point& a, const Point& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Real dot(const Point& a, const Point& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Real size(const Point& a) { return std::max({std::abs(a[0]), std::abs(a[1]), std::abs(a[2])}); }

constexpr Real kRoom = 0x1p-50L;  // relative, far more than a dozen roundings of 2^-64

// Of the first feature less one of the second, per end. A pair stays apart where a plane keeps all corners
// beyond `bound` at both ends, as each of them goes straight.
class Corners {
 public:
  explicit Corners(const Features& pair) {
    for (int end = 0; end < 2; ++end) {
      const FourPoints& x = end == 0 ? pair.x0 : pair.x1;
      if (pair.kind == oracle::Kind::VertexFace) {
        count_ = 3;
        for (int k = 0; k < 3; ++k) d_[end][k] = minus(x[0], x[1 + k]);
      } else {
        count_ = 4;
        for (int k = 0; k < 4; ++k) d_[end][k] = minus(x[k % 2], x[2 + k / 2]);
      }
      for (int k = 0; k < count_; ++k) largest_ = std::max(largest_, size(d_[end][k]));
    }
  }

  bool beyond(Real bound) const {
    if (largest_ == 0) return false;
    for (int axis = 0; axis < 3; ++axis) {
      Point n{};
      n[axis] = 1;
      if (separates(n, bound)) return true;
    }
    std::array<Point, 4> middle{};
    for (int end = 0; end < 3; ++end) {
      for (int k = 0; k < count_; ++k) {
        for (int axis = 0; axis < 3; ++axis) {
          middle[k][axis] = end < 2 ? d_[end][k][axis] : (d_[0][k][axis] + d_[1][k][axis]) / 2;
        }
      }
      if (along(middle, bound)) return true;
    }
    return false;
  }

 private:
  bool along(const std::array<Point, 4>& d, Real bound) const {
    const Point e = minus(d[1], d[0]), f = minus(d[2], d[0]), normal = cross(e, f);
    if (separates(normal, bound)) return true;
    const std::array<Point, 4> sides = {e, f, minus(d[2], d[1]), count_ == 4 ? minus(d[3], d[1]) : e};
    const std::array<int, 4> from = {0, 0, 1, count_ == 4 ? 1 : 0};
    for (int k = 0; k < 4; ++k) {
      if (separates(d[k % count_], bound)) return true;
      if (separates(cross(sides[k], cross(d[from[k]], sides[k])), bound)) return true;
    }
    return false;
  }

  bool separates(const Point& n, Real bound) const {
    const Real length = std::sqrt(dot(n, n));
    if (!(length > 0)) return false;
    const Real least = bound * length * (1 + kRoom) + 4 * kRoom * size(n) * largest_;
    bool above = true, below = true;
    for (int end = 0; end < 2; ++end) {
      for (int k = 0; k < count_; ++k) {
        const Real at = dot(n, d_[end][k]);
        above = above && at > least;
        below = below && at < -least;
      }
    }
    return above || below;
  }

  std::array<std::array<Point, 4>, 2> d_{};
  int count_ = 0;
  Real largest_ = 0;
};

// The same along an axis in doubles, which settles most: differences carry one rounding.
bool boxes_beyond(const Features& pair, double bound) {
  const double least = bound * (1 + 0x1p-40);
  const int own = pair.kind == oracle::Kind::VertexFace ? 1 : 2;
  for (int axis = 0; axis < 3; ++axis) {
    bool above = true, below = true;
    for (const FourPoints* x : {&pair.x0, &pair.x1}) {
      double low[2], high[2];
      for (int k = 0; k < 4; ++k) {
        const double c = (*x)[k][axis];
        const int set = k >= own;
        const bool first = k == 0 || k == own;
        low[set] = first ? c : std::min(low[set], c);
        high[set] = first ? c : std::max(high[set], c);
      }
      above = above && low[0] - high[1] > least;
      below = below && low[1] - high[0] > least;
    }
    if (above || below) return true;
  }
  return false;
}

double extent(const Features& pair) {
  double result = 0;
  for (int k = 0; k < 4; ++k) {
    for (const FourPoints* x : {&pair.x0, &pair.x1}) {
      // Halves, so that nothing overflows.
      result = std::max(result, ((*x)[k] / 2 - pair.x0[0] / 2).cwiseAbs().maxCoeff());
    }
  }
  return result;
}

}  // namespace

bool surely_beyond(const Features& pair, double bound) {
  return boxes_beyond(pair, bound) || Corners(pair).beyond(bound);
}

bool comes_within(const Features& pair, double distance) {
  if (distance == 0) return oracle::touches(pair.kind, pair.x0, pair.x1);
  const double margin = std::max(std::ldexp(extent(pair), -30), 0x1p-1074);
  return oracle::approach(pair.kind, pair.x0, pair.x1, distance, margin) == oracle::Approach::Within;
}

std::string describe(const Features& pair) {
  std::string text = pair.kind == oracle::Kind::VertexFace ? "vertex-face" : "edge-edge";
  for (const FourPoints* x : {&pair.x0, &pair.x1}) {
    text += x == &pair.x0 ? "\n  from" : "\n  to  ";
    for (const Vec3& p : *x) text += fmt::format(" ({:a}, {:a}, {:a})", p.x(), p.y(), p.z());
  }
  return text;
}

}  // namespace foldproof::adversary
