// B2, over boxes of all sizes anywhere, compared with exact arithmetic.
#include <gtest/gtest.h>

#include <random>

#include "arithmetic/everything.h"
#include "arithmetic/exact.h"
#include "bvh/kinetic_bvh.h"
#include "foldproof/eigen.h"

namespace foldproof::testing {
namespace {

constexpr double kMax = std::numeric_limits<double>::max();

struct Box {
  Vec3 low, high;
};

// All sizes at all distances from the origin, from a few ulps to the whole range.
std::vector<Box> boxes() {
  std::mt19937_64 rng(3);
  const auto unit = [&] { return std::ldexp(static_cast<double>(rng() >> 11), -53); };
  std::vector<Box> all;
  const auto add = [&](const Vec3& middle, const Vec3& half) {
    Box box{middle - half, middle + half};
    for (int axis = 0; axis < 3; ++axis) {
      box.low[axis] = std::clamp(box.low[axis], -kMax, kMax);
      box.high[axis] = std::clamp(box.high[axis], -kMax, kMax);
    }
    all.push_back(box);
  };
  for (int size = -1074; size <= 1024; size += 3) {
    for (const int away : {-1074, -1022, -3, 0, 1, 20, 47, 49, 50, 51, 52, 53, 54, 60, 500, 2098}) {
      const double half = size < 1024 ? std::ldexp(1 + unit(), size) : kMax;
      const int far = std::min(size + away, 1023);
      const double middle = std::ldexp(1 + unit(), far) * (rng() % 2 ? 1 : -1);
      add({middle, 0, middle / 3}, {half, half / 2, 0});
      add(Vec3::Constant(middle), Vec3::Constant(half));
    }
  }
  for (double edge : edge_numbers<double>()) {
    if (!std::isfinite(edge)) continue;
    add(Vec3::Constant(edge), Vec3::Zero());
    double next = edge;
    for (int ulps = 0; ulps < 3; ++ulps) next = std::clamp(std::nextafter(next, kMax), -kMax, kMax);
    all.push_back({{edge, edge, 0}, {next, edge, 0}});
  }
  // At the end of double's range the center must not be rounded to infinity.
  double low = kMax;
  for (int ulps = 0; ulps < 200; ++ulps, low = std::nextafter(low, 0)) {
    all.push_back({{low, 0, 0}, {kMax, 1, 1}});
    all.push_back({{low, low, -kMax}, {kMax, low, -low}});
    all.push_back({{-kMax, -kMax, -kMax}, {-low, -kMax, -kMax}});
  }
  for (int bits = 0; bits < 60; ++bits)
    all.push_back({Vec3::Constant(kMax - std::ldexp(kMax, -bits)), Vec3::Constant(kMax)});
  return all;
}

// The coordinate in the frame, exactly.
Dyadic in_frame(const Frame& frame, double x, int axis) {
  return (Dyadic(x) - frame.center[axis]) * Dyadic(frame.scale);
}
bool is_below(const Dyadic& x, const Dyadic& bound) {
  return (bound - x).sign() > 0 && (bound + x).sign() > 0;
}

TEST(Frame, ScaleIsAPowerOfTwoAndCoordinatesAreBounded) {
  const Dyadic bound(9, -4);  // 1/2 + 1/16
  for (const Box& box : boxes()) {
    const Frame frame = frame_around(box.low, box.high);
    int exponent = 0;
    ASSERT_EQ(std::frexp(frame.scale, &exponent), 0.5)
        << to_eigen(box.low).transpose() << "; " << to_eigen(box.high).transpose();
    ASSERT_TRUE(frame.center.allFinite())
        << to_eigen(box.low).transpose() << "; " << to_eigen(box.high).transpose();
    for (int axis = 0; axis < 3; ++axis) {
      for (const double x : {box.low[axis], box.high[axis], box.low[axis] / 2 + box.high[axis] / 2}) {
        ASSERT_TRUE(is_below(in_frame(frame, x, axis), bound))
            << x << " between " << to_eigen(box.low).transpose() << " and " << to_eigen(box.high).transpose();
      }
    }
  }
}

std::unique_ptr<KineticBvh> one_triangle() {
  const auto topology = Topology::make(3, {{0, 1, 2}});
  const std::vector<double> x{0, 0, 0, 1, 0, 0, 0, 1, 0};
  auto hierarchy = Hierarchy::build(*topology, x, {1});
  return std::make_unique<KineticBvh>(std::make_shared<Hierarchy>(std::move(*hierarchy)));
}

// With the code of the queries, on every instruction set.
TEST(Frame, RoundingIsWithinTheBoundOfB2) {
  const Dyadic bound = Dyadic(0x1p-25) + Dyadic(0x1p-53);
  std::vector<Box> all = boxes();
  std::mt19937_64 rng(4);
  // In the frame itself: next to the midpoint of two floats, where the rounding error is largest.
  for (int k = 0; k < 2000; ++k) {
    const auto bits = std::uint32_t(rng() % std::bit_cast<std::uint32_t>(0.5f));
    const double middle = (double{std::bit_cast<float>(bits)} + std::bit_cast<float>(bits + 1)) / 2;
    all.push_back({{-0.5, -0.5, std::nextafter(middle, rng() % 2)}, {0.5, middle, 0.5}});
  }
  on_every_target([&] {
    const auto bvh = one_triangle();
    for (const Box& box : all) {
      const Frame frame = frame_around(box.low, box.high);
      if (!frame.center.allFinite()) continue;  // found above
      bvh->set_vertex(frame, 0, box.low.data(), box.high.data());
      for (int axis = 0; axis < 3; ++axis) {
        for (int end = 0; end < 2; ++end) {
          const double x = (end == 0 ? box.low : box.high)[axis];
          const Dyadic error = Dyadic(double{bvh->vertices[0].x[4 * end + axis]}) - in_frame(frame, x, axis);
          ASSERT_TRUE(is_below(error, bound + Dyadic(1, -1074)))
              << x << " in the box from " << to_eigen(box.low).transpose();
        }
      }
    }
  });
}

TEST(SeparationMargin, IsNeverBelowTheBoundOfB2) {
  const Dyadic rounding = Dyadic(0x1.1p-22);
  std::vector<double> distances;
  for (const double x : edge_numbers<double>()) {
    if (x >= 0) distances.push_back(x);
  }
  Frame frame;
  for (int exponent = -1025; exponent <= 1023; exponent += exponent > -30 && exponent < 30 ? 1 : 11) {
    frame.scale = std::ldexp(1.0, exponent);
    for (std::size_t i = exponent & 7; i < distances.size(); i += 8) {
      const double distance = distances[i];
      const float margin = separation_margin(frame, distance);
      ASSERT_TRUE(std::isfinite(margin));
      if (std::isinf(distance)) continue;
      const Dyadic required = Dyadic(frame.scale) * Dyadic(distance) + rounding;
      ASSERT_TRUE((Dyadic(double{margin}) - required).sign() >= 0 ||
                  margin == std::numeric_limits<float>::max())
          << distance << " times " << frame.scale;
    }
  }
  frame.scale = 1;
  EXPECT_EQ(separation_margin(frame, std::numeric_limits<double>::infinity()),
            std::numeric_limits<float>::max());
}

}  // namespace
}  // namespace foldproof::testing
