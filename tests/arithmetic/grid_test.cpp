// B4: a place on a grid never falls when its coordinate grows. All floats, through the code of the queries.
#include <random>

#include "arithmetic/everything.h"

namespace foldproof::testing {
namespace {

// What docs/soundness.md says that a place is.
std::uint8_t plain_place(float x, const OneGrid& grid) {
  const float steps = (x - grid.origin) * grid.scale;
  return static_cast<std::uint8_t>(std::max(0.f, std::min(steps, 255.f)));
}

std::vector<OneGrid> grids() {
  std::vector<OneGrid> all;
  // As FitGrid makes them: a leaf of any side from the least, 2^-20, to all of the frame, anywhere.
  for (const float low : {0.f, -0.5625f, 0.123456f, -0x1.8p-23f}) {
    for (const float size : {0.f, 0x1p-19f, 0.003f, 0.01f, 0.77f, 1.125f}) {
      const float side = std::max(size, 0x1p-20f);
      const float margin = std::array{0x1.1p-22f, 0.f, 4.f, 0x1p-9f}[all.size() % 4];
      all.push_back({low - side * (1.5f / 252), 252 / side, margin});
    }
  }
  return all;
}

std::vector<OneGrid> extreme_grids() {
  const float most = std::numeric_limits<float>::max(), least = std::numeric_limits<float>::min();
  return {{0, most, 0}, {0, least, 0}, {-1, 0x1p100f, 4}, {0x1p60f, 0x1p-60f, 0}, {0, 0x1p-149f, most}};
}

// Both corners' places over floats in ascending order: how often one falls, and how often it is another than
// the page says.
struct Wrong {
  std::uint64_t falls = 0, others = 0;
  float first = 0;
};
Wrong places_on(const OneGrid& grid, bool wide, std::uint32_t stride, bool never_all) {
  Wrong wrong;
  std::vector<std::uint8_t> lower(kRun), upper(kRun);
  over_floats(
      stride,
      [&](std::span<const float> x) {
        place_on_grid(grid, wide, x, lower, upper);
        std::uint64_t falls = 0, others = 0;
        for (std::size_t i = 1; i < x.size(); ++i)
          falls += (lower[i] < lower[i - 1]) | (upper[i] < upper[i - 1]);
        for (std::size_t i = 0; i < x.size(); ++i) {
          others += (lower[i] != plain_place(x[i] - grid.margin, grid)) |
                    (upper[i] != plain_place(x[i] + grid.margin, grid));
        }
        if (falls + others != 0 && wrong.falls + wrong.others == 0) wrong.first = x[0];
        wrong.falls += falls;
        wrong.others += others;
      },
      never_all);
  return wrong;
}

void expect_never_falls(const std::vector<OneGrid>& all, std::uint32_t stride) {
  constexpr std::size_t kAllFloats = 7;  // one grid of so many: a grid takes minutes then
  on_every_target([&] {
    for (std::size_t k = 0; k < all.size(); ++k) {
      const OneGrid& grid = all[k];
      for (const bool wide : {true, false}) {
        const Wrong wrong = places_on(grid, wide, stride, k % kAllFloats != 0);
        EXPECT_EQ(wrong.falls, 0u) << "first from " << wrong.first << " on; origin " << grid.origin
                                   << ", scale " << grid.scale << ", wide " << wide;
        EXPECT_EQ(wrong.others, 0u) << "first from " << wrong.first << " on; origin " << grid.origin
                                    << ", scale " << grid.scale << ", wide " << wide;
      }
    }
  });
}

TEST(PlaceOnGrid, NeverFalls) { expect_never_falls(grids(), 4001); }

TEST(PlaceOnGrid, NeverFallsOnGridsThatNobodyMakes) { expect_never_falls(extreme_grids(), 4001); }

TEST(PlaceOnGrid, AllInstructionSetsAgree) {
  expect_all_targets_agree([] {
    std::vector<Index> places;
    std::vector<float> x;
    for (int i = -1024; i < 1024; ++i) x.push_back(static_cast<float>(i) * 0x1.3p-10f);
    std::vector<std::uint8_t> lower(x.size()), upper(x.size());
    for (const OneGrid& grid : grids()) {
      place_on_grid(grid, true, x, lower, upper);
      places.insert(places.end(), lower.begin(), lower.end());
      places.insert(places.end(), upper.begin(), upper.end());
    }
    return places;
  });
}

}  // namespace
}  // namespace foldproof::testing
