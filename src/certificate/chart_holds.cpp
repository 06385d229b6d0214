#include "certificate/chart_holds.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#undef HWY_TARGET_INCLUDE  // Highway compiles this file once per instruction set
#define HWY_TARGET_INCLUDE "certificate/chart_holds.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef FOLDPROOF_CHART_HOLDS_ONCE
#define FOLDPROOF_CHART_HOLDS_ONCE
namespace foldproof::internal {

/// Moments of a patch at both ends of the step, relative to its first vertex: sums of offsets, sums of their
/// products with u, v and height, and the largest absolute coordinates.
struct Moments {
  alignas(32) float sum[8], products[3][8], extent[8];
};

/// The 4 in 4 det > 0, reduced to allow for the rounding of the products (S3).
inline constexpr double kNearlyFour = 4 * (1 - 0x1p-48);
/// Assumptions of the margin lambda (S3). Charts and pull-backs beyond them prove nothing.
inline constexpr float kMinAltitude = 4;
inline constexpr double kMinMapped = 1400, kMaxMapped = 0x1p18;
/// (1 - 2^-4)^2: the limit on the square of a triangle's change (S3a).
inline constexpr float kMaxSquaredChange = 0.878f;

/// W of Theorem 2 and the margin lambda.
struct PullBack {
  float column[2][3];
  float margin;
};

}  // namespace foldproof::internal
#endif

HWY_BEFORE_NAMESPACE();
namespace foldproof::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Computes offsets from the first vertex and their moments. All instruction sets use the same operations in
// the same order, so the results are the same on every machine.
void ComputeMoments(const ChartView& chart, std::span<const MovingVertex> vertices, ChartScratch& scratch,
                    Moments& m) {
  const hn::CappedTag<float, 8> d;
  const std::size_t n = chart.vertices.size();
  for (std::size_t lane = 0; lane < 8; lane += hn::Lanes(d)) {
    const auto origin = hn::Load(d, vertices[chart.vertices[0]].x + lane);
    auto sum = hn::Zero(d), with_u = sum, with_v = sum, with_height = sum, extent = sum;
    for (std::size_t i = 0; i < n; ++i) {
      const auto offset = hn::Sub(hn::Load(d, vertices[chart.vertices[i]].x + lane), origin);
      hn::Store(offset, d, scratch.offsets[i].x + lane);
      sum = hn::Add(sum, offset);
      with_u = hn::Add(with_u, hn::Mul(offset, hn::Set(d, chart.points[i][0])));
      with_v = hn::Add(with_v, hn::Mul(offset, hn::Set(d, chart.points[i][1])));
      with_height = hn::Add(with_height, hn::Mul(offset, hn::Set(d, chart.points[i][2])));
      extent = hn::Max(extent, hn::Abs(offset));
    }
    hn::Store(sum, d, m.sum + lane);
    hn::Store(with_u, d, m.products[0] + lane);
    hn::Store(with_v, d, m.products[1] + lane);
    hn::Store(with_height, d, m.products[2] + lane);
    hn::Store(extent, d, m.extent + lane);
  }
  for (std::size_t i = 0; i < chart.points.size(); ++i) {
    float* uv_twice = scratch.uvs[i].x;
    uv_twice[0] = uv_twice[2] = chart.points[i][0];
    uv_twice[1] = uv_twice[3] = chart.points[i][1];
  }
}

