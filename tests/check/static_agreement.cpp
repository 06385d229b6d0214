// Crossing triangles of a pose compared with CGAL's self-intersection test and with exact integers.
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/box_intersection_d.h>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "foldproof/check.h"
#include "oracle/brute_force.h"
#include "oracle/data.h"
#include "oracle/meshes.h"

namespace foldproof::oracle {
namespace {

namespace Pmp = CGAL::Polygon_mesh_processing;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using SurfaceMesh = CGAL::Surface_mesh<Kernel::Point_3>;
using Crossings = std::set<std::pair<Index, Index>>;

std::vector<Kernel::Point_3> points(std::span<const double> x) {
  std::vector<Kernel::Point_3> result;
  for (std::size_t v = 0; v < x.size() / 3; ++v) result.emplace_back(x[3 * v], x[3 * v + 1], x[3 * v + 2]);
  return result;
}

std::pair<Index, Index> ordered(Index a, Index b) { return {std::min(a, b), std::max(a, b)}; }

// One pose of one topology, tested by CGAL.
class CgalPose {
 public:
  CgalPose(const Topology& topology, std::span<const double> x)
      : topology_(topology), x_(x), points_(points(x)) {}

  // By CGAL's own function where the triangles form a mesh, else by its kernel with the same rule.
  Crossings crossings() const {
    std::vector<std::vector<std::size_t>> polygons;
    for (const Triangle& t : topology_.triangles()) polygons.push_back({t[0], t[1], t[2]});
    Crossings result = Pmp::is_polygon_soup_a_polygon_mesh(polygons) ? by_mesh(polygons) : by_boxes(false);
    // CGAL skips degenerate triangles; the exact integers decide those.
    result.merge(by_boxes(true));
    return result;
  }

 private:
  bool degenerate(Index f) const {
    const Triangle& t = topology_.triangles()[f];
    return CGAL::collinear(points_[t[0]], points_[t[1]], points_[t[2]]);
  }

  Crossings by_mesh(const std::vector<std::vector<std::size_t>>& polygons) const {
    SurfaceMesh mesh;
    // Faces keep their order, so their ids do not change.
    Pmp::polygon_soup_to_polygon_mesh(points_, polygons, mesh);
    std::vector<std::pair<SurfaceMesh::Face_index, SurfaceMesh::Face_index>> pairs;
    Pmp::self_intersections<CGAL::Sequential_tag>(mesh, std::back_inserter(pairs));
    Crossings result;
    for (const auto& [f, g] : pairs) {
      if (f != g) result.insert(ordered(Index(std::size_t(f)), Index(std::size_t(g))));
    }
    return result;
  }

  Crossings by_boxes(bool degenerate_ones) const {
    using Box = CGAL::Box_intersection_d::Box_with_info_d<double, 3, Index>;
    std::vector<Box> boxes;
    std::vector<bool> flat;
    for (Index f = 0; f < topology_.triangles().size(); ++f) {
      const Triangle& t = topology_.triangles()[f];
      flat.push_back(degenerate(f));
      boxes.emplace_back(points_[t[0]].bbox() + points_[t[1]].bbox() + points_[t[2]].bbox(), f);
    }
    Crossings result;
    if (degenerate_ones && std::find(flat.begin(), flat.end(), true) == flat.end()) return result;
    CGAL::box_self_intersection_d(boxes.begin(), boxes.end(), [&](const Box& a, const Box& b) {
      const Index f = a.info(), g = b.info();
      if ((flat[f] || flat[g]) != degenerate_ones) return;
      const Triangle &s = topology_.triangles()[f], &t = topology_.triangles()[g];
      const bool face = topology_.element(f) == Element::Face || topology_.element(g) == Element::Face;
      if (!face && std::find_first_of(s.begin(), s.end(), t.begin(), t.end()) != s.end()) return;
      if (degenerate_ones ? triangles_cross(s, t, x_) : cross(s, t)) result.insert(ordered(f, g));
    });
    return result;
  }

