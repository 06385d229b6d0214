#include <fmt/format.h>
#include <gmock/gmock.h>

#include "report/sinking_triangle.h"

namespace foldproof {
namespace {

using namespace foldproof::testing;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

/// Two triangles of a square, with vertices of their own at its diagonal: 1 and 3, 2 and 4. In frame k,
/// vertex 4 is moved by shifts[k]. Vertex 6 is in no triangle.
std::unique_ptr<Motion> square(const std::vector<double>& shifts) {
  std::vector<std::vector<double>> frames;
  for (const double z : shifts)
    frames.push_back({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, -0.0, 0, 0, 1, z, 1, 1, 0, 0, 1, 0});
  return memory_motion("square", *Topology::make(7, {{0, 1, 2}, {3, 5, 4}}), std::move(frames));
}

std::vector<std::string> notices(Motions motions, const CheckSettings& settings = {}) {
  const auto totals = run_check(motions, settings, {});
  EXPECT_TRUE(totals) << totals.error().line();
  std::vector<std::string> texts;
  for (const auto& notice : totals->notices)
    texts.push_back(fmt::format("{}: {}", notice.object, notice.text));
  return texts;
}

TEST(Coincidences, AreNoticedInASingleFrame) {
  EXPECT_THAT(
      notices(list(square({0}))),
      ElementsAre("0: 2 of 7 vertices lie exactly where others do, and so triangles touch there; if they "
                  "are of one surface, check it with --weld"));
}

TEST(Coincidences, AreFollowedFromFrameToFrame) {
  EXPECT_THAT(
      notices(list(lone_floor(3), square({0, 0, 0}))),
      ElementsAre("1: 2 of 7 vertices lie exactly where others do in all frames, and so triangles touch "
                  "there; if they are of one surface, check it with --weld"));
  const char* parted =
      "0: 2 of 7 vertices lie exactly where others do at first, and so triangles touch there; 1 of them part "
      "in "
      "frame 2 or later, and --weld refuses to merge these";
  EXPECT_THAT(notices(list(square({0, 0, 1, 0}))), ElementsAre(parted));
  CheckSettings settings;
  settings.substeps = 3;
  EXPECT_THAT(notices(list(square({0, 0, 1})), settings), ElementsAre(parted));
  settings.substeps = 1;
  settings.poses = true;
  EXPECT_THAT(notices(list(square({0, 0, 1})), settings), ElementsAre(parted));
}

TEST(Coincidences, AreNotNamedWhereTheyMakeNoContact) {
  EXPECT_THAT(notices(list(sinking_triangle({3, 2, 1}))), IsEmpty());
  EXPECT_THAT(notices(list(sinking_triangle(kSinking))), IsEmpty());
  CheckSettings settings;
  settings.step.within = false;
  EXPECT_THAT(notices(list(square({0, 0}), square({0, 0})), settings), IsEmpty());
}

}  // namespace
}  // namespace foldproof
