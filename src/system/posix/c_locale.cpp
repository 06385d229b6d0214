#include "system/c_locale.h"

#include <locale.h>
#ifdef __APPLE__
#include <xlocale.h>
#endif

namespace foldproof::inline internal {
namespace {

locale_t c_locale() {
  static const locale_t locale = ::newlocale(LC_NUMERIC_MASK, "C", nullptr);
  return locale;
}

}  // namespace

CLocale::CLocale() : before_(::uselocale(c_locale())) {}
CLocale::~CLocale() { ::uselocale(static_cast<locale_t>(before_)); }

}  // namespace foldproof::inline internal
