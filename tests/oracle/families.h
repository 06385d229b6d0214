/// Named families of moving pairs, made from a seed. Each mixes hits and misses.
#pragma once

#include <cmath>
#include <ostream>
#include <random>
#include <span>

#include "oracle/oracle.h"

namespace foldproof::oracle {

using Rng = std::mt19937_64;

inline double uniform(Rng& rng, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(rng);
}

struct Case {
  FourPoints x0, x1;
};

struct Family {
  const char* name;
  Case (*make)(Kind kind, Rng& rng);
  bool integers;  ///< All coordinates are integers below 2^20 in magnitude: exact transforms stay exact.
};

/// For GoogleTest's messages.
inline void PrintTo(const Family& family, std::ostream* out) { *out << family.name; }

/// All families. Between 30 and 70 of 100 cases of each touch, for either kind; the tests of the oracle check
/// it.
std::span<const Family> families();

/// The multiple of `unit` that is nearest, in each coordinate.
inline Vec3 nearest_multiple(const Vec3& p, double unit) {
  const Vec3 q = p / unit;
  return unit * Vec3(std::round(q.x()), std::round(q.y()), std::round(q.z()));
}

}  // namespace foldproof::oracle
