// A chart from elsewhere whose patch is small in its square. Rounding of the triangles at the square's
// corners, which the margin of a chart does not cover there, once hid pairs that touch.
#include <gtest/gtest.h>

#include "certificate/library.h"
#include "foldproof/check.h"

namespace foldproof {
namespace {

// The vertices of two triangles, and the corners of the square. `a` and `b` meet at the end of the step.
enum Corner : std::uint16_t { p, a, q, m, k, b, upper_right, upper_left, lower_left, lower_right };

constexpr Uv kUvs[] = {{-8, -2}, {0, 0}, {-2, -8}, {3, 3}, {17, -3}, {7, 7}};

struct Motion {
  std::vector<double> from, to;
};

Motion until_two_vertices_meet() {
  Motion motion;
  for (const Uv& uv : kUvs) motion.from.insert(motion.from.end(), {double(uv[0]), double(uv[1]), 0});
  motion.to = motion.from;
  const auto move = [&](Corner v, double x, double y) {
    motion.to[3 * std::size_t{v}] = x;
    motion.to[3 * std::size_t{v} + 1] = y;
  };
  move(a, 2.7745819091796875, 4.2360172271728516);
  move(b, 2.7745819091796875, 4.2360172271728516);
  move(m, 2.7749824523925781, 4.2343349456787109);
  move(k, 11.584377288818359, -6.9541873931884766);
  return motion;
}

// Charts for the root alone: the triangles as they lie, in the middle of the square.
std::shared_ptr<const ChartLibrary> charts_of(std::shared_ptr<const Hierarchy> hierarchy) {
  const auto slots = std::make_shared<const PatchSlots>(hierarchy);
  Patch patch;
  PatchReader(*slots).read(0, patch);
  const auto ids = hierarchy->vertex_ids();
  std::array<std::uint16_t, std::size(kUvs)> in_patch{};
  UvMap map;
  for (std::size_t i = 0; i < std::size(kUvs); ++i) {
    const Index v = ids[patch.vertices[i]];
    in_patch[v] = static_cast<std::uint16_t>(i);
    map.uvs.push_back(kUvs[v]);
  }
  map.heights.assign(std::size(kUvs), 0);
  map.scaffold = {{upper_left, a, m},
                  {lower_right, m, a},
                  {m, lower_right, k},
                  {m, b, upper_left},
                  {b, upper_right, upper_left},
                  {k, upper_right, b},
                  {k, lower_right, upper_right},
                  {a, upper_left, p},
                  {a, q, lower_right},
                  {p, lower_left, q},
                  {p, upper_left, lower_left},
                  {q, lower_left, lower_right}};
  for (auto& t : map.scaffold) {
    for (auto& v : t) v = v < std::size(kUvs) ? in_patch[v] : v;
  }
  EXPECT_TRUE(chart_is_valid(patch, map));
  auto library = std::make_shared<ChartLibrary>(slots);
  library->add(0, 0, patch, {}, map);
  return library;
}

TEST(SmallChart, HidesNothing) {
  const Motion motion = until_two_vertices_meet();
  const auto topology = Topology::make(6, {Triangle{p, q, a}, Triangle{m, k, b}}).value();
  const auto charts =
      charts_of(std::make_shared<const Hierarchy>(Hierarchy::build(topology, motion.from).value()));
  for (const bool certificates : {false, true}) {
    StepChecker checker({Object(charts)});
    StepSettings settings;
    settings.certificates = certificates;
    StepResult found;
    ASSERT_TRUE(checker.check(motion.from, motion.to, settings, found));
    EXPECT_EQ(found.count(), 6u) << certificates;
  }
}

}  // namespace
}  // namespace foldproof
