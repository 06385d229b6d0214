// Theorem 2's inequality and the margin for rounding, in exact rational arithmetic, for charts that hold.
#include <gtest/gtest.h>

#include "certificate/inside.h"
#include "certificate/patches.h"
#include "oracle/oracle.h"

namespace foldproof::testing {
namespace {

using oracle::Rational;

// A vector in the plane or in space; exact.
template <int N>
using Exact = std::array<Rational, N>;

Exact<3> exact(const Vec3& v) { return {Rational(v.x()), Rational(v.y()), Rational(v.z())}; }

// W^T v.
Exact<2> pulled(const PullBackUsed& used, const Exact<3>& v) {
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

// The lambda that the gap alone requires, rounded down: gap |W| / smallest altitude, with |W| at most the
// Frobenius norm.
double lambda_for_gap(const PullBackUsed& used, const ChartLibrary::Fit& fit, double gap) {
  double square = 0;
  for (const auto& column : used.w) {
    for (const float c : column) square += double{c} * c;
  }
  return gap * std::sqrt(square) / fit.min_altitude;
}

// Whether the symmetric part of W^T G - lambda I is positive definite: by the diagonal and the determinant of
// K = E^T (W^T G - lambda I) E, with the triangle's sides E.
bool positive_definite(const Exact<2> (&e)[2], const Exact<2> (&y)[2], const Rational& lambda) {
  const auto form = [&](int i, int j) { return dot(e[i], y[j]) - lambda * dot(e[i], e[j]); };
  const Rational k11 = form(0, 0), k22 = form(1, 1), twice_k12 = form(0, 1) + form(1, 0);
  return k11 > 0 && k22 > 0 && 4 * k11 * k22 > twice_k12 * twice_k12;
}

struct HoldingChart {
  Patch patch;
  UvMap uv_map;
  Chart chart;
  Step step;
  double gap;
};

// Charts that hold in a step that is nearly too large, so that little slack is left.
std::vector<HoldingChart> holding_charts(Rng& rng, int rounds) {
  std::vector<HoldingChart> all;
  ChartScratch scratch;
  for (int round = 0; round < rounds; ++round) {
    for (const PosedPatch& p : chartable_patches(rng)) {
      UvMap uv_map;
      if (parametrize(p.patch, p.x, uv_map) != ChartOutcome::Made) continue;
      const Chart chart(p.patch, uv_map);
      const double gap = round % 2 ? log_uniform(rng, 1e-6, 1e-2) : 0;
      const Step start(p.x, p.x);
      if (!chart_holds(chart.view(), start.vertices, gap, scratch)) continue;
      const Step end = random_step(p, log_uniform(rng, 0.01, 1), rng);
      // Bisection between the chart's pose and a random step for the last step that holds.
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
      all.push_back({p.patch, uv_map, chart, mixed(low), gap});
    }
  }
  return all;
}

TEST(Margins, EveryTriangleOfThePatchIsPositiveDefiniteExactly) {
  Rng rng(31);
  double min_slack = 1e300;
  const std::vector<HoldingChart> all = holding_charts(rng, 8);
  EXPECT_GE(all.size(), 40u);
  for (const HoldingChart& h : all) {
    const PullBackUsed used = pull_back_used(h.chart.view(), h.step.vertices, h.gap);
    const double needed = lambda_for_gap(used, h.chart.fit, h.gap);
    ASSERT_GT(used.lambda, needed);
    double slack = used.lambda - needed;
    for (const auto* x : {&h.step.x0, &h.step.x1}) {
      const auto all_positive_definite = [&](double lambda) {
        for (const auto& t : h.chart.triangles) {
          // Scaffold triangles at the square's corners are exempt: those positions are chosen freely.
          if (std::max({t[0], t[1], t[2]}) >= h.patch.vertices.size()) continue;
          Exact<2> e[2], y[2];
          for (int k = 0; k < 2; ++k) {
            const Uv a = h.uv_map.uvs[t[k + 1]], b = h.uv_map.uvs[t[0]];
            e[k] = {Rational(a[0] - b[0]), Rational(a[1] - b[1])};
            y[k] = pulled(used, minus<3>(exact((*x)[t[k + 1]]), exact((*x)[t[0]])));
          }
          if (!positive_definite(e, y, Rational(lambda))) return false;
        }
        return true;
      };
      ASSERT_TRUE(all_positive_definite(needed));
      // The largest lambda that the exact form allows.
      double low = needed, high = 2 * used.lambda;
      for (int k = 0; k < 12; ++k) {
        const double middle = (low + high) / 2;
        (all_positive_definite(middle) ? low : high) = middle;
      }
      slack = std::min(slack, low - needed);
    }
    min_slack = std::min(min_slack, slack / (used.lambda - needed));
  }
  // The margin is for the worst case, so most of it is left here. The exact form allows hardly more than
  // lambda, so the margin was enforced.
  EXPECT_GT(min_slack, 0.5);
  EXPECT_LT(min_slack, 1.01);
}

// (W u) . (x_a - x_b) >= lambda |u|^2 for any points a and b of the patch, at any time.
TEST(Margins, TheInequalityHoldsBetweenAnyTwoPoints) {
  Rng rng(32);
  const std::vector<HoldingChart> all = holding_charts(rng, 3);
  EXPECT_GE(all.size(), 15u);
  for (const HoldingChart& h : all) {
    const PullBackUsed used = pull_back_used(h.chart.view(), h.step.vertices, h.gap);
    const Rational lambda(lambda_for_gap(used, h.chart.fit, h.gap));
    struct Point {
      Exact<2> uv;
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
        for (int c = 0; c < 2; ++c) p.uv[c] += w * h.uv_map.uvs[t[k]][c];
        for (int c = 0; c < 3; ++c) p.x[c] += w * (x0[c] + time * (x1[c] - x0[c]));
      }
      return p;
    };
    for (int k = 0; k < 200; ++k) {
      const Rational time(static_cast<int>(rng() % 9), 8);
      const Point a = random_point(time), b = random_point(time);
      const Exact<2> u = minus<2>(a.uv, b.uv);
      ASSERT_GE(dot(u, pulled(used, minus<3>(a.x, b.x))), lambda * dot(u, u));
    }
  }
}

// Features without a common vertex are at least this far apart in uv coordinates.
TEST(Margins, MinAltitudeIsNotAboveAnyAltitude) {
  Rng rng(33);
  for (const PosedPatch& p : chartable_patches(rng)) {
    UvMap uv_map;
    ASSERT_EQ(parametrize(p.patch, p.x, uv_map), ChartOutcome::Made);
    const Chart chart(p.patch, uv_map);
    for (const auto& t : chart.triangles) {
      for (int k = 0; k < 3; ++k) {
        const auto &a = chart.points[t[k]], &b = chart.points[t[(k + 1) % 3]],
                   &c = chart.points[t[(k + 2) % 3]];
        const Exact<2> e{Rational(b[0]) - a[0], Rational(b[1]) - a[1]},
            f{Rational(c[0]) - a[0], Rational(c[1]) - a[1]};
        const Rational area = e[0] * f[1] - e[1] * f[0], altitude(chart.fit.min_altitude);
        ASSERT_GE(area * area, altitude * altitude * dot(e, e)) << p.name;
      }
    }
  }
}

// chart_margin agrees with chart_holds.
TEST(Margins, ChartMarginIsPositiveWhereTheChartHolds) {
  Rng rng(34);
  ChartScratch scratch;
  int holds = 0, fails = 0;
  for (int round = 0; round < 20; ++round) {
    for (const PosedPatch& p : chartable_patches(rng)) {
      UvMap uv_map;
      if (parametrize(p.patch, p.x, uv_map) != ChartOutcome::Made) continue;
      const Chart chart(p.patch, uv_map);
      const Step step = random_step(p, log_uniform(rng, 0.01, 1), rng);
      const double margin = chart_margin(chart.view(), step.vertices, scratch);
      const bool held = chart_holds(chart.view(), step.vertices, 0, scratch);
      EXPECT_GE(margin, -1) << p.name;
      EXPECT_LE(margin, 1) << p.name;
      if (std::abs(margin) > 1e-9) {
        EXPECT_EQ(margin > 0, held) << p.name << ": " << margin;
        ++(held ? holds : fails);
      }
      if (margin > 0) {  // early termination does not raise it above the limit
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
