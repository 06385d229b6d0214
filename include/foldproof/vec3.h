/// Three doubles, so that the library's headers need no library for vectors.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace foldproof {

/// A position or direction in mesh units. Its members have Eigen's names; foldproof/eigen.h converts. Sums
/// add from x to z on every machine.
class Vec3 {
 public:
  constexpr Vec3() = default;  ///< Zero.
  constexpr Vec3(double x, double y, double z) : x_{x, y, z} {}
  /// From three numbers in a row, as an array of positions has them.
  template <class Number>
  static constexpr Vec3 load(const Number* xyz) {
    return {static_cast<double>(xyz[0]), static_cast<double>(xyz[1]), static_cast<double>(xyz[2])};
  }
  constexpr void store(double* xyz) const {
    for (std::size_t axis = 0; axis < 3; ++axis) xyz[axis] = x_[axis];
  }
  static constexpr Vec3 Zero() { return {}; }
  static constexpr Vec3 Constant(double x) { return {x, x, x}; }

  constexpr double& operator[](std::size_t axis) { return x_[axis]; }
  constexpr double operator[](std::size_t axis) const { return x_[axis]; }
  constexpr double x() const { return x_[0]; }
  constexpr double y() const { return x_[1]; }
  constexpr double z() const { return x_[2]; }
  constexpr double* data() { return x_.data(); }
  constexpr const double* data() const { return x_.data(); }
  constexpr auto begin() { return x_.begin(); }
  constexpr auto end() { return x_.end(); }
  constexpr auto begin() const { return x_.begin(); }
  constexpr auto end() const { return x_.end(); }

  constexpr bool operator==(const Vec3&) const = default;
  constexpr Vec3 operator-() const { return {-x(), -y(), -z()}; }
  constexpr Vec3& operator+=(const Vec3& v) { return *this = *this + v; }
  constexpr Vec3& operator-=(const Vec3& v) { return *this = *this - v; }
  constexpr Vec3& operator*=(double s) { return *this = *this * s; }
  constexpr Vec3& operator/=(double s) { return *this = *this / s; }
  friend constexpr Vec3 operator+(const Vec3& a, const Vec3& b) {
    return {a.x() + b.x(), a.y() + b.y(), a.z() + b.z()};
  }
  friend constexpr Vec3 operator-(const Vec3& a, const Vec3& b) {
    return {a.x() - b.x(), a.y() - b.y(), a.z() - b.z()};
  }
  friend constexpr Vec3 operator*(const Vec3& v, double s) { return {v.x() * s, v.y() * s, v.z() * s}; }
  friend constexpr Vec3 operator*(double s, const Vec3& v) { return v * s; }
  friend constexpr Vec3 operator/(const Vec3& v, double s) { return {v.x() / s, v.y() / s, v.z() / s}; }

  constexpr double dot(const Vec3& v) const { return x() * v.x() + y() * v.y() + z() * v.z(); }
  constexpr Vec3 cross(const Vec3& v) const {
    return {y() * v.z() - z() * v.y(), z() * v.x() - x() * v.z(), x() * v.y() - y() * v.x()};
  }
  constexpr double squaredNorm() const { return dot(*this); }
  double norm() const { return std::sqrt(squaredNorm()); }
  /// Of length 1; as it is if its square is 0.
  Vec3 normalized() const {
    const double square = squaredNorm();
    return square > 0 ? *this / std::sqrt(square) : *this;
  }

  /// The same without over- and underflow.
  Vec3 stableNormalized() const {
    const double largest = cwiseAbs().maxCoeff(), square = (*this / largest).squaredNorm();
    return square > 0 ? *this / (std::sqrt(square) * largest) : *this;
  }

  Vec3 cwiseAbs() const { return {std::abs(x()), std::abs(y()), std::abs(z())}; }
  /// The smaller of each two coordinates; this one's where the other is NaN.
  constexpr Vec3 cwiseMin(const Vec3& v) const {
    return {smaller(x(), v.x()), smaller(y(), v.y()), smaller(z(), v.z())};
  }
  constexpr Vec3 cwiseMax(const Vec3& v) const {
    return {larger(x(), v.x()), larger(y(), v.y()), larger(z(), v.z())};
  }
  constexpr Vec3 cwiseProduct(const Vec3& v) const { return {x() * v.x(), y() * v.y(), z() * v.z()}; }
  constexpr double minCoeff() const { return smaller(smaller(x(), y()), z()); }
  constexpr double maxCoeff() const { return larger(larger(x(), y()), z()); }
  bool allFinite() const { return std::isfinite(x()) && std::isfinite(y()) && std::isfinite(z()); }

 private:
  static constexpr double smaller(double a, double b) { return b < a ? b : a; }
  static constexpr double larger(double a, double b) { return a < b ? b : a; }

  std::array<double, 3> x_{};
};

}  // namespace foldproof