// Pulls every vertex back to the plane: W^T x - lambda uv, at t = 0 and at t = 1.
void PullBackVertices(const PullBack& w, std::size_t count, ChartScratch& scratch) {
  const hn::CappedTag<float, 8> d;
  const std::size_t step = hn::Lanes(d);
  const float* offsets = scratch.offsets[0].x;
  float *mapped = scratch.mapped[0].x, *changes = scratch.changes[0].x;
  const float* uvs = scratch.uvs[0].x;
  const auto margin = hn::Set(d, w.margin);
  for (std::size_t row = 0; row < 2 * count; row += step) {  // a row: one vertex at one end
    hn::Vec<decltype(d)> x, y, z, zero;
    hn::LoadInterleaved4(d, offsets + 4 * row, x, y, z, zero);
    const auto along = [&](const float(&c)[3]) {
      return hn::Add(hn::Add(hn::Mul(x, hn::Set(d, c[0])), hn::Mul(y, hn::Set(d, c[1]))),
                     hn::Mul(z, hn::Set(d, c[2])));
    };
    hn::StoreInterleaved2(along(w.column[0]), along(w.column[1]), d, mapped + 2 * row);
    for (std::size_t k = 2 * row; k < 2 * row + 2 * step; k += step) {
      const auto uv = hn::LoadU(d, uvs + k);
      const auto at = hn::Sub(hn::LoadU(d, mapped + k), hn::Mul(margin, uv));
      hn::StoreU(at, d, mapped + k);
      hn::StoreU(hn::Sub(at, uv), d, changes + k);
    }
  }
}

// The square's corners are not part of the mesh, so their positions may be chosen freely. Here each is pulled
// back to its own uv, shifted by the mean of the patch.
void PullBackCorners(const ChartView& chart, const Moments& m, const PullBack& w, ChartScratch& scratch) {
  const std::size_t count = chart.vertices.size();
  for (int end = 0; end < 2; ++end) {
    for (int k = 0; k < 2; ++k) {
      float mean = 0;
      for (int axis = 0; axis < 3; ++axis) mean += w.column[k][axis] * m.sum[4 * end + axis];
      const float shift = mean / static_cast<float>(count) - chart.fit.mean[k];
      for (std::size_t i = count; i < chart.points.size(); ++i) {
        const float uv = chart.points[i][k];
        const float at = (uv + shift) - w.margin * uv;
        scratch.mapped[i].x[2 * end + k] = at;
        scratch.changes[i].x[2 * end + k] = at - uv;
      }
    }
  }
}

// Applies the cheap test of S3a: triangles whose sides change little in the plane pass. Appends the others to
// scratch.unproven.
#if HWY_TARGET == HWY_SCALAR
void FindUnproven(const ChartView& chart, std::size_t begin, std::size_t end, ChartScratch& scratch) {
  for (std::size_t i = begin; i < end; ++i) {
    const auto& t = chart.triangles[i];
    for (int c = 0; c < 4; c += 2) {
      const auto change = [&](int k, int axis) {
        return scratch.changes[t[k]].x[c + axis] - scratch.changes[t[0]].x[c + axis];
      };
      const auto square = [&](int axis) {
        return change(1, axis) * change(1, axis) + change(2, axis) * change(2, axis);
      };
      if (!((square(0) + square(1)) * chart.weights[i] < kMaxSquaredChange)) {
        scratch.unproven.push_back(t);
        break;
      }
    }
  }
}
#else
void FindUnproven(const ChartView& chart, std::size_t begin, std::size_t end, ChartScratch& scratch) {
  const hn::CappedTag<float, 8> d;  // one or two triangles, both ends of each
  const hn::CappedTag<float, 4> d4;
  constexpr std::size_t kStep = hn::MaxLanes(d) / 4;
  const auto both = [&](auto a, [[maybe_unused]] auto b) {
    if constexpr (kStep == 2) {
      return hn::Combine(d, b, a);
    } else {
      return a;
    }
  };
  const auto limit = hn::Set(d, kMaxSquaredChange);
  for (std::size_t i = begin; i < end; i += kStep) {
    const std::size_t last = std::min(i + kStep, end) - 1;
    const auto &t = chart.triangles[i], &u = chart.triangles[last];
    const auto corner = [&](int k) {
      return both(hn::Load(d4, scratch.changes[t[k]].x), hn::Load(d4, scratch.changes[u[k]].x));
    };
    const auto from = corner(0);
    const auto first = hn::Sub(corner(1), from), second = hn::Sub(corner(2), from);
    const auto square = hn::Add(hn::Mul(first, first), hn::Mul(second, second));
    const auto sum = hn::Add(square, hn::Shuffle2301(square));
    const auto weight = both(hn::Set(d4, chart.weights[i]), hn::Set(d4, chart.weights[last]));
    if (HWY_LIKELY(hn::AllTrue(d, hn::Lt(hn::Mul(sum, weight), limit)))) continue;
    scratch.unproven.push_back(t);
    if (last != i) scratch.unproven.push_back(u);
  }
}
#endif

