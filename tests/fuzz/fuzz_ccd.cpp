// Any bytes are a pair of features in motion. The narrow phase and the exact predicates are held against the
// oracle; the program stops at a missed contact, at a hit out of tolerance, and at a wrong sign.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <string>

#include "foldproof/ccd.h"
#include "oracle/judge.h"
#include "oracle/oracle.h"

namespace {

using namespace foldproof;
using oracle::Kind;

class Bytes {
 public:
  Bytes(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {}
  std::uint8_t next() {
    if (size_ == 0) return 0;
    --size_;
    return *data_++;
  }
  double next_double() {
    std::array<std::uint8_t, sizeof(double)> raw;
    for (std::uint8_t& byte : raw) byte = next();
    double value;
    std::memcpy(&value, raw.data(), sizeof value);
    return value;
  }

 private:
  const std::uint8_t* data_;
  std::size_t size_;
};

using Pair = std::array<Vec3, 8>;  // Four points at t=0, then at t=1.

// Small integers: coplanar, parallel, touching and degenerate all the time.
Vec3 grid_point(Bytes& in) {
  const auto coordinate = [&] { return double(in.next() % 9) - 4; };
  const double x = coordinate(), y = coordinate(), z = coordinate();
  return {x, y, z};
}

// Any mantissa, but exponents that a mesh may have: wider ones only make the integers of the oracle long.
Vec3 raw_point(Bytes& in) {
  const auto coordinate = [&] {
    const double value = in.next_double();
    if (!std::isfinite(value) || value == 0) return 0.0;
    int exponent = 0;
    const double fraction = std::frexp(value, &exponent);
    return std::ldexp(fraction, exponent % 48);
  };
  const double x = coordinate(), y = coordinate(), z = coordinate();
  return {x, y, z};
}

Vec3 nudged(const Vec3& p, Bytes& in) {
  const std::uint8_t how = in.next();
  Vec3 result = p;
  const double by = std::ldexp(how & 128 ? -1.0 : 1.0, -(how & 63));
  if (how & 64) result[in.next() % 3] += by;
  return result;
}

// A point on the line or plane of earlier ones, at dyadic weights.
Vec3 combined_point(const Pair& earlier, int count, Bytes& in) {
  const auto pick = [&] { return earlier[in.next() % count]; };
  const Vec3 a = pick(), b = pick(), c = pick();
  const double s = (in.next() % 9 - 2) / 4.0, t = (in.next() % 9 - 2) / 4.0;
  return a + s * (b - a) + t * (c - a);
}

Pair read_pair(Bytes& in) {
  Pair pair;
  const std::uint8_t mode = in.next();
  for (int k = 0; k < 8; ++k) {
    switch (mode % 4) {
      case 0:
        pair[k] = grid_point(in);
        break;
      case 1:
        pair[k] = raw_point(in);
        break;
      case 2:
        pair[k] = nudged(grid_point(in), in);
        break;
      default:
        pair[k] = k < 3 ? grid_point(in) : nudged(combined_point(pair, k, in), in);
        break;
    }
  }
  if (mode & 4) {
    const double factor = std::ldexp(1.0, (int(in.next()) - 128) * 7);
    for (Vec3& p : pair) p *= factor;
  }
  if (mode & 8) {
    const Vec3 shift = 0x1p30 * grid_point(in);
    for (Vec3& p : pair) p += shift;
  }
  return pair;
}

[[noreturn]] void stop(const std::string& complaint) {
  fmt::print(stderr, "{}\n", complaint);
  std::abort();
}

double size_of(const FourPoints& x0, const FourPoints& x1) {
  double size = 0;
  for (int k = 0; k < 4; ++k) {
    size = std::max({size, (x0[k] - x0[0]).cwiseAbs().maxCoeff(), (x1[k] - x0[0]).cwiseAbs().maxCoeff()});
  }
  return size;
}

void check_motion(Kind kind, const Pair& pair, Bytes& in) {
  FourPoints x0, x1;
  std::copy_n(pair.begin(), 4, x0.begin());
  std::copy_n(pair.begin() + 4, 4, x1.begin());
  CcdSettings settings;
  const std::uint8_t options = in.next();
  const double size = size_of(x0, x1);
  if (options & 1) settings.tolerance = std::ldexp(size, -int(in.next() % 40));
  if (options & 2) settings.latest = (in.next() % 65) / 64.0;
  if (options & 4) settings.max_iterations = 1 + in.next();
  if ((options & 0x18) == 0x18) settings.thickness = std::ldexp(size, -int(in.next() % 20) - 1);
  const CcdResult result = oracle::narrow_phase(kind, x0, x1, settings);
  const oracle::Verdict verdict = oracle::judge(kind, x0, x1, settings, result);
  if (!verdict.complaint.empty()) stop(verdict.complaint + "\n" + oracle::describe(kind, x0, x1, settings));
}

void check_static(const Pair& p) {
  const auto expect = [&](bool same, const char* what) {
    if (same) return;
    std::string text = what;
    for (const Vec3& v : p) text += fmt::format("\n  Vec3({:a}, {:a}, {:a}),", v.x(), v.y(), v.z());
    stop(text);
  };
  for (int k = 0; k + 4 <= 8; ++k) {
    expect(orient3d(p[k], p[k + 1], p[k + 2], p[k + 3]) ==
               oracle::orientation(p[k], p[k + 1], p[k + 2], p[k + 3]),
           "orient3d");
    expect(triangles_fold(p[k], p[k + 1], p[k + 2], p[k + 3]) ==
               oracle::meet_beyond_edge(p[k], p[k + 1], p[k + 2], p[k + 3]),
           "triangles_fold");
  }
  const std::array<Vec3, 3> a = {p[0], p[1], p[2]}, b = {p[3], p[4], p[5]};
  const std::array<Vec3, 2> s = {p[6], p[7]};
  expect(triangles_intersect(a, b) == oracle::hulls_intersect(a, b), "triangles_intersect");
  expect(segment_intersects_triangle(s, a) == oracle::hulls_intersect(s, a), "segment_intersects_triangle");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Bytes in(data, size);
  const std::uint8_t first = in.next();
  const Pair pair = read_pair(in);
  check_motion(first & 1 ? Kind::VertexFace : Kind::EdgeEdge, pair, in);
  if (first & 2) check_static(pair);
  return 0;
}
