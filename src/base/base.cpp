#include "foldproof/base.h"

namespace foldproof {

std::string Error::line() const {
  std::string text = where + ": " + problem + "; " + remedy;
  for (char& c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x20 || byte == 0x7f) c = '?';
  }
  return text;
}

const char* version() { return FOLDPROOF_VERSION; }

}  // namespace foldproof
