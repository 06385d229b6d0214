// Underflow is accounted for: no pair is separated because digits were lost at the lower end of double's
// range.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "base/rounds.h"
#include "foldproof/ccd.h"
#include "oracle/one_target.h"

namespace foldproof {
namespace {

using testing::on_each_target;

// N1: the face is so small that the square of its normal is a denormal number.
TEST(Underflow, NormalsOfTinyFacesAreNoLongerThanOne) {
  on_each_target([] {
    for (int exponent = -300; exponent < -60; ++exponent) {
      for (const double digits : {1.0, 1.2, 1.5, 1.64, 1.9}) {
        const double a = std::ldexp(digits, exponent);
        const FourPoints x0{Vec3(0, 0, 1.3), Vec3(0, 0, 0), Vec3(a, 0, 0), Vec3(0, a, 0)};
        FourPoints x1 = x0;
        x1[0] = Vec3(0, 0, 1.0);
        for (const double thickness : {1.0000001, 1.01, 1.1, 1.2}) {
          CcdSettings settings;
          settings.thickness = thickness;
          settings.tolerance = 1e-9;
          EXPECT_NE(vertex_face_ccd(x0, x1, settings).answer, Answer::Separated)
              << "side " << a << ", thickness " << thickness;
        }
      }
    }
  });
}

// The same for edges: the closest points lie inside both.
TEST(Underflow, NormalsOfTinyEdgesAreNoLongerThanOne) {
  on_each_target([] {
    for (int exponent = -300; exponent < -60; ++exponent) {
      for (const double digits : {1.0, 1.2, 1.5, 1.64, 1.9}) {
        const double a = std::ldexp(digits, exponent);
        const FourPoints x0{Vec3(-a, 0, 1.3), Vec3(a, 0, 1.3), Vec3(0, -a, 0), Vec3(0, a, 0)};
        FourPoints x1 = x0;
        x1[0][2] = x1[1][2] = 1.0;
        CcdSettings settings;
        settings.thickness = 1.1;
        settings.tolerance = 1e-9;
        EXPECT_NE(edge_edge_ccd(x0, x1, settings).answer, Answer::Separated) << "half a side " << a;
      }
    }
  });
}

// N3: products underflow inside a cross product and are multiplied by a large coordinate afterwards. The
// vertex is half a corner and a quarter of each of the others, exactly.
TEST(Underflow, VolumesOfLongThinFacesKeepNoFalseSign) {
  on_each_target([] {
    std::mt19937_64 rng(1);
    std::uniform_int_distribution<int> digits(1, 4000);
    for (const int large : {0, 70, 78, 96, 99}) {
      for (int small = -600; small <= -480; small += 10) {
        const double x = std::ldexp(1.0, large), unit = std::ldexp(4.0, small);
        for (int i = 0; i < 200; ++i) {
          const double p = unit * digits(rng), q = unit * digits(rng), r = unit * digits(rng),
                       s = unit * digits(rng);
          const FourPoints points{Vec3(0, 0, 0), Vec3(x, -(p + r) / 2, -(q + s) / 2), Vec3(-x, p, q),
                                  Vec3(-x, r, s)};
          EXPECT_NE(vertex_face_ccd(points, points, {}).answer, Answer::Separated)
              << "2^" << large << " long, 2^" << small << " wide";
        }
      }
    }
  });
}

// Points of a plane x = P, whose other coordinates are multiples of a unit.
struct PlaneX {
  double x, unit;
  Vec3 operator()(double y, double z) const { return {x, y * unit, z * unit}; }
};

// Visits planes at all distances from the origin, with all units from 2^-1030 on.
template <class Visit>
void for_each_plane(Visit visit) {
  for (int place = -1000; place <= 1000; place += 10 * testing::kShare) {
    for (int unit = -1030; unit <= 900; unit += 10)
      visit(PlaneX{std::ldexp(1.0, place), std::ldexp(1.0, unit)});
  }
}

// The vertex ends on a slanted side of the face, at a point that is exact.
TEST(Underflow, ContactsBesideALargeCommonCoordinateAreFound) {
  on_each_target([] {
    for_each_plane([](const PlaneX& at) {
      for (const double slope : {0x1p-40, 0x1p-20, 0x1p-5, 1.0}) {
        const FourPoints x0{at(0.5, -1), at(0, 0), at(1, slope), at(0, 1)};
        FourPoints x1 = x0;
        x1[0] = at(0.5, slope / 2);
        // A pair of edges with the same contact.
        const FourPoints e0{at(0.5, -1), at(0.5, -2), at(0, 0), at(1, slope)};
        FourPoints e1 = e0;
        e1[0] = x1[0];
        EXPECT_NE(vertex_face_ccd(x0, x1, {}).answer, Answer::Separated)
            << at.x << " " << at.unit << " " << slope;
        EXPECT_NE(edge_edge_ccd(e0, e1, {}).answer, Answer::Separated)
            << at.x << " " << at.unit << " " << slope;
      }
    });
  });
}

TEST(Underflow, FeaturesApartBesideALargeCommonCoordinateAreSeparated) {
  on_each_target([] {
    for_each_plane([](const PlaneX& at) {
      const FourPoints x{at(1, -16), at(0, 0), at(1, 0), at(0, 1)},
          e{at(0, -16), at(1, -16), at(0, 0), at(1, 0)};
      for (const double thickness : {0.0, 0x1p-1074}) {
        CcdSettings settings;
        settings.thickness = thickness;
        EXPECT_EQ(vertex_face_ccd(x, x, settings).answer, Answer::Separated) << at.x << " " << at.unit;
        EXPECT_EQ(edge_edge_ccd(e, e, settings).answer, Answer::Separated) << at.x << " " << at.unit;
      }
      EXPECT_EQ(vertex_face_closest(x).distance, 16 * at.unit) << at.x;
      EXPECT_EQ(edge_edge_closest(e).distance, 16 * at.unit) << at.x;
    });
  });
}

}  // namespace
}  // namespace foldproof