// The test of Theorem 2 (S1): the symmetric part of E^T eta is positive definite for every triangle at both
// ends. Sides are floats, so their products are exact in double. In float, rounding could hide a thin
// triangle that turns over (docs/soundness.md, S3; tests/arithmetic: Conversions.FloatToDoubleIsExact,
// Rounding).
#if HWY_TARGET == HWY_SCALAR
bool AllPositiveDefinite(std::span<const std::array<std::uint16_t, 3>> triangles,
                         const ChartScratch& scratch) {
  for (const auto& t : triangles) {
    const auto side = [&](const std::vector<ChartScratch::Quad>& rows, int k, int c) {
      return double{rows[t[k]].x[c] - rows[t[0]].x[c]};
    };
    for (int end = 0; end < 4; end += 2) {
      const auto form = [&](int i, int k) {
        return side(scratch.uvs, i, end) * side(scratch.mapped, k, end) +
               side(scratch.uvs, i, end + 1) * side(scratch.mapped, k, end + 1);
      };
      const auto& e = scratch.uvs;
      const auto& y = scratch.mapped;
      const double k11 = form(1, 1), k22 = form(2, 2);
      const double k12 =
          (side(e, 1, end) * side(y, 2, end) + side(e, 2, end) * side(y, 1, end)) +
          (side(e, 1, end + 1) * side(y, 2, end + 1) + side(e, 2, end + 1) * side(y, 1, end + 1));
      if (!(k11 > 0 && k22 > 0 && k11 * k22 * kNearlyFour > k12 * k12)) return false;
    }
  }
  return true;
}
#else
bool AllPositiveDefinite(std::span<const std::array<std::uint16_t, 3>> triangles,
                         const ChartScratch& scratch) {
  const hn::CappedTag<double, 4> d;
  const hn::Rebind<float, decltype(d)> df;
  const auto zero = hn::Zero(d), nearly_four = hn::Set(d, kNearlyFour);
  auto positive = hn::Eq(zero, zero);
  std::size_t until_check = 8;
  for (const auto& t : triangles) {
    for (std::size_t lane = 0; lane < 4; lane += hn::Lanes(d)) {  // both ends at once, or one after the other
      const auto side = [&](const std::vector<ChartScratch::Quad>& rows, int k) {
        return hn::PromoteTo(d,
                             hn::Sub(hn::Load(df, rows[t[k]].x + lane), hn::Load(df, rows[t[0]].x + lane)));
      };
      const auto e1 = side(scratch.uvs, 1), e2 = side(scratch.uvs, 2);
      const auto eta1 = side(scratch.mapped, 1), eta2 = side(scratch.mapped, 2);
      const auto a = hn::Mul(e1, eta1), b = hn::Mul(e2, eta2);
      const auto c = hn::Add(hn::Mul(e1, eta2), hn::Mul(e2, eta1));
      // k11(0) k22(0) k11(1) k22(1); twice: 2 k12(0) 2 k12(1)
      const auto k = hn::Add(hn::InterleaveLower(d, a, b), hn::InterleaveUpper(d, a, b));
      const auto k12 = hn::Add(hn::InterleaveLower(d, c, c), hn::InterleaveUpper(d, c, c));
      const auto product = hn::Mul(hn::Mul(k, hn::Shuffle01(k)), nearly_four);
      positive = hn::And(positive, hn::And(hn::Gt(k, zero), hn::Gt(product, hn::Mul(k12, k12))));
    }
    if (--until_check == 0) {
      if (!hn::AllTrue(d, positive)) return false;
      until_check = 8;
    }
  }
  return hn::AllTrue(d, positive);
}
#endif

