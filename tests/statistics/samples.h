/// Random samples for the tests of statistics.
#pragma once

#include <Eigen/Dense>
#include <random>

namespace foldproof::testing {

/// Independent numbers, roughly normal: sums of twelve uniform ones.
inline Eigen::MatrixXd noise(Eigen::Index rows, Eigen::Index columns, unsigned seed) {
  std::mt19937 random(seed);
  return Eigen::MatrixXd::NullaryExpr(rows, columns, [&] {
    double sum = -6;
    for (int k = 0; k < 12; ++k) sum += static_cast<double>(random()) * 0x1p-32;
    return sum;
  });
}

/// `rank` independent directions, each `ratio` times as strong as the one before, around a mean other than 0.
inline Eigen::MatrixXd graded(Eigen::Index size, Eigen::Index count, Eigen::Index rank, double ratio,
                              unsigned seed) {
  const Eigen::MatrixXd directions = noise(size, rank, seed), factors = noise(rank, count, seed + 1);
  Eigen::VectorXd strength(rank);
  for (Eigen::Index k = 0; k < rank; ++k) strength[k] = k == 0 ? 1 : strength[k - 1] * ratio;
  const Eigen::VectorXd mean = 3 * noise(size, 1, seed + 2);
  return (directions * strength.asDiagonal() * factors).colwise() + mean;
}

inline Eigen::MatrixXd centered(const Eigen::MatrixXd& samples) {
  return samples.colwise() - samples.rowwise().mean();
}

inline Eigen::MatrixXd covariance(const Eigen::MatrixXd& samples) {
  const Eigen::MatrixXd c = centered(samples);
  return c * c.transpose() / static_cast<double>(samples.cols() - 1);
}

inline constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

}  // namespace foldproof::testing
