#include "foldproof/base.h"

#include <gtest/gtest.h>

namespace foldproof {
namespace {

TEST(Error, IsOneLineWithPlaceProblemAndRemedy) {
  const Error error{"walk.obj:12", "face names vertex 99", "export the mesh again"};
  EXPECT_EQ(error.line(), "walk.obj:12: face names vertex 99; export the mesh again");
}

TEST(Error, ControlCharactersFromAFileCannotBreakTheLine) {
  const Error error{"a\nb", "c\x1b[31m", "d\x7f"};
  EXPECT_EQ(error.line(), "a?b: c?[31m; d?");
}

}  // namespace
}  // namespace foldproof
