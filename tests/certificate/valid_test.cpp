// chart_is_valid against plain exact geometry, on drawings that were spoiled in every way one can think of.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "certificate/coverage.h"
#include "certificate/patches.h"

namespace foldproof::testing {
namespace {

struct Drawn {
  Patch patch;
  Drawing drawing;
};

std::size_t any(Rng& rng, std::size_t count) { return rng() % count; }

using Corners = std::array<std::uint16_t, 3>;

Corners& any_triangle(Drawn& d, Rng& rng) {
  const std::size_t patch = d.patch.triangles.size(), all = patch + d.drawing.fillers.size(),
                    k = any(rng, all);
  return k < patch ? d.patch.triangles[k] : d.drawing.fillers[k - patch];
}

void turn_triangle(Drawn& d, Rng& rng) {
  Corners& t = any_triangle(d, rng);
  std::swap(t[0], t[1]);
}
void begin_elsewhere(Drawn& d, Rng& rng) {
  Corners& t = any_triangle(d, rng);
  std::rotate(t.begin(), t.begin() + 1, t.end());
}
void drop_filler(Drawn& d, Rng& rng) {
  d.drawing.fillers.erase(d.drawing.fillers.begin() +
                          static_cast<std::ptrdiff_t>(any(rng, d.drawing.fillers.size())));
}
void double_triangle(Drawn& d, Rng& rng) { d.drawing.fillers.push_back(any_triangle(d, rng)); }
void swap_corner(Drawn& d, Rng& rng) {
  any_triangle(d, rng)[any(rng, 3)] = static_cast<std::uint16_t>(any(rng, d.drawing.places.size() + 4));
}
void name_nobody(Drawn& d, Rng& rng) {
  any_triangle(d, rng)[any(rng, 3)] = static_cast<std::uint16_t>(d.drawing.places.size() + 4 + any(rng, 100));
}
void shift_place(Drawn& d, Rng& rng) {
  Place& p = d.drawing.places[any(rng, d.drawing.places.size())];
  const double way = log_uniform(rng, 1, 20000);
  for (auto& c : p) c = static_cast<std::int16_t>(std::clamp(c + uniform(rng, -way, way), -32767.0, 32767.0));
}
void swap_places(Drawn& d, Rng& rng) {
  auto& places = d.drawing.places;
  std::swap(places[any(rng, places.size())], places[any(rng, places.size())]);
}
// Two triangles with a common side get the other diagonal: the square stays covered when their union is
// convex.
void turn_diagonal(Drawn& d, Rng& rng) {
  auto& f = d.drawing.fillers;
  for (int attempt = 0; attempt < 1000; ++attempt) {
    Corners &s = f[any(rng, f.size())], &t = f[any(rng, f.size())];
    for (int k = 0; k < 9; ++k, std::rotate(s.begin(), s.begin() + 1, s.end())) {
      if (k % 3 == 0) std::rotate(t.begin(), t.begin() + 1, t.end());
      if (s[0] != t[1] || s[1] != t[0]) continue;
      const Corners a{s[0], t[2], s[2]}, b{t[2], s[1], s[2]};
      s = a;
      t = b;
      return;
    }
  }
}
// A triangle is cut in three at a vertex that no other uses. The corners of the square follow the vertices.
void cut_triangle(Drawn& d, Rng& rng) {
  const auto added = static_cast<std::uint16_t>(d.drawing.places.size());
  for (auto* group : {&d.patch.triangles, &d.drawing.fillers}) {
    for (Corners& c : *group) {
      for (std::uint16_t& v : c) v = static_cast<std::uint16_t>(v + (v >= added));
    }
  }
  Corners& t = any_triangle(d, rng);
  const Corners old = t;
  t = {old[0], old[1], added};
  d.drawing.fillers.push_back({old[1], old[2], added});
  d.drawing.fillers.push_back({old[2], old[0], added});
  Place middle{};
  for (int c = 0; c < 2; ++c) {
    int sum = 0;
    for (const std::uint16_t v : old)
      sum += v < added ? d.drawing.places[v][c] : kChartCorners[v - added - 1][c];
    middle[c] = static_cast<std::int16_t>(sum / 3);
  }
  d.patch.vertices.push_back(added);
  d.drawing.places.push_back(middle);
}

struct Spoiling {
  const char* name;
  void (*spoil)(Drawn&, Rng&);
};
constexpr Spoiling kSpoilings[] = {{"turn_triangle", turn_triangle}, {"begin_elsewhere", begin_elsewhere},
                                   {"drop_filler", drop_filler},     {"double_triangle", double_triangle},
                                   {"swap_corner", swap_corner},     {"name_nobody", name_nobody},
                                   {"shift_place", shift_place},     {"swap_places", swap_places},
                                   {"turn_diagonal", turn_diagonal}};

std::vector<Drawn> drawings(Rng& rng) {
  std::vector<Drawn> all;
  for (const PosedPatch& p : drawable_patches(rng)) {
    Drawn d{p.patch, {}};
    if (draw(p.patch, p.x, d.drawing) == ChartOutcome::Made) all.push_back(std::move(d));
  }
  return all;
}

TEST(ChartIsValid, AgreesWithPlainGeometryOnSpoiledDrawings) {
  Rng rng(11);
  const std::vector<Drawn> good = drawings(rng);
  ASSERT_GE(good.size(), 8u);
  int valid = 0, tries = 0;
  for (int round = 0; round < 400; ++round) {
    Drawn d = good[any(rng, good.size())];
    std::string what;
    // Several in a row may cancel each other. The harmless ones come more often, so that many stay valid.
    for (std::size_t n = 1 + any(rng, 3); n > 0; --n) {
      const Spoiling& s = any(rng, 3) == 0 ? kSpoilings[any(rng, std::size(kSpoilings))]
                                           : kSpoilings[std::array{1, 6, 8}[any(rng, 3)]];
      s.spoil(d, rng);
      what += std::string(" ") + s.name;
    }
    const Coverage coverage(d.patch, d.drawing, rng());
    const bool expected = coverage.all_good(), actual = chart_is_valid(d.patch, d.drawing);
    ++tries;
    valid += actual;
    if (actual) {
      ASSERT_TRUE(expected) << "taken for valid after" << what;
    } else {
      // The square's sides must be whole, which the theorem does not ask for.
      ASSERT_TRUE(!expected || coverage.touches_border()) << "refused after" << what;
    }
  }
  EXPECT_GT(valid, 0.3 * tries);
  EXPECT_LT(valid, 0.7 * tries);
}

TEST(ChartIsValid, EachSpoilingAloneIsSeen) {
  Rng rng(12);
  const std::vector<Drawn> good = drawings(rng);
  for (const auto spoil : {turn_triangle, drop_filler, double_triangle, name_nobody}) {
    for (const Drawn& drawn : good) {
      Drawn d = drawn;
      spoil(d, rng);
      EXPECT_FALSE(chart_is_valid(d.patch, d.drawing));
    }
  }
}

TEST(ChartIsValid, AFinerTriangulationStaysValid) {
  Rng rng(13);
  for (const Drawn& drawn : drawings(rng)) {
    Drawn d = drawn;
    int cut = 0;
    for (int k = 0; k < 10; ++k) {
      Drawn before = d;
      cut_triangle(d, rng);
      const bool valid = chart_is_valid(d.patch, d.drawing);
      EXPECT_EQ(valid, Coverage(d.patch, d.drawing, k).all_good());
      cut += valid;
      if (!valid) d = before;  // cut in the middle of a thin triangle, rounded to its border
    }
    EXPECT_GT(cut, 5);
  }
}

TEST(ChartIsValid, SizesThatDoNotMatchAreRefused) {
  Rng rng(14);
  Drawn d = drawings(rng)[0];
  d.drawing.places.pop_back();
  EXPECT_FALSE(chart_is_valid(d.patch, d.drawing));
  d = drawings(rng)[0];
  d.patch.vertices.push_back(99);
  EXPECT_FALSE(chart_is_valid(d.patch, d.drawing));
  EXPECT_FALSE(chart_is_valid({}, {}));
}

// Two sheets of one square each, one above the other, and one that winds round a vertex twice: local checks
// pass, the count of the outline does not.
TEST(ChartIsValid, CoveringTwiceIsRefused) {
  Drawing twice;
  Patch none;
  twice.fillers = {{0, 1, 2}, {0, 2, 3}, {0, 1, 3}, {1, 2, 3}};
  EXPECT_FALSE(chart_is_valid(none, twice));
  twice.fillers = {{0, 1, 2}, {0, 2, 3}};
  EXPECT_TRUE(chart_is_valid(none, twice));
  // Around the vertex 0, two turns.
  Patch wheel;
  Drawing winding;
  wheel.vertices = {0, 1, 2, 3, 4};
  winding.places = {{0, 0}, {10000, 10000}, {-10000, 10000}, {-10000, -10000}, {10000, -10000}};
  const auto corner = [](int k) { return static_cast<std::uint16_t>(5 + k % 4); };
  const auto inner = [](int k) { return static_cast<std::uint16_t>(1 + k % 4); };
  for (int k = 0; k < 4; ++k) {
    wheel.triangles.push_back({0, inner(k), inner(k + 1)});
    wheel.triangles.push_back({0, corner(k), corner(k + 1)});
  }
  EXPECT_FALSE(chart_is_valid(wheel, winding));
}

}  // namespace
}  // namespace foldproof::testing
