// Theorem 2's inequality and the margin that rounding needs, in exact rational arithmetic, for charts that
// hold.
#include <gtest/gtest.h>

#include "certificate/inside.h"
#include "certificate/patches.h"
#include "oracle/oracle.h"

namespace foldproof::testing {
namespace {

using oracle::Rational;

// A vector of the plane or of space; exact.
template <int N>
using Exact = std::array<Rational, N>;

Exact<3> exact(const Vec3& v) { return {Rational(v.x()), Rational(v.y()), Rational(v.z())}; }

// W^T v.
Exact<2> pulled(const UsedInTest& used, const Exact<3>& v) {
  Exact<2> result{};
  for (int k = 0; k < 2; ++k) {
    for (int axis = 0; axis < 3; ++axis) result[k] += Rational(used.w[k][axis]) * v[axis];
  }
  return result;
}

template <int N>
Exact<N> minus(const Exact<N>& a, const Exact<N>& b) {
  Exact<N> d;
  for (int k = 0; k < N; ++k) d[k] = a[k] - b[k];
  return d;
}
Rational dot(const Exact<2>& a, const Exact<2>& b) { return a[0] * b[0] + a[1] * b[1]; }

// What lambda must be for the gap alone, rounded down: gap |W| / least altitude, |W| not above the Frobenius
// norm.
double lambda_for_gap(const UsedInTest& used, const ChartLibrary::Fit& fit, double gap) {
  double square = 0;
  for (const auto& column : used.w) {
    for (const float c : column) square += double{c} * c;
  }
  return gap * std::sqrt(square) / fit.least_altitude;
}

// The least eigenvalue of the symmetric part of W^T G - lambda I is above zero: by its trace and determinant
// in the basis of the triangle's sides, K = E^T (W^T G - lambda I) E.
bool forward(const Exact<2> (&e)[2], const Exact<2> (&y)[2], const Rational& lambda) {
  const auto form = [&](int i, int j) { return dot(e[i], y[j]) - lambda * dot(e[i], e[j]); };
  const Rational k11 = form(0, 0), k22 = form(1, 1), twice_k12 = form(0, 1) + form(1, 0);
  return k11 > 0 && k22 > 0 && 4 * k11 * k22 > twice_k12 * twice_k12;
}

struct Held {
  Patch patch;
  Drawing drawing;
  Chart chart;
  Step step;
  double gap;
};

// Charts that hold at a step, where the motion is as large as may be: the least room is left.
std::vector<Held> held(Rng& rng, int rounds) {
  std::vector<Held> all;
  ChartScratch scratch;
  for (int round = 0; round < rounds; ++round) {
    for (const PosedPatch& p : drawable_patches(rng)) {
      Drawing drawing;
      if (draw(p.patch, p.x, drawing) != ChartOutcome::Made) continue;
      const Chart chart(p.patch, drawing);
      const double gap = round % 2 ? log_uniform(rng, 1e-6, 1e-2) : 0;
      const Step start(p.x, p.x);
      if (!chart_holds(chart.view(), start.vertices, gap, scratch)) continue;
      const Step end = random_step(p, log_uniform(rng, 0.01, 1), rng);
      // Between the pose that was drawn and a random step, the last that holds.
      const auto mixed = [&](double s) {
        std::vector<Vec3> x0, x1;
        for (std::size_t v = 0; v < p.x.size(); ++v) {
          x0.push_back((1 - s) * start.x0[v] + s * end.x0[v]);
          x1.push_back((1 - s) * start.x1[v] + s * end.x1[v]);
        }
        return Step(std::move(x0), std::move(x1));
      };
      double low = 0, high = 1;
      for (int k = 0; k < 40; ++k) {
        const double middle = (low + high) / 2;
        (chart_holds(chart.view(), mixed(middle).vertices, gap, scratch) ? low : high) = middle;
      }
      all.push_back({p.patch, drawing, chart, mixed(low), gap});
    }
  }
  return all;
}

TEST(Margins, EveryTriangleOfThePatchMovesForwardExactly) {
  Rng rng(31);
  double least_room = 1e300;
  const std::vector<Held> all = held(rng, 8);
  EXPECT_GE(all.size(), 40u);
  for (const Held& h : all) {
    const UsedInTest used = used_in_test(h.chart.view(), h.step.vertices, h.gap);
    const double needed = lambda_for_gap(used, h.chart.fit, h.gap);
    ASSERT_GT(used.lambda, needed);
    double room = used.lambda - needed;
    for (const auto* x : {&h.step.x0, &h.step.x1}) {
      const auto forward_with = [&](double lambda) {
        for (const auto& t : h.chart.triangles) {
          // Fillers at the square's corners are exempt: the corners are wherever they do not disturb.
          if (std::max({t[0], t[1], t[2]}) >= h.patch.vertices.size()) continue;
          Exact<2> e[2], y[2];
          for (int k = 0; k < 2; ++k) {
            const Place a = h.drawing.places[t[k + 1]], b = h.drawing.places[t[0]];
            e[k] = {Rational(a[0] - b[0]), Rational(a[1] - b[1])};
            y[k] = pulled(used, minus<3>(exact((*x)[t[k + 1]]), exact((*x)[t[0]])));
          }
          if (!forward(e, y, Rational(lambda))) return false;
        }
        return true;
      };
      ASSERT_TRUE(forward_with(needed));
      // How much of the margin is left over, from what the exact form allows.
      double low = needed, high = 2 * used.lambda;
      for (int k = 0; k < 12; ++k) {
        const double middle = (low + high) / 2;
        (forward_with(middle) ? low : high) = middle;
      }
      room = std::min(room, low - needed);
    }
    least_room = std::min(least_room, room / (used.lambda - needed));
  }
  // The bound is for the worst case; a usual one needs little of it. And lambda is what the test did enforce,
  // so that the margin is not idle: the largest lambda that the exact form allows is near it.
  EXPECT_GT(least_room, 0.5);
  EXPECT_LT(least_room, 1.01);
}

// (W u) . (x_a - x_b) >= lambda |u|^2 for points a and b of the patch, wherever they are, at any time.
TEST(Margins, TheInequalityHoldsBetweenAnyTwoPoints) {
  Rng rng(32);
  const std::vector<Held> all = held(rng, 3);
  EXPECT_GE(all.size(), 15u);
  for (const Held& h : all) {
    const UsedInTest used = used_in_test(h.chart.view(), h.step.vertices, h.gap);
    const Rational lambda(lambda_for_gap(used, h.chart.fit, h.gap));
    struct Point {
      Exact<2> place;
      Exact<3> x;
    };
    const auto random_point = [&](const Rational& time) {
      const auto& t = h.patch.triangles[rng() % h.patch.triangles.size()];
      std::int64_t weight[3], sum = 0;
      for (auto& w : weight) sum += w = static_cast<std::int64_t>(rng() % 4 == 0 ? 0 : rng() % 64 + 1);
      if (sum == 0) sum = weight[0] = 1;
      Point p{};
      for (int k = 0; k < 3; ++k) {
        const Rational w(weight[k], sum);
        const Exact<3> x0 = exact(h.step.x0[t[k]]), x1 = exact(h.step.x1[t[k]]);
        for (int c = 0; c < 2; ++c) p.place[c] += w * h.drawing.places[t[k]][c];
        for (int c = 0; c < 3; ++c) p.x[c] += w * (x0[c] + time * (x1[c] - x0[c]));
      }
      return p;
    };
    for (int k = 0; k < 200; ++k) {
      const Rational time(static_cast<int>(rng() % 9), 8);
      const Point a = random_point(time), b = random_point(time);
      const Exact<2> u = minus<2>(a.place, b.place);
      ASSERT_GE(dot(u, pulled(used, minus<3>(a.x, b.x))), lambda * dot(u, u));
    }
  }
}

// Features without a common vertex lie at least this far apart in the picture.
TEST(Margins, LeastAltitudeIsNotAboveAnyDistanceInThePicture) {
  Rng rng(33);
  for (const PosedPatch& p : drawable_patches(rng)) {
    Drawing drawing;
    ASSERT_EQ(draw(p.patch, p.x, drawing), ChartOutcome::Made);
    const Chart chart(p.patch, drawing);
    for (const auto& t : chart.triangles) {
      for (int k = 0; k < 3; ++k) {
        const auto &a = chart.points[t[k]], &b = chart.points[t[(k + 1) % 3]],
                   &c = chart.points[t[(k + 2) % 3]];
        const Exact<2> e{Rational(b[0]) - a[0], Rational(b[1]) - a[1]},
            f{Rational(c[0]) - a[0], Rational(c[1]) - a[1]};
        const Rational area = e[0] * f[1] - e[1] * f[0], altitude(chart.fit.least_altitude);
        ASSERT_GE(area * area, altitude * altitude * dot(e, e)) << p.name;
      }
    }
  }
}

// What statistics are told about a chart agrees with what is tested.
TEST(Margins, TheNumberForStatisticsIsPositiveWhereTheChartHolds) {
  Rng rng(34);
  ChartScratch scratch;
  int holds = 0, fails = 0;
  for (int round = 0; round < 20; ++round) {
    for (const PosedPatch& p : drawable_patches(rng)) {
      Drawing drawing;
      if (draw(p.patch, p.x, drawing) != ChartOutcome::Made) continue;
      const Chart chart(p.patch, drawing);
      const Step step = random_step(p, log_uniform(rng, 0.01, 1), rng);
      const double margin = chart_margin(chart.view(), step.vertices, scratch);
      const bool held = chart_holds(chart.view(), step.vertices, 0, scratch);
      EXPECT_GE(margin, -1) << p.name;
      EXPECT_LE(margin, 1) << p.name;
      if (std::abs(margin) > 1e-9) {
        EXPECT_EQ(margin > 0, held) << p.name << ": " << margin;
        ++(held ? holds : fails);
      }
      if (margin > 0) {  // stopping early never makes it larger than it is allowed to be
        EXPECT_LE(chart_margin(chart.view(), step.vertices, scratch, margin + 0.5), margin + 0.5);
        EXPECT_EQ(chart_margin(chart.view(), step.vertices, scratch, margin / 2), margin);
      }
    }
  }
  EXPECT_GT(holds, 20);
  EXPECT_GT(fails, 20);
}

}  // namespace
}  // namespace foldproof::testing
