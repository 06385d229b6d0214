/// Numbers in text as the C locale writes them, whatever the program's locale is.
#pragma once

#include <locale.h>

namespace foldproof::inline internal {

/// While it lives, this thread has the C locale's decimal point. For parsers that ask localeconv and strtod,
/// as nlohmann's does: it takes a single byte for the point, which in some locales has two.
class CLocale {
 public:
  CLocale() : before_(uselocale(c_locale())) {}
  ~CLocale() { uselocale(before_); }
  CLocale(const CLocale&) = delete;
  CLocale& operator=(const CLocale&) = delete;

 private:
  static locale_t c_locale() {
    static const locale_t locale = newlocale(LC_NUMERIC_MASK, "C", nullptr);
    return locale;
  }
  locale_t before_;
};

}  // namespace foldproof::inline internal
