/// Numbers m 2^e with integers of any size: exact sums and products of doubles.
#pragma once

#include <bit>
#include <boost/multiprecision/cpp_int.hpp>
#include <cmath>
#include <limits>

namespace foldproof::testing {

struct Dyadic {
  boost::multiprecision::cpp_int m;
  int e = 0;

  Dyadic(double x) {  // NOLINT: as a number
    const double fraction = std::frexp(x, &e);
    m = static_cast<std::int64_t>(std::ldexp(fraction, 53));
    e -= 53;
  }
  Dyadic(boost::multiprecision::cpp_int mantissa, int exponent) : m(std::move(mantissa)), e(exponent) {}
  friend Dyadic operator+(const Dyadic& a, const Dyadic& b) {
    const int e = std::min(a.e, b.e);
    return {(a.m << (a.e - e)) + (b.m << (b.e - e)), e};
  }
  friend Dyadic operator-(const Dyadic& a, const Dyadic& b) { return a + Dyadic(-b.m, b.e); }
  friend Dyadic operator*(const Dyadic& a, const Dyadic& b) { return {a.m * b.m, a.e + b.e}; }
  int sign() const { return m.sign(); }
};

/// Whether r is a number rounded to the nearest double, ties to even, infinity beyond the largest double.
/// `above(m)`: the sign of the number minus m.
template <class Above>
bool is_nearest(double r, const Above& above) {
  const auto at = [](double x) { return std::isinf(x) ? Dyadic(std::signbit(x) ? -1 : 1, 1024) : Dyadic(x); };
  const double infinity = std::numeric_limits<double>::infinity();
  const bool even = (std::bit_cast<std::uint64_t>(r) & 1) == 0;
  const Dyadic half(1, -1);
  for (const double direction : {infinity, -infinity}) {
    if (r == direction) continue;
    const int side = above((at(r) + at(std::nextafter(r, direction))) * half) * (direction > 0 ? 1 : -1);
    if (side > 0 || (side == 0 && !even)) return false;
  }
  return true;
}

}  // namespace foldproof::testing