  // The rule of CGAL's function for two proper triangles: a common edge, only folded flat; a common vertex,
  // only when the opposite side of one meets the other. The same three vertices: they coincide.
  bool cross(const Triangle& s, const Triangle& t) const {
    std::vector<Index> common, only_s, only_t;
    for (const Index v : s) (std::count(t.begin(), t.end(), v) ? common : only_s).push_back(v);
    for (const Index v : t) {
      if (!std::count(s.begin(), s.end(), v)) only_t.push_back(v);
    }
    const auto p = [&](Index v) { return points_[v]; };
    const Kernel::Triangle_3 a(p(s[0]), p(s[1]), p(s[2])), b(p(t[0]), p(t[1]), p(t[2]));
    switch (common.size()) {
      case 0:
        return CGAL::do_intersect(a, b);
      case 1:
        return CGAL::do_intersect(a, Kernel::Segment_3(p(only_t[0]), p(only_t[1]))) ||
               CGAL::do_intersect(b, Kernel::Segment_3(p(only_s[0]), p(only_s[1])));
      case 2:
        return CGAL::coplanar(p(common[0]), p(common[1]), p(only_s[0]), p(only_t[0])) &&
               CGAL::coplanar_orientation(p(common[0]), p(common[1]), p(only_s[0]), p(only_t[0])) ==
                   CGAL::POSITIVE;
      default:
        return true;
    }
  }

