// B4: the cell on a grid is a monotone function of the coordinate. All floats, with the code of the queries.
#include <random>

#include "arithmetic/everything.h"

namespace foldproof::testing {
namespace {

// The cell as docs/soundness.md defines it.
std::uint8_t expected_cell(float x, const OneGrid& grid) {
  const float steps = (x - grid.origin) * grid.scale;
  return static_cast<std::uint8_t>(std::max(0.f, std::min(steps, 255.f)));
}

std::vector<OneGrid> grids() {
  std::vector<OneGrid> all;
  // As FitGrid makes them: leaves of all sizes, from the minimum 2^-20 to the whole frame, anywhere.
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
  const float max = std::numeric_limits<float>::max(), min = std::numeric_limits<float>::min();
  return {{0, max, 0}, {0, min, 0}, {-1, 0x1p100f, 4}, {0x1p60f, 0x1p-60f, 0}, {0, 0x1p-149f, max}};
}

// Both corners' cells over floats in ascending order: how often one decreases, and how often it is not the
// expected one.
struct Wrong {
  std::uint64_t decreases = 0, mismatches = 0;
  float first = 0;
};
Wrong cells_on(const OneGrid& grid, bool wide, std::uint32_t stride, bool never_all) {
  Wrong wrong;
  std::vector<std::uint8_t> lower(kRun), upper(kRun);
  over_floats(
      stride,
      [&](std::span<const float> x) {
        quantize(grid, wide, x, lower, upper);
        std::uint64_t decreases = 0, mismatches = 0;
        for (std::size_t i = 1; i < x.size(); ++i)
          decreases += int{lower[i] < lower[i - 1]} | int{upper[i] < upper[i - 1]};
        for (std::size_t i = 0; i < x.size(); ++i) {
          mismatches += int{lower[i] != expected_cell(x[i] - grid.margin, grid)} |
                        int{upper[i] != expected_cell(x[i] + grid.margin, grid)};
        }
        if (decreases + mismatches != 0 && wrong.decreases + wrong.mismatches == 0) wrong.first = x[0];
        wrong.decreases += decreases;
        wrong.mismatches += mismatches;
      },
      never_all);
  return wrong;
}

void expect_monotone(const std::vector<OneGrid>& all, std::uint32_t stride) {
  constexpr std::size_t kAllFloats = 7;  // only one grid in 7: all floats on a grid take minutes
  on_every_target([&] {
    for (std::size_t k = 0; k < all.size(); ++k) {
      const OneGrid& grid = all[k];
      for (const bool wide : {true, false}) {
        const Wrong wrong = cells_on(grid, wide, stride, k % kAllFloats != 0);
        EXPECT_EQ(wrong.decreases, 0u) << "first from " << wrong.first << " on; origin " << grid.origin
                                       << ", scale " << grid.scale << ", wide " << wide;
        EXPECT_EQ(wrong.mismatches, 0u) << "first from " << wrong.first << " on; origin " << grid.origin
                                        << ", scale " << grid.scale << ", wide " << wide;
      }
    }
  });
}

TEST(Quantize, IsMonotone) { expect_monotone(grids(), 4001); }

TEST(Quantize, IsMonotoneOnExtremeGrids) { expect_monotone(extreme_grids(), 4001); }

TEST(Quantize, AllInstructionSetsAgree) {
  expect_all_targets_agree([] {
    std::vector<Index> cells;
    std::vector<float> x;
    for (int i = -1024; i < 1024; ++i) x.push_back(static_cast<float>(i) * 0x1.3p-10f);
    std::vector<std::uint8_t> lower(x.size()), upper(x.size());
    for (const OneGrid& grid : grids()) {
      quantize(grid, true, x, lower, upper);
      cells.insert(cells.end(), lower.begin(), lower.end());
      cells.insert(cells.end(), upper.begin(), upper.end());
    }
    return cells;
  });
}

}  // namespace
}  // namespace foldproof::testing