// The first triangle from `from` on with a min_stretch of at most `limit` at either end. For statistics, not
// for proofs.
#if HWY_TARGET == HWY_SCALAR
std::size_t FirstBelow(const ChartView&, const ChartScratch&, std::size_t from, double) { return from; }
#else
std::size_t FirstBelow(const ChartView& chart, const ChartScratch& scratch, std::size_t from, double limit) {
  const hn::CappedTag<double, 4> d;
  const hn::Rebind<float, decltype(d)> df;
  const auto zero = hn::Zero(d), four = hn::Set(d, 4), stretch = hn::Set(d, limit);
  for (std::size_t i = from; i < chart.triangles.size(); ++i) {
    const auto& t = chart.triangles[i];
    for (std::size_t lane = 0; lane < 4; lane += hn::Lanes(d)) {
      const auto side = [&](const std::vector<ChartScratch::Quad>& rows, int k) {
        return hn::PromoteTo(d,
                             hn::Sub(hn::Load(df, rows[t[k]].x + lane), hn::Load(df, rows[t[0]].x + lane)));
      };
      const auto e1 = side(scratch.uvs, 1), e2 = side(scratch.uvs, 2);
      const auto y1 = hn::Sub(side(scratch.mapped, 1), hn::Mul(stretch, e1)),
                 y2 = hn::Sub(side(scratch.mapped, 2), hn::Mul(stretch, e2));
      const auto a = hn::Mul(e1, y1), b = hn::Mul(e2, y2), c = hn::Add(hn::Mul(e1, y2), hn::Mul(e2, y1));
      const auto k = hn::Add(hn::InterleaveLower(d, a, b), hn::InterleaveUpper(d, a, b));
      const auto k12 = hn::Add(hn::InterleaveLower(d, c, c), hn::InterleaveUpper(d, c, c));
      const auto product = hn::Mul(hn::Mul(k, hn::Shuffle01(k)), four);
      if (!hn::AllTrue(d, hn::And(hn::Gt(k, zero), hn::Gt(product, hn::Mul(k12, k12))))) return i;
    }
  }
  return chart.triangles.size();
}
#endif

}  // namespace foldproof::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace foldproof::internal {

HWY_EXPORT(ComputeMoments);
HWY_EXPORT(PullBackVertices);
HWY_EXPORT(PullBackCorners);
HWY_EXPORT(FindUnproven);
HWY_EXPORT(AllPositiveDefinite);
HWY_EXPORT(FirstBelow);

namespace {

// S2. W^T = the first two rows of A^-1, where A is the affine map that takes uvs and heights to the mean of
// both ends by least squares. Any W is valid. This one maps every affine image of the chart's pose back to
// the uvs. On a flat patch the heights do not determine A's third column; there the ridge makes it the
// normal.
bool fit_pull_back(const ChartLibrary::Fit& fit, const Moments& m, PullBack& w) {
  Vec3 products[3];
  for (int axis = 0; axis < 3; ++axis) {
    const double sum = (double{m.sum[axis]} + m.sum[4 + axis]) / 2;
    for (int k = 0; k < 3; ++k) {
      products[k][axis] = (double{m.products[k][axis]} + m.products[k][4 + axis]) / 2 - sum * fit.mean[k];
    }
  }
  const Vec3 tangent_u = products[0] * fit.inverse_moments_2d[0] + products[1] * fit.inverse_moments_2d[1];
  const Vec3 tangent_v = products[0] * fit.inverse_moments_2d[1] + products[1] * fit.inverse_moments_2d[2];
  const Vec3 normal = tangent_u.cross(tangent_v);
  const double area = normal.norm();
  if (!(area > 0)) return false;
  products[2] += normal * (fit.ridge / std::sqrt(area));
  const float* s = fit.inverse_moments_3d;
  const Vec3 a_x = products[0] * s[0] + products[1] * s[1] + products[2] * s[2];
  const Vec3 a_y = products[0] * s[1] + products[1] * s[3] + products[2] * s[4];
  const Vec3 a_z = products[0] * s[2] + products[1] * s[4] + products[2] * s[5];
  const Vec3 row_x = a_y.cross(a_z), row_y = a_z.cross(a_x);
  const double det = a_x.dot(row_x);
  if (!(det > 0)) return false;
  for (int axis = 0; axis < 3; ++axis) {
    w.column[0][axis] = static_cast<float>(row_x[axis] / det);
    w.column[1][axis] = static_cast<float>(row_y[axis] / det);
  }
  return true;
}

// lambda: what the form must exceed to allow for the gap and all rounding (docs/soundness.md, S3). Rounded
// up; infinite beyond the proof's assumptions.
float margin_of(const PullBack& w, const Moments& m, double min_altitude, double gap) {
  double square = 0, largest_sum = 0;
  for (const auto& column : w.column) {
    double sum = 0;
    for (const float c : column) {
      square += double{c} * c;
      sum += std::abs(double{c});
    }
    largest_sum = std::max(largest_sum, sum);
  }
  const double extent = *std::max_element(m.extent, m.extent + 8);
  const double mapped = largest_sum * extent;
  if (!(mapped >= kMinMapped && mapped < kMaxMapped && min_altitude >= kMinAltitude)) return INFINITY;
  const double rounding = largest_sum * 0x1p-24 * (3 + 64 * extent);
  const double margin = (gap * std::sqrt(square) + 3 * rounding + 0x1p-13) / min_altitude * 1.03;
  return static_cast<float>(margin) * (1 + 0x1p-20f);
}

}  // namespace

