#include "system/c_locale.h"

#include <locale.h>

#include <string>

namespace foldproof::inline internal {

CLocale::CLocale() {
  ::_configthreadlocale(_ENABLE_PER_THREAD_LOCALE);
  before_ = new std::string(::setlocale(LC_NUMERIC, nullptr));
  ::setlocale(LC_NUMERIC, "C");
}

CLocale::~CLocale() {
  const auto* before = static_cast<std::string*>(before_);
  ::setlocale(LC_NUMERIC, before->c_str());
  delete before;
}

}  // namespace foldproof::inline internal
