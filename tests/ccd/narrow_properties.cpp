// The narrow phase compared with the exact oracle, over every family of cases. Seeds are fixed.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "oracle/families.h"
#include "oracle/judge.h"

namespace foldproof::oracle {
namespace {

constexpr std::array<Kind, 2> kKinds = {Kind::VertexFace, Kind::EdgeEdge};
constexpr int kCases = 600;

double size_of(const Case& c) {
  double size = 0;
  for (int k = 0; k < 4; ++k) {
    size = std::max(
        {size, (c.x0[k] - c.x0[0]).cwiseAbs().maxCoeff(), (c.x1[k] - c.x0[0]).cwiseAbs().maxCoeff()});
  }
  return size;
}

// The resolution of double arithmetic, or something coarser.
double some_tolerance(const Case& c, Rng& rng) {
  constexpr std::array<double, 4> kRelative = {0, 0x1p-30, 0x1p-20, 0x1p-8};
  return kRelative[rng() % kRelative.size()] * size_of(c);
}

struct Tally {
  int cases = 0, touched = 0, extra = 0, undecided = 0;

  void add(const Verdict& verdict, const CcdResult& result) {
    ++cases;
    touched += verdict.touched;
    extra += !verdict.touched && result.answer == Answer::Hit;
    undecided += result.answer == Answer::Undecided;
  }
  std::string line(const char* name) const {
    return fmt::format("{:14} {:6} cases, {:6} touch, {:4} further hits within tolerance, {:3} undecided\n",
                       name, cases, touched, extra, undecided);
  }
};

Verdict expect_sound(Kind kind, const Case& c, const CcdSettings& settings, CcdResult* out = nullptr) {
  const CcdResult result = narrow_phase(kind, c.x0, c.x1, settings);
  const Verdict verdict = judge(kind, c.x0, c.x1, settings, result);
  EXPECT_EQ(verdict.complaint, "") << describe(kind, c.x0, c.x1, settings);
  if (out) *out = result;
  return verdict;
}

class NarrowPhase : public ::testing::TestWithParam<Family> {};

TEST_P(NarrowPhase, MissesNothingAndStaysWithinTolerance) {
  Tally tally;
  for (const Kind kind : kKinds) {
    Rng rng(11);
    for (int i = 0; i < kCases && !HasFailure(); ++i) {
      const Case c = GetParam().make(kind, rng);
      CcdSettings settings;
      settings.tolerance = some_tolerance(c, rng);
      CcdResult result;
      const Verdict verdict = expect_sound(kind, c, settings, &result);
      tally.add(verdict, result);
    }
  }
  fmt::print("{}", tally.line(GetParam().name));
  // An answer that is always Undecided would pass every check of soundness.
  EXPECT_LE(tally.undecided, tally.cases / 100);
}

TEST_P(NarrowPhase, IsSeparatedBeyondTheTolerance) {
  // A pair that stays beyond thickness + tolerance must not be a Hit.
  int separated = 0;
  for (const Kind kind : kKinds) {
    Rng rng(12);
    for (int i = 0; i < kCases / 4 && !HasFailure(); ++i) {
      const Case c = GetParam().make(kind, rng);
      CcdSettings settings;
      settings.tolerance = size_of(c) * 0x1p-30;
      const double bound = allowed_tolerance(kind, c.x0, c.x1, settings);
      if (bound == 0 || approach(kind, c.x0, c.x1, bound, bound / 8) != Approach::Beyond) continue;
      ++separated;
      EXPECT_EQ(narrow_phase(kind, c.x0, c.x1, settings).answer, Answer::Separated)
          << describe(kind, c.x0, c.x1, settings);
    }
  }
  EXPECT_GT(separated, kCases / 60);  // families of near misses have few
}

TEST_P(NarrowPhase, StopsAtTheLatestTime) {
  int touched = 0;
  for (const Kind kind : kKinds) {
    Rng rng(13);
    for (int i = 0; i < kCases / 2 && !HasFailure(); ++i) {
      const Case c = GetParam().make(kind, rng);
      CcdSettings settings;
      settings.tolerance = some_tolerance(c, rng);
      settings.latest = i % 4 == 0 ? 0.5 : std::uniform_real_distribution<double>(0, 1)(rng);
      if (i % 16 == 1) settings.latest = 0;
      touched += expect_sound(kind, c, settings).touched;
    }
  }
  EXPECT_GT(touched, kCases / 20);
}

TEST_P(NarrowPhase, AnIterationLimitNeverHidesAContact) {
  int undecided = 0;
  for (const Kind kind : kKinds) {
    Rng rng(14);
    for (int i = 0; i < kCases / 2 && !HasFailure(); ++i) {
      const Case c = GetParam().make(kind, rng);
      CcdSettings settings;
      settings.max_iterations = 1 + i % 7;
      if (i % 2) settings.latest = std::uniform_real_distribution<double>(0, 1)(rng);
      CcdResult result;
      expect_sound(kind, c, settings, &result);
      undecided += result.answer == Answer::Undecided;
    }
  }
  EXPECT_GT(undecided, 0);
}

TEST_P(NarrowPhase, ThicknessIsSound) {
  Tally tally;
  for (const Kind kind : kKinds) {
    Rng rng(15);
    for (int i = 0; i < kCases / 5 && !HasFailure(); ++i) {
      const Case c = GetParam().make(kind, rng);
      CcdSettings settings;
      settings.thickness = size_of(c) * std::ldexp(1.0, -int(rng() % 16) - 1);
      settings.tolerance = some_tolerance(c, rng);
      if (settings.thickness == 0) continue;
      CcdResult result;
      const Verdict verdict = expect_sound(kind, c, settings, &result);
      tally.add(verdict, result);
    }
  }
  fmt::print("thickness: {}", tally.line(GetParam().name));
  EXPECT_GT(tally.touched, 10);
  EXPECT_LE(tally.undecided, tally.cases / 100);
}

INSTANTIATE_TEST_SUITE_P(Families, NarrowPhase, ::testing::ValuesIn(families().begin(), families().end()),
                         [](const auto& instance) { return std::string(instance.param.name); });

// ---- Symmetries: each variant touches exactly when the original does.

Case swapped(Kind kind, const Case& c, Rng& rng) {
  const auto arrange = [&](const std::array<int, 4>& order) {
    Case result;
    for (int k = 0; k < 4; ++k) {
      result.x0[k] = c.x0[order[k]];
      result.x1[k] = c.x1[order[k]];
    }
    return result;
  };
  if (kind == Kind::VertexFace) {
    std::array<int, 4> order = {0, 1, 2, 3};
    std::shuffle(order.begin() + 1, order.end(), rng);
    return arrange(order);
  }
  std::array<int, 2> a = {0, 1}, b = {2, 3};
  std::shuffle(a.begin(), a.end(), rng);
  std::shuffle(b.begin(), b.end(), rng);
  if (rng() % 2) std::swap(a, b);
  return arrange({a[0], a[1], b[0], b[1]});
}

template <class Map>
Case mapped(const Case& c, Map map) {
  Case result;
  for (int k = 0; k < 4; ++k) {
    result.x0[k] = map(c.x0[k]);
    result.x1[k] = map(c.x1[k]);
  }
  return result;
}

Case turned(const Case& c, Rng& rng) {
  std::array<int, 3> axis = {0, 1, 2};
  std::shuffle(axis.begin(), axis.end(), rng);
  const Vec3 sign(rng() % 2 ? 1 : -1, rng() % 2 ? 1 : -1, rng() % 2 ? 1 : -1);
  return mapped(c, [&](const Vec3& p) {
    return Vec3(sign.x() * p[axis[0]], sign.y() * p[axis[1]], sign.z() * p[axis[2]]);
  });
}

Case shifted(const Case& c, Rng& rng) {
  const auto step = [&] { return double(std::int64_t(rng() % (1ull << 41)) - (1ll << 40)); };
  const Vec3 by(step(), step(), step());
  return mapped(c, [&](const Vec3& p) { return Vec3(p + by); });
}

Case rescaled(const Case& c, Rng& rng) {
  const double factor = std::ldexp(1.0, int(rng() % 1601) - 800);
  return mapped(c, [&](const Vec3& p) { return Vec3(factor * p); });
}

class Invariance : public ::testing::TestWithParam<Family> {};

TEST_P(Invariance, EveryViewOfAPairHasTheSameTruth) {
  int touched = 0, cases = 0;
  for (const Kind kind : kKinds) {
    Rng rng(21);
    for (int i = 0; i < kCases / 4 && !HasFailure(); ++i) {
      const Case c = GetParam().make(kind, rng);
      std::vector<Case> views = {c, swapped(kind, c, rng), Case{c.x1, c.x0}, turned(c, rng)};
      if (GetParam().integers) {
        views.push_back(shifted(c, rng));
        views.push_back(rescaled(c, rng));
      }
      const bool truth = touches(kind, c.x0, c.x1);
      touched += truth;
      ++cases;
      for (const Case& view : views) {
        // The judge consults the oracle for each view: a Hit where the truth is a miss must be within
        // tolerance.
        EXPECT_EQ(expect_sound(kind, view, CcdSettings{}).touched, truth)
            << "the oracle contradicts itself\n"
            << describe(kind, view.x0, view.x1, CcdSettings{});
      }
    }
  }
  EXPECT_GT(touched, cases / 4);
  EXPECT_LT(touched, cases * 3 / 4);
}

INSTANTIATE_TEST_SUITE_P(Families, Invariance, ::testing::ValuesIn(families().begin(), families().end()),
                         [](const auto& instance) { return std::string(instance.param.name); });

// A scale by a power of two changes no rounding as long as nothing underflows, so neither may the answer
// change.
TEST(NarrowPhaseScale, PowersOfTwoChangeNothing) {
  for (const Kind kind : kKinds) {
    Rng rng(22);
    int hits = 0;
    for (int i = 0; i < 500; ++i) {
      const Case c = families()[0].make(kind, rng);
      CcdSettings settings;
      settings.tolerance = 0x1p-20;
      const CcdResult plain = narrow_phase(kind, c.x0, c.x1, settings);
      hits += plain.answer == Answer::Hit;
      for (const double factor : {0x1p-300, 0x1p-10, 0x1p40, 0x1p600}) {
        const Case scaled = mapped(c, [&](const Vec3& p) { return Vec3(factor * p); });
        settings.tolerance = 0x1p-20 * factor;
        const CcdResult result = narrow_phase(kind, scaled.x0, scaled.x1, settings);
        EXPECT_EQ(result.answer, plain.answer) << describe(kind, scaled.x0, scaled.x1, settings);
        EXPECT_EQ(result.toi, plain.toi) << describe(kind, scaled.x0, scaled.x1, settings);
      }
    }
    EXPECT_GT(hits, 50);
    EXPECT_LT(hits, 450);
  }
}

TEST(CcdResolution, IsSmallAndGrowsWithTheExtent) {
  EXPECT_LE(ccd_resolution(1), 0x1p-40);
  EXPECT_GT(ccd_resolution(1), 0);
  EXPECT_LE(ccd_resolution(1), ccd_resolution(2));
  EXPECT_LE(ccd_resolution(0x1p500), 0x1p460);
  EXPECT_LE(ccd_resolution(0x1p-500), 0x1p-540);
}

// Only differences between the features count: neither how far both move nor which point comes first.
TEST(Tolerance, FollowsTheLargestDifferenceBetweenTheFeatures) {
  const FourPoints x = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, -2, 1), Vec3(0, 2, 1)};
  FourPoints far = x;
  for (Vec3& p : far) p += Vec3(1000, 0, 0);
  EXPECT_EQ(allowed_tolerance(Kind::EdgeEdge, x, far, {}), ccd_resolution(2));
  EXPECT_EQ(allowed_tolerance(Kind::EdgeEdge, far, x, {}), ccd_resolution(2));
  EXPECT_EQ(allowed_tolerance(Kind::VertexFace, {x[2], x[0], x[1], x[3]}, far, {}), ccd_resolution(4));

