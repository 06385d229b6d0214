#include "statistics/tall_skinny.h"

#include <algorithm>

#undef HWY_TARGET_INCLUDE  // Highway compiles this file once per instruction set
#define HWY_TARGET_INCLUDE "statistics/tall_skinny.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace foldproof::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

constexpr Eigen::Index kTile = 4;          // columns per tile, which share loads
constexpr Eigen::Index kLanes = 8;         // partial sums of an inner product, whatever the machine's width
constexpr Eigen::Index kBlockRows = 1024;  // rows after which the partial sums are added up

// Columns [j, j + N) of out = a b, for two vectors of rows.
template <Eigen::Index N, class D>
void ProductTile(D d, const MatrixView& a, const MatrixView& b, Eigen::Index row, Eigen::Index j,
                 Eigen::MatrixXd& out) {
  const Eigen::Index step = static_cast<Eigen::Index>(hn::Lanes(d));
  hn::Vec<D> upper[N], lower[N];
  for (Eigen::Index n = 0; n < N; ++n) upper[n] = lower[n] = hn::Zero(d);
  for (Eigen::Index k = 0; k < a.cols(); ++k) {
    const double* column = a.data() + k * a.outerStride() + row;
    const auto x = hn::LoadU(d, column), y = hn::LoadU(d, column + step);
    for (Eigen::Index n = 0; n < N; ++n) {
      const auto factor = hn::Set(d, b(k, j + n));
      upper[n] = hn::Add(upper[n], hn::Mul(x, factor));
      lower[n] = hn::Add(lower[n], hn::Mul(y, factor));
    }
  }
  for (Eigen::Index n = 0; n < N; ++n) {
    hn::StoreU(upper[n], d, &out(row, j + n));
    hn::StoreU(lower[n], d, &out(row, j + n) + step);
  }
}

void Product(const MatrixView& a, const MatrixView& b, Eigen::MatrixXd& out) {
  const hn::CappedTag<double, kLanes> d;
  const Eigen::Index step = 2 * static_cast<Eigen::Index>(hn::Lanes(d));
  Eigen::Index row = 0;
  for (; row + step <= a.rows(); row += step) {
    Eigen::Index j = 0;
    for (; j + kTile <= b.cols(); j += kTile) ProductTile<kTile>(d, a, b, row, j, out);
    for (; j < b.cols(); ++j) ProductTile<1>(d, a, b, row, j, out);
  }
  for (; row < a.rows(); ++row) {
    for (Eigen::Index j = 0; j < b.cols(); ++j) {
      double sum = 0;
      for (Eigen::Index k = 0; k < a.cols(); ++k) sum += a(row, k) * b(k, j);
      out(row, j) = sum;
    }
  }
}

// sums[m][n][lane] of columns [i, i + M) of a and [j, j + N) of b over the rows, a multiple of kLanes.
template <Eigen::Index M, Eigen::Index N>
void InnerTile(const MatrixView& a, const MatrixView& b, Eigen::Index i, Eigen::Index j,
               const std::array<Eigen::Index, 2>& rows, double (&sums)[kTile][kTile][kLanes]) {
  const hn::CappedTag<double, kLanes> d;
  for (std::size_t lane = 0; lane < kLanes; lane += hn::Lanes(d)) {
    hn::Vec<decltype(d)> sum[M][N];
    for (auto& row : sum) {
      for (auto& s : row) s = hn::Zero(d);
    }
    for (Eigen::Index r = rows[0]; r < rows[1]; r += kLanes) {
      hn::Vec<decltype(d)> y[N];
      for (Eigen::Index n = 0; n < N; ++n) y[n] = hn::LoadU(d, &b.coeffRef(r, j + n) + lane);
      for (Eigen::Index m = 0; m < M; ++m) {
        const auto x = hn::LoadU(d, &a.coeffRef(r, i + m) + lane);
        for (Eigen::Index n = 0; n < N; ++n) sum[m][n] = hn::Add(sum[m][n], hn::Mul(x, y[n]));
      }
    }
    for (Eigen::Index m = 0; m < M; ++m) {
      for (Eigen::Index n = 0; n < N; ++n) hn::StoreU(sum[m][n], d, sums[m][n] + lane);
    }
  }
}

template <Eigen::Index M, Eigen::Index N>
void AddInnerTile(const MatrixView& a, const MatrixView& b, Eigen::Index i, Eigen::Index j,
                  const std::array<Eigen::Index, 2>& rows, Eigen::MatrixXd& out) {
  const Eigen::Index whole = rows[0] + (rows[1] - rows[0]) / kLanes * kLanes;
  double sums[kTile][kTile][kLanes];
  InnerTile<M, N>(a, b, i, j, {rows[0], whole}, sums);
  for (Eigen::Index m = 0; m < M; ++m) {
    for (Eigen::Index n = 0; n < N; ++n) {
      double sum = 0;
      for (const double s : sums[m][n]) sum += s;
      for (Eigen::Index r = whole; r < rows[1]; ++r) sum += a(r, i + m) * b(r, j + n);
      out(i + m, j + n) += sum;
    }
  }
}

void AddInner(const MatrixView& a, const MatrixView& b, Eigen::MatrixXd& out) {
  for (Eigen::Index begin = 0; begin < a.rows(); begin += kBlockRows) {
    const std::array<Eigen::Index, 2> rows{begin, std::min(begin + kBlockRows, a.rows())};
    Eigen::Index i = 0;
    for (; i + kTile <= a.cols(); i += kTile) {
      Eigen::Index j = 0;
      for (; j + kTile <= b.cols(); j += kTile) AddInnerTile<kTile, kTile>(a, b, i, j, rows, out);
      for (; j < b.cols(); ++j) AddInnerTile<kTile, 1>(a, b, i, j, rows, out);
    }
    for (; i < a.cols(); ++i) {
      Eigen::Index j = 0;
      for (; j + kTile <= b.cols(); j += kTile) AddInnerTile<1, kTile>(a, b, i, j, rows, out);
      for (; j < b.cols(); ++j) AddInnerTile<1, 1>(a, b, i, j, rows, out);
    }
  }
}

}  // namespace foldproof::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace foldproof::internal {

HWY_EXPORT(Product);
HWY_EXPORT(AddInner);

using Eigen::MatrixXd;

MatrixXd tall_skinny_product(const MatrixView& a, const MatrixView& b) {
  MatrixXd out(a.rows(), b.cols());
  HWY_DYNAMIC_DISPATCH(Product)(a, b, out);
  return out;
}

MatrixXd tall_skinny_inner(const MatrixView& a, const MatrixView& b) {
  MatrixXd out = MatrixXd::Zero(a.cols(), b.cols());
  HWY_DYNAMIC_DISPATCH(AddInner)(a, b, out);
  return out;
}

Eigen::Index block_rows(Eigen::Index columns) {
  constexpr Eigen::Index kNumbers = 1 << 15;  // a quarter of a megabyte
  return std::max<Eigen::Index>(16, kNumbers / std::max<Eigen::Index>(1, columns));
}

}  // namespace foldproof::internal
#endif  // HWY_ONCE
