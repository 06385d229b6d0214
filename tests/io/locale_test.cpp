// All tests of this program run in a locale whose decimal point has two bytes, as that of ps_AF.UTF-8 has. A
// parser that asks for it would cut numbers off there.
#include <gtest/gtest.h>
#include <locale.h>

#include "system/c_locale.h"

extern "C" lconv* localeconv() noexcept {
  static char two_bytes[] = "\xd9\xab", one_byte[] = ".", none[] = "";
  static lconv pashto{}, c{};
  for (lconv* each : {&pashto, &c}) each->thousands_sep = each->grouping = none;
  pashto.decimal_point = two_bytes;
  c.decimal_point = one_byte;
  return uselocale(nullptr) == LC_GLOBAL_LOCALE ? &pashto : &c;
}

namespace foldproof {
namespace {

TEST(CLocale, HoldsWhileItLives) {
  EXPECT_STREQ(localeconv()->decimal_point, "\xd9\xab");
  {
    const CLocale numbers;
    EXPECT_STREQ(localeconv()->decimal_point, ".");
  }
  EXPECT_STREQ(localeconv()->decimal_point, "\xd9\xab");
}

}  // namespace
}  // namespace foldproof
