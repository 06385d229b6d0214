#include "io/new_directory.h"

#include <gmock/gmock.h>

#include <fstream>

#include "report/needle.h"

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

}  // namespace
}  // namespace foldproof::io
