#include "io/new_directory.h"

#include <gmock/gmock.h>
#include <unistd.h>

#include <fstream>

#include "report/sinking_triangle.h"

namespace foldproof::io {
namespace {

using foldproof::testing::TemporaryDirectory;
using ::testing::ElementsAre;
namespace fs = std::filesystem;

TEST(NewDirectory, AppearsWholeOrNotAtAll) {
  const TemporaryDirectory folder;
  { ASSERT_TRUE(NewDirectory::open(folder / "a")); }
  EXPECT_THAT(folder.names(), ElementsAre());
  auto made = NewDirectory::open(folder / "a");
  ASSERT_TRUE(made);
  std::ofstream(made->path() / "new") << "1";
  EXPECT_FALSE(fs::exists(folder / "a"));
  ASSERT_TRUE(made->commit());
  EXPECT_THAT(folder.names(), ElementsAre("a"));
}

TEST(NewDirectory, OnlyReplaceTakesTheNameOfAnother) {
  const TemporaryDirectory folder;
  fs::create_directory(folder / "a");
  std::ofstream(folder / "a/old") << "1";
  {
    auto made = NewDirectory::open(folder / "a");
    ASSERT_TRUE(made);
    EXPECT_FALSE(made->commit());
  }
  EXPECT_TRUE(fs::exists(folder / "a/old"));
  auto made = NewDirectory::open(folder / "a");
  ASSERT_TRUE(made);
  ASSERT_TRUE(made->replace());
  EXPECT_TRUE(fs::is_empty(folder / "a"));
  EXPECT_THAT(folder.names(), ElementsAre("a"));
}

TEST(NewDirectory, LeavesWhatAnotherProcessOfItsNumberLeftBehind) {
  const TemporaryDirectory folder;
  const std::string left = "." + std::string("a.") + std::to_string(::getpid());
  fs::create_directory(folder / (left + "-0.part"));
  std::ofstream(folder / (left + "-1.part")) << "a file";
  auto made = NewDirectory::open(folder / "a");
  ASSERT_TRUE(made) << made.error().line();
  ASSERT_TRUE(made->commit());
  EXPECT_EQ(folder.names().size(), 3u);
  const auto failed = NewDirectory::open(folder / "none/a");
  ASSERT_FALSE(failed);
  EXPECT_NE(failed.error().line().find("No such file or directory"), std::string::npos);
}

}  // namespace
}  // namespace foldproof::io