ChartLibrary::Fit fit_of(std::span<const std::array<float, 3>> points,
                         std::span<const std::array<std::uint16_t, 3>> triangles) {
  ChartLibrary::Fit fit;
  // Sums of integers: exact.
  const std::size_t count = points.size() - kChartCorners.size();
  double sum[3] = {}, square_sum[6] = {};
  for (const auto& p : points.first(count)) {
    const double x = p[0], y = p[1], z = p[2];
    const double products[6] = {x * x, x * y, x * z, y * y, y * z, z * z};
    for (int k = 0; k < 6; ++k) square_sum[k] += products[k];
    for (int k = 0; k < 3; ++k) sum[k] += p[k];
  }
  const auto n = static_cast<double>(count);
  const Vec3 mean(sum[0] / n, sum[1] / n, sum[2] / n);
  Eigen::Matrix3d second;
  for (int k = 0, i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) second(i, j) = second(j, i) = square_sum[k++] - sum[i] * mean[j];
  }
  const double ridge = 1e-4 * (second(0, 0) + second(1, 1));
  second(2, 2) += ridge;
  const Eigen::Matrix2d inverse_2d = second.topLeftCorner<2, 2>().inverse();
  const Eigen::Matrix3d inverse_3d = second.inverse();
  for (int k = 0; k < 3; ++k) fit.mean[k] = static_cast<float>(mean[k]);
  fit.inverse_moments_2d[0] = static_cast<float>(inverse_2d(0, 0));
  fit.inverse_moments_2d[1] = static_cast<float>(inverse_2d(0, 1));
  fit.inverse_moments_2d[2] = static_cast<float>(inverse_2d(1, 1));
  for (int k = 0, i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) fit.inverse_moments_3d[k++] = static_cast<float>(inverse_3d(i, j));
  }
  fit.ridge = static_cast<float>(ridge);
  double squared_altitude = double{kChartCorners[0][0]} * kChartCorners[0][0];
  for (const auto& t : triangles) {
    double longest = 0, twice_area = 0;  // the longest side, squared
    for (int k = 0; k < 3; ++k) {
      const auto &a = points[t[k]], &b = points[t[(k + 1) % 3]];
      const double x = double{b[0]} - a[0], y = double{b[1]} - a[1];
      longest = std::max(longest, x * x + y * y);
      twice_area += double{a[0]} * b[1] - double{a[1]} * b[0];
    }
    squared_altitude = std::min(squared_altitude, twice_area * std::abs(twice_area) / longest);
  }
  fit.min_altitude = static_cast<float>(std::sqrt(squared_altitude)) * (1 - 0x1p-20f);
  return fit;
}

// S3a: the square of the norm of E^-1.
float weight_of(std::span<const std::array<float, 3>> points, const std::array<std::uint16_t, 3>& t) {
  double side[2][2];
  for (int k = 0; k < 2; ++k) {
    for (int axis = 0; axis < 2; ++axis) side[k][axis] = double{points[t[k + 1]][axis]} - points[t[0]][axis];
  }
  const double det = side[0][0] * side[1][1] - side[0][1] * side[1][0];
  const double trace =
      side[0][0] * side[0][0] + side[0][1] * side[0][1] + side[1][0] * side[1][0] + side[1][1] * side[1][1];
  // The larger eigenvalue of (E^T E)^-1.
  const double larger = (trace + std::sqrt(std::max(0.0, trace * trace - 4 * det * det))) / (2 * det * det);
  return static_cast<float>(larger * (1 + 0x1p-20));
}