  // All points but one meet at t = 1, and the answer is a Hit at a little more than half of its tolerance,
  // which is that of a difference of 6. From the first point at t = 0 all coordinates are within 3.
  const Case meeting = {{Vec3(-1, -1, -1), Vec3(-1, -4, -4), Vec3(0, -4, -4), Vec3(-4, -2, -3)},
                        {Vec3(-3, -2, 2), Vec3(-4, -4, -4), Vec3(-4, -4, -4), Vec3(-4, -4, -4)}};
  EXPECT_EQ(allowed_tolerance(Kind::EdgeEdge, meeting.x0, meeting.x1, {}), ccd_resolution(6));
  CcdResult result;
  expect_sound(Kind::EdgeEdge, meeting, {}, &result);
  EXPECT_EQ(result.answer, Answer::Hit);
  const Rational square = squared_distance(Kind::EdgeEdge, meeting.x0, meeting.x1, result.toi);
  EXPECT_GT(std::sqrt(square.convert_to<double>()), ccd_resolution(3));
}

TEST(Closest, AgreesWithTheExactDistance) {
  for (const Family& family : families()) {
    for (const Kind kind : kKinds) {
      Rng rng(31);
      for (int i = 0; i < 200; ++i) {
        const Case c = family.make(kind, rng);
        const Closest closest =
            kind == Kind::VertexFace ? vertex_face_closest(c.x0) : edge_edge_closest(c.x0);
        ASSERT_TRUE(std::isfinite(closest.distance)) << family.name << describe(kind, c.x0, c.x0, {});
        const double slack = std::max(size_of({c.x0, c.x0}) * 0x1p-44, 0x1p-1070);
        const Rational bound(closest.distance), above = bound + Rational(slack);
        const Rational below = closest.distance > slack ? Rational(bound - Rational(slack)) : Rational(0);
        const Rational exact = squared_distance(kind, c.x0, c.x0, 0);
        EXPECT_LE(exact, above * above) << family.name << describe(kind, c.x0, c.x0, {});
        EXPECT_GE(exact, below * below) << family.name << describe(kind, c.x0, c.x0, {});
        const Vec3& d = closest.difference;
        EXPECT_NEAR(std::hypot(std::hypot(d.x(), d.y()), d.z()), closest.distance, slack) << family.name;
      }
    }
  }
}

}  // namespace
}  // namespace foldproof::oracle
