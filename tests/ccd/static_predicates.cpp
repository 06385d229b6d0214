// The exact predicates compared with CGAL's exact kernel and the oracle's integers.
#include <CGAL/Exact_predicates_exact_constructions_kernel.h>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "foldproof/ccd.h"
#include "oracle/families.h"
#include "oracle/oracle.h"

namespace foldproof::oracle {
namespace {

using Kernel = CGAL::Exact_predicates_exact_constructions_kernel;
using Points = std::vector<Vec3>;

Kernel::Point_3 cgal(const Vec3& p) { return {p.x(), p.y(), p.z()}; }

std::string text(const Points& points) {
  std::string result;
  for (const Vec3& p : points) result += fmt::format("Vec3({:a}, {:a}, {:a}), ", p.x(), p.y(), p.z());
  return result;
}

// Points that are coplanar, touching or degenerate often enough to matter.
struct PointFamily {
  const char* name;
  Vec3 (*make)(Rng& rng);
};
double small_integer(Rng& rng, int size) { return double(int(rng() % (2 * size + 1)) - size); }
Vec3 integer_point(Rng& rng) { return {small_integer(rng, 2), small_integer(rng, 2), small_integer(rng, 2)}; }
Vec3 flat_point(Rng& rng) { return {small_integer(rng, 3), small_integer(rng, 3), 1}; }
Vec3 skew_plane_point(Rng& rng) {
  const double a = small_integer(rng, 3), b = small_integer(rng, 3);
  return {a + 2 * b, 3 * a - b, a + b};
}
Vec3 line_point(Rng& rng) { return small_integer(rng, 4) * Vec3(1, -2, 3); }
Vec3 random_point(Rng& rng) {
  std::uniform_real_distribution<double> unit(-1, 1);
  return {unit(rng), unit(rng), unit(rng)};
}
// Rounding moves these off their common plane by less than a product of doubles resolves.
Vec3 nearly_flat_point(Rng& rng) {
  const Vec3 p = random_point(rng);
  return {p.x() * 0.1, p.y() * 0.1, (p.x() + p.y()) * 0.1};
}
Vec3 far_point(Rng& rng) { return 0x1p40 * Vec3(1, 1, 1) + integer_point(rng); }

constexpr std::array<PointFamily, 7> kPointFamilies = {{
    {"integer", integer_point},
    {"flat", flat_point},
    {"skew_plane", skew_plane_point},
    {"line", line_point},
    {"random", random_point},
    {"nearly_flat", nearly_flat_point},
    {"far", far_point},
}};

void PrintTo(const PointFamily& family, std::ostream* out) { *out << family.name; }

class StaticPredicates : public ::testing::TestWithParam<PointFamily> {
 protected:
  Points random_points(int count) {
    Points points;
    for (int i = 0; i < count; ++i) points.push_back(GetParam().make(rng_));
    return points;
  }
  Rng rng_{41};
};

TEST_P(StaticPredicates, OrientationAgreesWithCgal) {
  for (int i = 0; i < 3000; ++i) {
    const Points p = random_points(4);
    const int expected = -static_cast<int>(CGAL::orientation(cgal(p[0]), cgal(p[1]), cgal(p[2]), cgal(p[3])));
    ASSERT_EQ(orient3d(p[0], p[1], p[2], p[3]), expected) << text(p);
    ASSERT_EQ(orientation(p[0], p[1], p[2], p[3]), expected) << "the oracle disagrees\n" << text(p);
  }
}

TEST_P(StaticPredicates, OrientationIsExactAtEveryScale) {
  for (int i = 0; i < 1000; ++i) {
    Points p = random_points(4);
    const int expected = orientation(p[0], p[1], p[2], p[3]);
    for (const double factor : {0x1p-1000, 0x1p-340, 0x1p340, 0x1p980}) {
      Points q = p;
      for (Vec3& v : q) v *= factor;
      ASSERT_EQ(orient3d(q[0], q[1], q[2], q[3]), orientation(q[0], q[1], q[2], q[3])) << text(q);
    }
    std::swap(p[0], p[1]);
    ASSERT_EQ(orient3d(p[0], p[1], p[2], p[3]), -expected) << text(p);
  }
}

TEST_P(StaticPredicates, TrianglesAgreeWithCgalAndTheOracle) {
  int hits = 0;
  for (int i = 0; i < 1500; ++i) {
    const Points p = random_points(6);
    const std::array<Vec3, 3> a = {p[0], p[1], p[2]}, b = {p[3], p[4], p[5]};
    const bool expected = hulls_intersect(a, b);
    hits += expected;
    ASSERT_EQ(triangles_intersect(a, b), expected) << text(p);
    ASSERT_EQ(triangles_intersect(b, a), expected) << text(p);
    // CGAL's triangles may not be degenerate.
    if (collinear(a[0], a[1], a[2]) || collinear(b[0], b[1], b[2])) continue;
    const Kernel::Triangle_3 s(cgal(a[0]), cgal(a[1]), cgal(a[2])), t(cgal(b[0]), cgal(b[1]), cgal(b[2]));
    ASSERT_EQ(CGAL::do_intersect(s, t), expected) << "the oracle disagrees\n" << text(p);
  }
  EXPECT_GT(hits, 30);
}

TEST_P(StaticPredicates, SegmentAndTriangleAgreeWithCgalAndTheOracle) {
  int hits = 0;
  for (int i = 0; i < 1500; ++i) {
    const Points p = random_points(5);
    const std::array<Vec3, 2> s = {p[0], p[1]};
    const std::array<Vec3, 3> t = {p[2], p[3], p[4]};
    const bool expected = hulls_intersect(s, t);
    hits += expected;
    ASSERT_EQ(segment_intersects_triangle(s, t), expected) << text(p);
    ASSERT_EQ(segment_intersects_triangle({s[1], s[0]}, {t[2], t[0], t[1]}), expected) << text(p);
    if (s[0] == s[1] || collinear(t[0], t[1], t[2])) continue;
    const Kernel::Segment_3 segment(cgal(s[0]), cgal(s[1]));
    const Kernel::Triangle_3 triangle(cgal(t[0]), cgal(t[1]), cgal(t[2]));
    ASSERT_EQ(CGAL::do_intersect(segment, triangle), expected) << "the oracle disagrees\n" << text(p);
  }
  EXPECT_GT(hits, 30);
}

TEST_P(StaticPredicates, FoldingAgreesWithCgalAndTheOracle) {
  int folds = 0;
  for (int i = 0; i < 3000; ++i) {
    const Points p = random_points(4);
    const bool expected = meet_beyond_edge(p[0], p[1], p[2], p[3]);
    folds += expected;
    ASSERT_EQ(triangles_fold(p[0], p[1], p[2], p[3]), expected) << text(p);
    ASSERT_EQ(triangles_fold(p[1], p[0], p[3], p[2]), expected) << text(p);
    if (collinear(p[0], p[1], p[2]) || collinear(p[0], p[1], p[3])) continue;
    const bool flat = CGAL::coplanar(cgal(p[0]), cgal(p[1]), cgal(p[2]), cgal(p[3]));
    const bool by_cgal =
        flat && CGAL::coplanar_orientation(cgal(p[0]), cgal(p[1]), cgal(p[2]), cgal(p[3])) == CGAL::POSITIVE;
    ASSERT_EQ(by_cgal, expected) << "the oracle disagrees\n" << text(p);
  }
  // No four points drawn from the reals lie in one plane.
  if (GetParam().make != random_point && GetParam().make != nearly_flat_point) {
    EXPECT_GT(folds, 100);
  }
}

INSTANTIATE_TEST_SUITE_P(Points, StaticPredicates, ::testing::ValuesIn(kPointFamilies),
                         [](const auto& instance) { return std::string(instance.param.name); });

}  // namespace
}  // namespace foldproof::oracle