namespace {

// Pulls the patch back to the plane at both ends, into the scratch. False where the chart cannot hold.
bool pull_patch_back(const ChartView& chart, std::span<const MovingVertex> vertices, double gap,
                     ChartScratch& scratch) {
  // PullBackVertices processes whole vectors of rows. No triangle reads the rows behind the last vertex.
  const std::size_t padded = (chart.points.size() + 7) / 8 * 8;
  if (scratch.offsets.size() < padded) {
    scratch.offsets.resize(padded);
    scratch.uvs.resize(padded);
    scratch.mapped.resize(padded);
    scratch.changes.resize(padded);
  }
  Moments moments;
  HWY_DYNAMIC_DISPATCH(ComputeMoments)(chart, vertices, scratch, moments);
  PullBack w;
  if (!fit_pull_back(chart.fit, moments, w)) return false;
  w.margin = margin_of(w, moments, chart.fit.min_altitude, gap);
  if (!(w.margin < 1)) return false;
  HWY_DYNAMIC_DISPATCH(PullBackVertices)(w, chart.vertices.size(), scratch);
  HWY_DYNAMIC_DISPATCH(PullBackCorners)(chart, moments, w, scratch);
  return true;
}

// The smallest eigenvalue of the symmetric part of the map from a triangle's uvs to its pull-back.
double min_stretch(const ChartScratch& scratch, const std::array<std::uint16_t, 3>& t, int end) {
  Eigen::Matrix2d e, eta;
  for (int k = 0; k < 2; ++k) {
    for (int axis = 0; axis < 2; ++axis) {
      const int c = end + axis;
      e(axis, k) = double{scratch.uvs[t[k + 1]].x[c]} - scratch.uvs[t[0]].x[c];
      eta(axis, k) = double{scratch.mapped[t[k + 1]].x[c]} - scratch.mapped[t[0]].x[c];
    }
  }
  const Eigen::Matrix2d map = eta * e.inverse();
  const double mean = map.trace() / 2, skew = (map(0, 0) - map(1, 1)) / 2,
               shear = (map(0, 1) + map(1, 0)) / 2;
  return mean - std::sqrt(skew * skew + shear * shear);
}

}  // namespace

bool chart_holds(const ChartView& chart, std::span<const MovingVertex> vertices, double gap,
                 ChartScratch& scratch) {
  if (!pull_patch_back(chart, vertices, gap, scratch)) return false;
  constexpr std::size_t kBlock = 128;  // triangles between two exact tests of unproven ones
  for (std::size_t begin = 0; begin < chart.triangles.size(); begin += kBlock) {
    scratch.unproven.clear();
    HWY_DYNAMIC_DISPATCH(FindUnproven)
    (chart, begin, std::min(begin + kBlock, chart.triangles.size()), scratch);
    if (!scratch.unproven.empty() && !HWY_DYNAMIC_DISPATCH(AllPositiveDefinite)(scratch.unproven, scratch))
      return false;
  }
  return true;
}

double chart_margin(const ChartView& chart, std::span<const MovingVertex> vertices, ChartScratch& scratch,
                    double enough) {
  if (!pull_patch_back(chart, vertices, 0, scratch)) return -1;
  double margin = 1;
  // FirstBelow needs no root and finds the few triangles that lower the margin.
  for (std::size_t i = 0;
       (i = HWY_DYNAMIC_DISPATCH(FirstBelow)(chart, scratch, i, margin)) < chart.triangles.size(); ++i) {
    for (const int end : {0, 2}) margin = std::min(margin, min_stretch(scratch, chart.triangles[i], end));
    if (!(margin > enough)) return std::max(margin, -1.);
  }
  return margin;
}

}  // namespace foldproof::internal
#endif  // HWY_ONCE
