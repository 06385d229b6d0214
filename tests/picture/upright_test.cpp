// Which axis points up, and from where contacts are seen. upright.json has cases that the page's tests check,
// too.
#include "picture/upright.h"

#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <fstream>
#include <nlohmann/json.hpp>

#include "foldproof/eigen.h"

namespace foldproof {
namespace {

using nlohmann::json;

json cases() { return json::parse(std::ifstream(FOLDPROOF_SOURCE_DIR "/tests/picture/upright.json")); }

Up up_of(const json& value) { return value["up"] == "z" ? Up::Z : Up::Y; }
/// Three numbers, from the one at `first` on.
Vec3 vector_of(const json& values, std::size_t first = 0) {
  Vec3 vector;
  for (std::size_t k = 0; k < 3; ++k) vector[k] = values[first + k].get<double>();
  return vector;
}

TEST(Upright, GuessesTheAxisThatPointsUp) {
  const json all = cases();
  for (const json& motion : all["motions"]) {
    std::vector<Eigen::AlignedBox3d> poses;
    for (const json& box : motion["poses"])
      poses.emplace_back(to_eigen(vector_of(box)), to_eigen(vector_of(box, 3)));
    EXPECT_EQ(guess_up(poses), up_of(motion)) << motion["name"];
  }
  EXPECT_EQ(guess_up({}), Up::Y);
}

TEST(Upright, LooksAlongANormal) {
  const json all = cases();
  for (const json& one : all["normals"]) {
    const View view = view_along(vector_of(one["normal"]), up_of(one));
    EXPECT_LT((view.from - vector_of(one["from"])).norm(), 1e-9) << one;
    EXPECT_EQ(view.up, up_of(one) == Up::Y ? Vec3(0, 1, 0) : Vec3(0, 0, 1));
  }
  for (const json& one : all["defaults"])
    EXPECT_LT((default_view(up_of(one)).from - vector_of(one["from"])).norm(), 1e-9) << one;
}

/// A triangle that stands on z = 0 and hops along y, in memory as a file of any format.
std::vector<std::unique_ptr<Motion>> walk(const std::string& name, int frames) {
  std::vector<std::vector<double>> poses;
  for (int k = 0; k < frames; ++k) {
    const double y = 0.1 * k;
    poses.push_back({0, y, 0, 1, y, 0, 0, y, 2 + 0.1 * (k % 2)});
  }
  std::vector<std::unique_ptr<Motion>> motions;
  motions.push_back(memory_motion(name, *Topology::make(3, {{0, 1, 2}}), std::move(poses)));
  return motions;
}

TEST(Upright, ExtentCoversAllOfAMotion) {
  for (const int frames : {1, 2, 32, 33, 500}) {
    const auto extent = extent_of(walk("walk.npz", frames));
    ASSERT_TRUE(extent);
    EXPECT_NEAR(extent->box.max().y(), 0.1 * (frames - 1), 1e-9);
    EXPECT_EQ(extent->up, frames == 1 ? Up::Y : Up::Z);
  }
  EXPECT_EQ(extent_of(walk("walk.glb", 9))->up, Up::Y);
}

/// A square across `x` = const, with a mark on one triangle of it.
struct Wall {
  Topology topology = *Topology::make(8, {{0, 1, 2}, {0, 2, 3}, {4, 5, 6}, {4, 6, 7}});
  /// The second square is in front of the first and hides it.
  std::vector<double> x{-1, -1, 0,   1, -1, 0,   1, 1, 0,   -1, 1, 0,
                        -1, -1, 0.2, 1, -1, 0.2, 1, 1, 0.2, -1, 1, 0.2};
  View seen(std::vector<std::uint8_t> marked, const Vec3& normal, Up up = Up::Y) const {
    const PictureMesh mesh{.topology = &topology, .positions = x};
    const ContactMarks marks{std::move(marked)};
    return *view_of(std::span(&mesh, 1), marks, {}, normal, up);
  }
};

TEST(Upright, ShowsWhatIsMarked) {
  const Wall wall;
  EXPECT_GT(wall.seen({0, 0, 1, 0}, {0, 0, 1}).from.z(), 0.5);
  EXPECT_LT(wall.seen({1, 0, 0, 0}, {0, 0, 1}).from.z(), -0.5);  // from the front, it is hidden
  EXPECT_LT(wall.seen({1, 0, 0, 0}, {0, 0, 0}).from.z(), 0);
  // Views across this normal show the wall itself.
  EXPECT_GT(wall.seen({0, 0, 1, 1}, {1, 0, 0}).from.z(), 0.5);
  EXPECT_EQ(wall.seen({0, 0, 0, 0}, {0, 0, 0}, Up::Z).from, default_view(Up::Z).from);
}

// A floor through which a wall goes. Their normals show only one of them; from the side both are seen.
TEST(Upright, ShowsBothSidesOfAContactAndItsCurve) {
  const Topology topology = *Topology::make(8, {{0, 1, 2}, {0, 2, 3}, {4, 5, 6}, {4, 6, 7}});
  const std::vector<double> x{-1, 0, -1, 1, 0, -1, 1, 0, 1, -1, 0, 1, 0, -1, -1, 0, -1, 1, 0, 1, 1, 0, 1, -1};
  const std::vector<std::vector<Vec3>> curves{{Vec3(0, 0, -1), Vec3(0, 0, 0), Vec3(0, 0, 1)}};
  const PictureMesh mesh{.topology = &topology, .positions = x};
  for (const std::uint8_t floor : {1, 2}) {
    const auto wall = static_cast<std::uint8_t>(3 - floor);
    const ContactMarks marks{{floor, floor, wall, wall}};
    for (const Vec3& normal : {Vec3(0, 1, 0), Vec3(1, 0, 0), Vec3(0, 0, 0)}) {
      const Vec3 from = view_of(std::span(&mesh, 1), marks, curves, normal, Up::Y)->from.normalized();
      EXPECT_GT(from.y(), 0.2) << normal.x() << normal.y();  // of the floor, and from above
      EXPECT_GT(std::abs(from.x()), 0.2) << normal.x() << normal.y();
    }
  }
}

}  // namespace
}  // namespace foldproof
