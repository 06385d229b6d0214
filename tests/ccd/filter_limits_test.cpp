// E1 and E2 at the ends of double's range: the filter's limits, denormal differences, overflow. Compared with
// exact integers.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "foldproof/eigen.h"
#include "oracle/families.h"
#include "oracle/oracle.h"

namespace foldproof::oracle {
namespace {

constexpr double kMax = std::numeric_limits<double>::max();

// Sizes of coordinates: the limits of the filter and of double's range.
int some_exponent(Rng& rng) {
  constexpr int kExponents[] = {-1074, -1073, -1060, -1022, -1021, -700, -540, -512, -484, -400,
                                -323,  -322,  -321,  -160,  -52,   0,    52,   160,  320,  321,
                                322,   323,   340,   511,   512,   700,  970,  1000, 1022, 1023};
  return kExponents[rng() % std::size(kExponents)];
}

double some_number(int exponent, Rng& rng) {
  const double sign = rng() % 2 ? 1 : -1;
  switch (rng() % 4) {
    case 0:
      return sign * std::ldexp(static_cast<double>(rng() % 4), std::min(exponent, 1021));
    case 1:
      return sign * std::ldexp(1 + std::ldexp(static_cast<double>(rng() >> 12), -52), exponent);
    case 2:
      return sign * std::nextafter(std::ldexp(1.0, exponent), rng() % 2 ? 0 : kMax);
    default:
      return sign * (rng() % 8 == 0 ? kMax : 0);
  }
}

double shifted(double x, int units) {
  for (; units != 0; units -= units > 0 ? 1 : -1) x = std::nextafter(x, units > 0 ? kMax : -kMax);
  return x;
}

// A point almost in the plane of three, or on the line of two.
Vec3 nearly_between(const Vec3& a, const Vec3& b, const Vec3& c, Rng& rng) {
  const double s = static_cast<double>(rng() % 5) / 4, t = (1 - s) * static_cast<double>(rng() % 5) / 4;
  Vec3 p = a * (1 - s - t) + b * s + c * t;
  const bool exact = rng() % 2;
  for (double& x : p) x = shifted(std::clamp(x, -kMax, kMax), exact ? 0 : int(rng() % 5) - 2);
  return p;
}

struct Four {
  Vec3 a, b, c, d;
};
Four some_points(Rng& rng) {
  Four p;
  const int exponents[3] = {some_exponent(rng), some_exponent(rng), some_exponent(rng)};
  const bool one_size = rng() % 2, far = rng() % 4 == 0;
  for (Vec3* x : {&p.a, &p.b, &p.c, &p.d}) {
    for (int axis = 0; axis < 3; ++axis)
      (*x)[axis] = some_number(rng() % 8 == 0 ? some_exponent(rng) : exponents[one_size ? 0 : axis], rng);
  }
  if (far) {  // a few ulps apart
    for (int axis = 0; axis < 3; ++axis) {
      for (Vec3* x : {&p.b, &p.c, &p.d}) (*x)[axis] = shifted(p.a[axis], int(rng() % 7) - 3);
    }
  }
  if (rng() % 2) p.d = nearly_between(p.a, p.b, p.c, rng);
  for (Vec3* x : {&p.a, &p.b, &p.c, &p.d}) {
    for (double& c : *x) c = std::isfinite(c) ? c : kMax;
  }
  return p;
}

TEST(FilterLimits, OrientationAgreesWithIntegers) {
  Rng rng(17);
  int signs[3] = {};
  for (int i = 0; i < 20000; ++i) {
    const Four p = some_points(rng);
    const int expected = orientation(p.a, p.b, p.c, p.d);
    ++signs[expected + 1];
    ASSERT_EQ(orient3d(p.a, p.b, p.c, p.d), expected)
        << to_eigen(p.a).transpose() << "; " << to_eigen(p.b).transpose() << "; " << to_eigen(p.c).transpose()
        << "; " << to_eigen(p.d).transpose();
  }
  for (const int count : signs) EXPECT_GT(count, 700);
}

TEST(FilterLimits, AreaAgreesWithIntegers) {
  Rng rng(18);
  int with_area = 0;
  for (int i = 0; i < 20000; ++i) {
    Four p = some_points(rng);
    if (rng() % 2) p.c = nearly_between(p.a, p.b, p.b, rng);
    for (double& x : p.c) x = std::isfinite(x) ? x : kMax;
    const bool expected = !collinear(p.a, p.b, p.c);
    with_area += expected;
    ASSERT_EQ(triangle_has_area(p.a, p.b, p.c), expected)
        << to_eigen(p.a).transpose() << "; " << to_eigen(p.b).transpose() << "; "
        << to_eigen(p.c).transpose();
  }
  EXPECT_GT(with_area, 2000);
  EXPECT_LT(with_area, 19300);
}

}  // namespace
}  // namespace foldproof::oracle
