// That files appear whole or not at all; tests/studios/vtk_test.py reads what is in them with VTK.
#include <gmock/gmock.h>

#include "report/sinking_triangle.h"

namespace foldproof {
namespace {

using namespace foldproof::testing;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

Result<CheckTotals> check(const std::string& path, Motions motions, const CheckHooks& hooks = {}) {
  auto writer = vtk_report(path, motions, {});
  if (!writer) return tl::unexpected(writer.error());
  std::vector<std::unique_ptr<ReportWriter>> writers;
  writers.push_back(std::move(*writer));
  return run_check(motions, {}, writers, hooks);
}

std::vector<std::string> names_in(const std::string& directory) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(directory))
    names.push_back(entry.path().filename());
  std::sort(names.begin(), names.end());
  return names;
}

TEST(VtkReport, AFileForEachStepAndTheirTimes) {
  const TemporaryDirectory directory;
  ASSERT_TRUE(check(directory / "a.b.pvd", list(sinking_triangle(kSinking))));
  EXPECT_THAT(directory.names(), ElementsAre("a.b", "a.b.pvd"));
  EXPECT_THAT(names_in(directory / "a.b"), ElementsAre("step000000.vtp", "step000001.vtp", "step000002.vtp",
                                                       "step000003.vtp", "step000004.vtp"));
  EXPECT_THAT(read_file(directory / "a.b.pvd"),
              HasSubstr("<DataSet timestep=\"2\" part=\"0\" file=\"a.b/step000002.vtp\"/>"));
}

TEST(VtkReport, ReadBackItIsTheWholeMotion) {
  const TemporaryDirectory directory;
  const auto motion = sinking_triangle(kSinking);
  ASSERT_TRUE(check(directory / "a.pvd", list(sinking_triangle(kSinking))));
  const std::string path = directory / "a.pvd";
  const auto read = open_motions(std::span(&path, 1));
  ASSERT_TRUE(read);
  ASSERT_EQ((*read)[0]->frame_count(), motion->frame_count());
  for (Index k = 0; k < motion->frame_count(); ++k) {
    std::vector<double> written(3 * motion->topology().vertex_count()), given(written.size());
    ASSERT_TRUE((*read)[0]->read_frame(k, written) && motion->read_frame(k, given));
    EXPECT_EQ(written, given) << "frame " << k;
  }
}

TEST(VtkReport, ASingleFrameIsOneMesh) {
  const TemporaryDirectory directory;
  ASSERT_TRUE(check(directory / "a.pvd", list(sinking_triangle({-0.4}))));
  EXPECT_THAT(names_in(directory / "a"), ElementsAre("step000000.vtp"));
  EXPECT_THAT(read_file(directory / "a.pvd"), HasSubstr("<DataSet timestep=\"0\" part=\"0\" file=\"a/"));
}

TEST(VtkReport, AnOlderOneIsReplacedAsAWhole) {
  const TemporaryDirectory directory;
  ASSERT_TRUE(check(directory / "a.pvd", list(sinking_triangle(kSinking))));
  ASSERT_TRUE(check(directory / "a.pvd", list(sinking_triangle({1.6, 0.6}))));
  EXPECT_THAT(directory.names(), ElementsAre("a", "a.pvd"));
  EXPECT_THAT(names_in(directory / "a"), ElementsAre("step000000.vtp", "step000001.vtp"));
}

TEST(VtkReport, ACancelledCheckLeavesWhatWasThere) {
  const TemporaryDirectory directory;
  ASSERT_TRUE(check(directory / "a.pvd", list(sinking_triangle({1.6, 0.6}))));
  const std::string before = read_file(directory / "a.pvd");
  std::atomic<bool> cancel = false;
  const CheckHooks hooks{.progress = [&](const CheckTotals&, std::uint64_t) { cancel = true; },
                         .cancel = &cancel};
  const auto totals = check(directory / "a.pvd", list(sinking_triangle(kSinking)), hooks);
  ASSERT_TRUE(totals);
  EXPECT_TRUE(totals->cancelled);
  EXPECT_EQ(totals->steps, 1u);
  EXPECT_THAT(directory.names(), ElementsAre("a", "a.pvd"));
  EXPECT_THAT(names_in(directory / "a"), ElementsAre("step000000.vtp", "step000001.vtp"));
  EXPECT_EQ(read_file(directory / "a.pvd"), before);
}

TEST(VtkReport, RefusesWhatItCannotOrShouldNotWrite) {
  const TemporaryDirectory directory;
  const auto refusal = [&](const std::string& path) {
    const auto motions = list(sinking_triangle(kSinking));
    const auto writer = vtk_report(path, motions, {});
    return writer ? std::string() : writer.error().line();
  };
  EXPECT_THAT(refusal(directory / "a.vtp"), HasSubstr("does not end in .pvd"));
  EXPECT_THAT(refusal(directory / "nowhere/a.pvd"), HasSubstr("cannot be written"));
  EXPECT_THAT(directory.names(), IsEmpty());

  std::filesystem::create_directory(directory / "a");
  std::ofstream(directory / "a/diary.txt") << "mine";
  EXPECT_THAT(refusal(directory / "a.pvd"), HasSubstr("holds other things than .vtp files"));
  std::ofstream(directory / "b") << "a file";
  EXPECT_THAT(refusal(directory / "b.pvd"), HasSubstr("holds other things than .vtp files"));
  EXPECT_THAT(directory.names(), ElementsAre("a", "b"));
  EXPECT_THAT(names_in(directory / "a"), ElementsAre("diary.txt"));
}

}  // namespace
}  // namespace foldproof