  const Topology& topology_;
  std::span<const double> x_;
  std::vector<Kernel::Point_3> points_;
};

Crossings by_foldproof(StepChecker& checker, std::span<const double> x) {
  StaticResult result;
  const std::span<const double> spans[] = {x};
  const Result<void> done = checker.check_static(spans, {}, result);
  EXPECT_TRUE(done.has_value()) << (done ? "" : done.error().line());
  Crossings crossings;
  for (const TriangleCrossing& c : result.crossings) {
    EXPECT_LT(c.triangle_a, c.triangle_b);
    EXPECT_TRUE(crossings.insert({c.triangle_a, c.triangle_b}).second) << "a pair is listed twice";
  }
  return crossings;
}

void expect_equal(const Crossings& actual, const Crossings& expected, const std::string& where) {
  EXPECT_EQ(actual.size(), expected.size()) << where;
  for (const auto& [a, b] : expected)
    EXPECT_TRUE(actual.count({a, b})) << where << ": missing " << a << " " << b;
  for (const auto& [a, b] : actual)
    EXPECT_TRUE(expected.count({a, b})) << where << ": too much " << a << " " << b;
}

// ---- Real poses.

struct RealMotion {
  const char* name;
  Index stride;  ///< Tests every stride-th frame, unless FOLDPROOF_ALL_FRAMES=1.
};

void PrintTo(const RealMotion& motion, std::ostream* out) { *out << motion.name; }

constexpr RealMotion kRealMotions[] = {
    {"lion_poses", 1},       {"lion_anim", 10},   {"hand_poses", 1},   {"hand_train", 10},
    {"hand_anim", 10},       {"horse_poses", 1},  {"horse_gallop", 6}, {"elephant_poses", 1},
    {"elephant_gallop", 10}, {"samba", 10},       {"rumba", 10},       {"cloth_ball", 1},
    {"rod_twist", 1},        {"cloth_funnel", 1},
};

class RealPoses : public ::testing::TestWithParam<RealMotion> {};

TEST_P(RealPoses, CrossingsEqualCgals) {
  const auto data = data_directory();
  if (!data) GTEST_SKIP() << kNoData;
  const auto motion = open_real_motion(*data, GetParam().name);
  const Index stride = all_frames() ? 1 : GetParam().stride;
  std::vector<double> x(3 * motion->topology().vertex_count());
  ASSERT_TRUE(motion->read_frame(0, x));
  auto built = Hierarchy::build(motion->topology(), x);
  ASSERT_TRUE(built) << built.error().line();
  StepChecker checker({std::make_shared<const Hierarchy>(std::move(*built))});
  std::size_t crossings = 0, frames = 0;
  for (Index k = 0; k < motion->frame_count(); k += stride, ++frames) {
    ASSERT_TRUE(motion->read_frame(k, x));
    const Crossings expected = CgalPose(motion->topology(), x).crossings();
    expect_equal(by_foldproof(checker, x), expected, fmt::format("{} frame {}", GetParam().name, k));
    crossings += expected.size();
  }
  fmt::print("{:16} {:3} of {:3} frames, {:6} crossings, all as CGAL finds them\n", GetParam().name, frames,
             motion->frame_count(), crossings);
}

INSTANTIATE_TEST_SUITE_P(Motions, RealPoses, ::testing::ValuesIn(kRealMotions),
                         [](const auto& instance) { return std::string(instance.param.name); });

// ---- Generated meshes that cross, touch and fold.

class GeneratedPoses : public ::testing::TestWithParam<MeshFamily> {};

TEST_P(GeneratedPoses, CrossingsEqualCgalsAndTheOracle) {
  std::size_t crossings = 0;
  Rng rng(61);
  // Coarser grids make more vertices coincide, more triangles coplanar, and some of them degenerate.
  for (const double grid : {0.0, 1.0 / 32, 1.0 / 12, 1.0 / 6}) {
    const Mesh mesh = GetParam().make(rng);
    Scene scene;
    scene.topologies.push_back(mesh.topology());
    scene.x0.push_back(deformed(mesh.positions, grid == 0 ? 0.3 : 0.1, grid, rng));
    Crossings by_oracle;
    for (const TriangleCrossing& c : brute_force_static(scene, {}).crossings) {
      by_oracle.insert({c.triangle_a, c.triangle_b});
    }
    const std::string where = fmt::format("grid {}", grid);
    expect_equal(CgalPose(scene.topologies[0], scene.x0[0]).crossings(), by_oracle,
                 where + ", CGAL and the oracle");
    for (const Index leaf : {1, 16}) {
      StepChecker checker(scene.hierarchies(leaf));
      expect_equal(by_foldproof(checker, scene.x0[0]), by_oracle, where);
    }
    crossings += by_oracle.size();
  }
  EXPECT_GT(crossings, 100u);
}

// A power of two does not change exact predicates; nor may it change the boxes' tests.
TEST_P(GeneratedPoses, PowersOfTwoChangeNothing) {
  Rng rng(63);
  const Mesh mesh = GetParam().make(rng);
  Scene scene;
  scene.topologies.push_back(mesh.topology());
  scene.x0.push_back(deformed(mesh.positions, 0.5, 1.0 / 64, rng));
  StepChecker checker(scene.hierarchies(16));
  const Crossings expected = by_foldproof(checker, scene.x0[0]);
  EXPECT_GT(expected.size(), 5u);
  for (const double scale : {0x1p-1000, 0x1p-400, 0x1p-140, 0x1p127, 0x1p400, 0x1p1000}) {
    std::vector<double> x = scene.x0[0];
    for (double& coordinate : x) coordinate *= scale;
    expect_equal(by_foldproof(checker, x), expected, fmt::format("scale {}", scale));
  }
}

TEST_P(GeneratedPoses, SeveralObjectsEqualTheOracle) {
  Rng rng(62);
  Scene scene;
  for (int i = 0; i < 3; ++i) {
    const Mesh mesh =
        i == 0 ? GetParam().make(rng) : mesh_families()[rng() % mesh_families().size()].make(rng);
    scene.topologies.push_back(mesh.topology());
    scene.x0.push_back(deformed(mesh.positions, 0.2, i == 1 ? 1.0 / 16 : 0, rng));
  }
  for (const auto& [within, between] : {std::pair{true, true}, {true, false}, {false, true}}) {
    StepSettings settings;
    settings.within = within;
    settings.between = between;
    StepChecker checker(scene.hierarchies(16));
    StaticResult actual;
    const auto x = scene.spans0();
    ASSERT_TRUE(checker.check_static(x, settings, actual));
    std::vector<PairKey> found, expected;
    for (const TriangleCrossing& c : actual.crossings) found.push_back(key(c));
    for (const TriangleCrossing& c : brute_force_static(scene, settings).crossings)
      expected.push_back(key(c));
    std::sort(expected.begin(), expected.end());
    EXPECT_EQ(found, expected) << "within " << within << ", between " << between;
    if (between) {
      EXPECT_GT(expected.size(), 20u);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Meshes, GeneratedPoses,
                         ::testing::ValuesIn(mesh_families().begin(), mesh_families().end()),
                         [](const auto& instance) { return std::string(instance.param.name); });

}  // namespace
}  // namespace foldproof::oracle
