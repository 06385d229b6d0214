// What build_info() says the vector code uses is what Highway chooses.
#include <gmock/gmock.h>

#include "arithmetic/everything.h"
#include "foldproof/base.h"

namespace foldproof::testing {
namespace {

TEST(InstructionSet, IsTheOneInUse) {
  on_every_target([] {
    const std::string name = target_in_use();
    EXPECT_THAT(build_info(), ::testing::EndsWith(", " + (name.starts_with("AVX3") ? "AVX-512" : name)));
  });
}

}  // namespace
}  // namespace foldproof::testing
