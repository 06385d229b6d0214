#include "base/nearest_name.h"

#include <gtest/gtest.h>

#include <vector>

namespace foldproof {
namespace {

const std::vector<std::string> kNames{"thickness", "tolerance", "within", "between"};

TEST(NearestName, FindsWhatAMistypedNameWasMeantToBe) {
  EXPECT_EQ(nearest_name("thicknes", kNames), "thickness");
  EXPECT_EQ(nearest_name("toleracne", kNames), "tolerance");  // two neighbors exchanged
  EXPECT_EQ(nearest_name("witin", kNames), "within");
}

TEST(NearestName, SuggestsNothingForAnotherWord) {
  EXPECT_EQ(nearest_name("color", kNames), std::nullopt);
  EXPECT_EQ(nearest_name("thickness", {}), std::nullopt);
}

}  // namespace
}  // namespace foldproof
