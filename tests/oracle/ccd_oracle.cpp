// Exact continuous collision detection by a sweep over the times at which anything can change.
//
// Two features touch when the origin lies in the convex hull of their differences: for a vertex and a face
// the triangle f_i - v; for two edges the parallelogram a_i - b_j, which is the union of two triangles. So
// one question is enough: at which times does a triangle with linearly moving corners hold the origin? Each
// part of the test is the sign of a polynomial in t of degree three at most. The set of touching times is
// closed, so when it is not empty it has a first time, which is 0 or a time at which one of those signs
// changes: a root. The roots are finitely many algebraic numbers, and the test is done exactly at each.
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "oracle/integer_points.h"
#include "oracle/oracle.h"

namespace foldproof::oracle {
namespace {

using oracle::cross;
using oracle::dot;

using PolyPoint = std::array<Polynomial, 3>;

PolyPoint cross(const PolyPoint& a, const PolyPoint& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Polynomial dot(const PolyPoint& a, const PolyPoint& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

// A corner of a triangle of differences, at both ends of the step.
struct MovingPoint {
  IntPoint start, end;
};
using MovingTriangle = std::array<MovingPoint, 3>;

PolyPoint path(const MovingPoint& p) {
  PolyPoint result;
  for (int k = 0; k < 3; ++k) result[k] = Polynomial({p.start[k], p.end[k] - p.start[k]});
  return result;
}

// The polynomials whose signs decide whether a moving triangle holds the origin; see triangle_holds_origin.
struct TriangleSigns {
  explicit TriangleSigns(const MovingTriangle& triangle) {
    const std::array<PolyPoint, 3> p = {path(triangle[0]), path(triangle[1]), path(triangle[2])};
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3;
      crosses[i] = cross(p[i], p[j]);
      dots[i] = dot(p[i], p[j]);
    }
    for (int k = 0; k < 3; ++k) normal[k] = crosses[0][k] + crosses[1][k] + crosses[2][k];
    volume = dot(crosses[0], p[2]);
  }

  bool holds_origin(Root& t) const {
    if (t.sign_of(volume) != 0) return false;
    for (int k = 0; k < 3; ++k) {
      const int facing = t.sign_of(normal[k]);
      if (facing == 0) continue;
      // The triangle and the origin lie in one plane, and dropping coordinate k keeps that plane
      // two-dimensional.
      for (int i = 0; i < 3; ++i) {
        if (t.sign_of(crosses[i][k]) == -facing) return false;
      }
      return true;
    }
    for (int i = 0; i < 3; ++i) {
      if (t.sign_of(dots[i]) > 0) continue;
      bool on_line = true;
      for (int k = 0; k < 3 && on_line; ++k) on_line = t.sign_of(crosses[i][k]) == 0;
      if (on_line) return true;
    }
    return false;
  }

  // Polynomials whose roots, together with time 0, contain the first touching time.
  std::vector<const Polynomial*> events() const {
    if (!volume.is_zero()) return {&volume};
    std::vector<const Polynomial*> result;
    for (int i = 0; i < 3; ++i) {
      for (int k = 0; k < 3; ++k) result.push_back(&crosses[i][k]);
      result.push_back(&dots[i]);
    }
    for (int k = 0; k < 3; ++k) result.push_back(&normal[k]);
    std::erase_if(result, [](const Polynomial* p) { return p->degree() < 1; });
    return result;
  }

  std::array<PolyPoint, 3> crosses;  // p0 x p1, p1 x p2, p2 x p0
  std::array<Polynomial, 3> dots;    // p0 . p1, p1 . p2, p2 . p0
  PolyPoint normal;
  Polynomial volume;
};

bool triangle_touches(const MovingTriangle& triangle, const Span& span) {
  const Dyadic start, latest = Dyadic::from_double(span.latest);
  if (span.open && latest.numerator.is_zero()) return false;
  if (triangle_holds_origin(triangle[0].start, triangle[1].start, triangle[2].start)) return true;
  const TriangleSigns signs(triangle);
  for (const Polynomial* event : signs.events()) {
    const Sturm sturm(*event);
    for (Root& root : roots_within(sturm, start, latest)) {
      if (span.open && root.is_at(latest)) continue;
      if (signs.holds_origin(root)) return true;
    }
  }
  return false;
}

struct MovingPair {
  std::vector<MovingTriangle> triangles;
  int exponent;  // Integers times 2^exponent are mesh units.
};

MovingPair differences(Kind kind, const FourPoints& x0, const FourPoints& x1) {
  std::array<Vec3, 8> all;
  std::copy(x0.begin(), x0.end(), all.begin());
  std::copy(x1.begin(), x1.end(), all.begin() + 4);
  const Grid grid = to_grid(all);
  const auto difference = [&](int i, int j) {
    return MovingPoint{grid.points[i] - grid.points[j], grid.points[4 + i] - grid.points[4 + j]};
  };
  if (kind == Kind::VertexFace) {
    return {{MovingTriangle{difference(1, 0), difference(2, 0), difference(3, 0)}}, grid.exponent};
  }
  const MovingPoint a0b0 = difference(0, 2), a0b1 = difference(0, 3), a1b0 = difference(1, 2),
                    a1b1 = difference(1, 3);
  return {{MovingTriangle{a0b0, a1b0, a1b1}, MovingTriangle{a0b0, a0b1, a1b1}}, grid.exponent};
}

// A non-negative fraction; kept unreduced, since it is compared once or twice and then thrown away.
struct Fraction {
  Int numerator, denominator = 1;
};
bool less(const Fraction& a, const Fraction& b) {
  return a.numerator * b.denominator < b.numerator * a.denominator;
}

Fraction origin_to_segment(const IntPoint& p, const IntPoint& q) {
  const IntPoint along = q - p;
  const Int towards = -dot(p, along), length2 = dot(along, along);
  if (towards.sign() <= 0) return {dot(p, p)};
  if (towards >= length2) return {dot(q, q)};
  const IntPoint area = cross(p, q);
  return {dot(area, area), length2};
}

Fraction origin_to_triangle(const IntPoint& p, const IntPoint& q, const IntPoint& r) {
  const IntPoint pq = cross(p, q), qr = cross(q, r), rp = cross(r, p);
  const IntPoint normal = pq + qr + rp;
  const bool inside = !is_zero(normal) && dot(pq, normal).sign() >= 0 && dot(qr, normal).sign() >= 0 &&
                      dot(rp, normal).sign() >= 0;
  if (inside) {
    const Int height = dot(p, normal);
    return {height * height, dot(normal, normal)};
  }
  const auto closer = [](const Fraction& a, const Fraction& b) { return less(b, a) ? b : a; };
  return closer(closer(origin_to_segment(p, q), origin_to_segment(q, r)), origin_to_segment(r, p));
}

// Squared distance at time t in squared units of 2^(exponent - t.exponent).
Fraction pair_distance2(const MovingPair& pair, const Dyadic& t) {
  Fraction best;
  for (std::size_t i = 0; i < pair.triangles.size(); ++i) {
    std::array<IntPoint, 3> p;
    for (int k = 0; k < 3; ++k) {
      const MovingPoint& m = pair.triangles[i][k];
      p[k] = (Int(1) << t.exponent) * m.start + t.numerator * (m.end - m.start);
    }
    const Fraction d = origin_to_triangle(p[0], p[1], p[2]);
    if (i == 0 || less(d, best)) best = d;
  }
  return best;
}

Rational power_of_two(int exponent) {
  const boost::multiprecision::cpp_int power = boost::multiprecision::cpp_int(1) << std::abs(exponent);
  return exponent >= 0 ? Rational(power) : Rational(1, power);
}

Rational to_rational(const Fraction& f, int exponent) {
  return Rational(boost::multiprecision::cpp_int(f.numerator),
                  boost::multiprecision::cpp_int(f.denominator)) *
         power_of_two(exponent);
}

// value / 2^exponent, exactly.
Dyadic scaled_down(double value, int exponent) {
  Dyadic result = Dyadic::from_double(value);
  if (exponent >= 0) {
    result.exponent += static_cast<unsigned>(exponent);
  } else {
    result.numerator <<= static_cast<unsigned>(-exponent);
  }
  return result;
}

Dyadic sum(const Dyadic& a, const Dyadic& b) {
  const unsigned exponent = std::max(a.exponent, b.exponent);
  return {(a.numerator << (exponent - a.exponent)) + (b.numerator << (exponent - b.exponent)), exponent};
}

// Searches the step for a time within the bound, always splitting intervals that cannot be ruled out.
class ApproachSearch {
 public:
  ApproachSearch(const MovingPair& pair, double bound, double margin)
      : pair_(pair),
        bound_(scaled_down(bound, pair.exponent)),
        half_margin_(scaled_down(margin, pair.exponent)) {
    half_margin_.exponent += 1;
    for (const MovingTriangle& triangle : pair.triangles) {
      for (const MovingPoint& m : triangle) {
        const IntPoint v = m.end - m.start;
        speed_ = std::max<Int>(speed_, abs(v[0]) + abs(v[1]) + abs(v[2]));
      }
    }
  }

  Approach run(const Dyadic& lo, const Dyadic& hi, bool open) {
    if (compare(lo, hi) == 0) {
      if (open) return Approach::Beyond;
      return at_most(lo, bound_) ? Approach::Within : Approach::Beyond;
    }
    if (at_most(lo, bound_) || (!open && at_most(hi, bound_))) return Approach::Within;
    std::vector<std::pair<Dyadic, Dyadic>> open_intervals = {{lo, hi}};
    bool close = false;
    for (int step = 0; !open_intervals.empty(); ++step) {
      if (step == kMaxIntervals) return Approach::Close;
      const auto [a, b] = open_intervals.back();
      open_intervals.pop_back();
      const Dyadic m = midpoint(a, b);
      const Fraction distance2 = pair_distance2(pair_, m);
      if (at_most(distance2, m, bound_)) return Approach::Within;
      // No point moves further than this between m and an end of the interval, so the distance cannot change
      // more.
      Dyadic reach = sum(m, Dyadic{-a.numerator, a.exponent});
      reach.numerator *= speed_;
      if (!at_most(distance2, m, sum(bound_, reach))) continue;
      if (compare(reach, half_margin_) <= 0) {
        close = true;
        continue;
      }
      open_intervals.push_back({m, b});
      open_intervals.push_back({a, m});
    }
    return close ? Approach::Close : Approach::Beyond;
  }

 private:
  static constexpr int kMaxIntervals = 4000;

  static bool at_most(const Fraction& distance2, const Dyadic& t, const Dyadic& bound) {
    const Int distance_side = distance2.numerator << (2 * bound.exponent);
    return distance_side <= (bound.numerator * bound.numerator * distance2.denominator) << (2 * t.exponent);
  }
  bool at_most(const Dyadic& t, const Dyadic& bound) const {
    return at_most(pair_distance2(pair_, t), t, bound);
  }

  const MovingPair& pair_;
  Dyadic bound_, half_margin_;  // In units of 2^pair.exponent.
  Int speed_ = 0;               // No corner moves further than this during the step.
};

}  // namespace

bool touches(Kind kind, const FourPoints& x0, const FourPoints& x1, const Span& span) {
  const MovingPair pair = differences(kind, x0, x1);
  return std::any_of(pair.triangles.begin(), pair.triangles.end(),
                     [&](const MovingTriangle& triangle) { return triangle_touches(triangle, span); });
}

Rational squared_distance(Kind kind, const FourPoints& x0, const FourPoints& x1, double t) {
  const MovingPair pair = differences(kind, x0, x1);
  const Dyadic time = Dyadic::from_double(t);
  return to_rational(pair_distance2(pair, time), 2 * (pair.exponent - static_cast<int>(time.exponent)));
}

bool within_distance(Kind kind, const FourPoints& x0, const FourPoints& x1, double t, const Rational& bound) {
  return squared_distance(kind, x0, x1, t) <= bound * bound;
}

Approach approach(Kind kind, const FourPoints& x0, const FourPoints& x1, double bound, double margin,
                  const Span& span) {
  const MovingPair pair = differences(kind, x0, x1);
  return ApproachSearch(pair, bound, margin).run(Dyadic{}, Dyadic::from_double(span.latest), span.open);
}

}  // namespace foldproof::oracle
