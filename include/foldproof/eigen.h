/// For programs that use Eigen: its vectors and matrices from and to what the library takes. Needs Eigen 3.4.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "foldproof/base.h"

namespace foldproof {

inline Eigen::Vector3d to_eigen(const Vec3& v) { return {v.x(), v.y(), v.z()}; }

/// From a column, a row or an expression of three numbers.
template <class Derived>
Vec3 to_vec3(const Eigen::MatrixBase<Derived>& v) {
  const Eigen::Vector3d x = v;
  return {x[0], x[1], x[2]};
}

/// Positions, one per row, in the order in which the library takes them.
using PositionMatrix = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;

/// The matrix's own numbers, which it must outlive.
inline std::span<const double> positions_of(const PositionMatrix& x) {
  return {x.data(), static_cast<std::size_t>(x.size())};
}
/// Copies: columns of another matrix are stored one after the other.
template <class Derived>
std::vector<double> positions_of(const Eigen::MatrixBase<Derived>& x) {
  std::vector<double> out(static_cast<std::size_t>(x.size()));
  Eigen::Map<PositionMatrix>(out.data(), x.rows(), 3) = x;
  return out;
}
/// The numbers of the library, or of a vector of them, as a matrix with one position per row.
inline Eigen::Map<const PositionMatrix> as_rows(std::span<const double> positions) {
  return {positions.data(), static_cast<Eigen::Index>(positions.size() / 3), 3};
}

/// Rows of `count` vertex ids: triangles, edges.
template <std::size_t count, class Derived>
std::vector<std::array<Index, count>> ids_of(const Eigen::MatrixBase<Derived>& rows) {
  std::vector<std::array<Index, count>> out(static_cast<std::size_t>(rows.rows()));
  for (std::size_t i = 0; i < out.size(); ++i) {
    for (std::size_t k = 0; k < count; ++k)
      out[i][k] = static_cast<Index>(rows(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)));
  }
  return out;
}

}  // namespace foldproof
