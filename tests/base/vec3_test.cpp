// Vec3 against vectors of Eigen, bit for bit. In which order Eigen adds, and which of two equal numbers or
// NaN it takes, depends on the machine; Vec3 does on all what Eigen does with SSE2.
#include "foldproof/vec3.h"

#include <gmock/gmock.h>

#include <Eigen/Dense>
#include <bit>
#include <limits>
#include <random>

namespace foldproof {
namespace {

using Eigen::Vector3d;

/// All NaNs are the same.
std::uint64_t bits(double x) {
  return std::bit_cast<std::uint64_t>(std::isnan(x) ? std::numeric_limits<double>::quiet_NaN() : x);
}
std::array<std::uint64_t, 3> bits(const auto& v) { return {bits(v[0]), bits(v[1]), bits(v[2])}; }

/// Numbers of all sizes: subnormal, tiny, huge, -0, infinite, NaN; and near each other, so that sums round.
class Numbers {
 public:
  explicit Numbers(bool finite) : finite_(finite) {}
  double next() {
    const double number = mantissa_(random_);
    switch (random_() % 12) {
      case 0:
        return std::ldexp(number, static_cast<int>(random_() % 2000) - 1060);
      case 1:
        return number < 0 ? -0.0 : 0.0;
      case 2:
        return std::numeric_limits<double>::denorm_min() * std::round(100 * number);
      case 3:
        return finite_ ? number : std::copysign(std::numeric_limits<double>::infinity(), number);
      case 4:
        return finite_ || number < 0 ? number : std::numeric_limits<double>::quiet_NaN();
      case 5:
        return std::round(number);
      default:
        return number;
    }
  }
  Vec3 vector() {
    const double x = next(), y = next();
    return {x, y, next()};
  }

 private:
  std::mt19937_64 random_{7};
  std::uniform_real_distribution<double> mantissa_{-4, 4};
  bool finite_;
};

Vector3d eigen(const Vec3& v) { return {v.x(), v.y(), v.z()}; }

constexpr int kTrials = 100000;

TEST(Vec3, ComputesTheSameBitsAsEigen) {
  for (const bool finite : {true, false}) {
    Numbers numbers(finite);
    for (int trial = 0; trial < kTrials; ++trial) {
      const Vec3 a = numbers.vector(), b = numbers.vector();
      const Vector3d p = eigen(a), q = eigen(b);
      const double s = numbers.next();
      ASSERT_EQ(bits(a + b), bits(Vector3d(p + q)));
      ASSERT_EQ(bits(a - b), bits(Vector3d(p - q)));
      ASSERT_EQ(bits(-a), bits(Vector3d(-p)));
      ASSERT_EQ(bits(a * s), bits(Vector3d(p * s)));
      ASSERT_EQ(bits(s * a), bits(Vector3d(s * p)));
      ASSERT_EQ(bits(a / s), bits(Vector3d(p / s)));
      ASSERT_EQ(bits(a.cross(b)), bits(p.cross(q)));
      ASSERT_EQ(bits(a.cwiseAbs()), bits(Vector3d(p.cwiseAbs())));
      ASSERT_EQ(bits(a.cwiseProduct(b)), bits(Vector3d(p.cwiseProduct(q))));
      ASSERT_EQ(a.allFinite(), p.allFinite());
      ASSERT_EQ(a == b, p == q);
      ASSERT_EQ(a == a, p == p);
    }
  }
}

TEST(Vec3, AddsFromXToZ) {
  Numbers numbers(true);
  int order_matters = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    const Vec3 a = numbers.vector(), b = numbers.vector();
    const double x = a.x() * b.x(), y = a.y() * b.y(), z = a.z() * b.z();
    ASSERT_EQ(bits(a.dot(b)), bits((x + y) + z));
    order_matters += (x + y) + z != x + (y + z);
    ASSERT_EQ(bits(a.squaredNorm()), bits(a.dot(a)));
    ASSERT_EQ(bits(a.norm()), bits(std::sqrt(a.dot(a))));
  }
  EXPECT_GT(order_matters, kTrials / 100);
}

#ifdef EIGEN_VECTORIZE_SSE2
TEST(Vec3, SumsAndExtremesHaveTheSameBitsAsThoseOfEigen) {
  for (const bool finite : {true, false}) {
    Numbers numbers(finite);
    for (int trial = 0; trial < kTrials; ++trial) {
      const Vec3 a = numbers.vector(), b = numbers.vector(), c = numbers.vector();
      const Vector3d p = eigen(a), q = eigen(b), r = eigen(c);
      const Eigen::Map<const Vector3d> mapped(a.data());
      ASSERT_EQ(bits(a.dot(b)), bits(p.dot(q)));
      ASSERT_EQ(bits(a.dot(b)), bits(mapped.dot(q)));
      ASSERT_EQ(bits((a - b).dot(c)), bits((p - q).dot(r)));
      ASSERT_EQ(bits((a - b).dot(c)), bits((mapped - q).dot(r)));
      ASSERT_EQ(bits(a.dot(b.cross(c))), bits(p.dot(q.cross(r))));
      ASSERT_EQ(bits(a.squaredNorm()), bits(p.squaredNorm()));
      ASSERT_EQ(bits((a - b).norm()), bits((p - q).norm()));
      ASSERT_EQ(bits(a.normalized()), bits(p.normalized()));
      ASSERT_EQ(bits(a.stableNormalized()), bits(p.stableNormalized()));
      ASSERT_EQ(bits(a.cwiseMin(b)), bits(Vector3d(p.cwiseMin(q))));
      ASSERT_EQ(bits(a.cwiseMax(b)), bits(Vector3d(p.cwiseMax(q))));
      ASSERT_EQ(bits(a.minCoeff()), bits(p.minCoeff()));
      ASSERT_EQ(bits(a.maxCoeff()), bits(p.maxCoeff()));
    }
  }
}
#endif

TEST(Vec3, NormalizesWhatHasALength) {
  EXPECT_EQ(Vec3(0, -3, 4).normalized(), Vec3(0, -0.6, 0.8));
  EXPECT_EQ(Vec3(0, 0, 1e-200).normalized(), Vec3(0, 0, 1e-200)) << "its square is 0";
  EXPECT_EQ(Vec3(0, 0, 1e-200).stableNormalized(), Vec3(0, 0, 1));
  EXPECT_EQ(Vec3(0, -1e300, 0).stableNormalized(), Vec3(0, -1, 0));
  EXPECT_EQ(Vec3().stableNormalized(), Vec3::Zero());
}

TEST(Vec3, IsThreeNumbersInARow) {
  static_assert(std::is_trivially_copyable_v<Vec3> && sizeof(Vec3) == 3 * sizeof(double));
  const float floats[] = {1, 2, 3};
  double numbers[] = {0, 0, 0, 0};
  Vec3 v = Vec3::load(floats);
  v[1] += 0.5;
  v.store(numbers + 1);
  EXPECT_THAT(numbers, testing::ElementsAre(0, 1, 2.5, 3));
  EXPECT_EQ(Vec3::load(numbers + 1), v);
  EXPECT_THAT(std::vector(v.begin(), v.end()), testing::ElementsAre(1, 2.5, 3));
  v += Vec3::Constant(1);
  v *= 2;
  v -= Vec3(0, 1, 0);
  v /= 4;
  EXPECT_EQ(v, Vec3(1, 1.5, 2));
}

}  // namespace
}  // namespace foldproof
