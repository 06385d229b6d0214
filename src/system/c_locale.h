/// Numbers in text as the C locale writes them, whatever the program's locale is.
#pragma once

namespace foldproof::inline internal {

/// While it lives, this thread has the C locale's decimal point. For parsers that ask localeconv and strtod,
/// as nlohmann's does: it takes a single byte for the point, which in some locales has two.
class CLocale {
 public:
  CLocale();
  ~CLocale();
  CLocale(const CLocale&) = delete;
  CLocale& operator=(const CLocale&) = delete;

 private:
  void* before_;
};

}  // namespace foldproof::inline internal
