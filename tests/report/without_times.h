#pragma once

#include <string>

namespace foldproof::testing {

/// JSON that the program wrote, without the times that it measured.
inline std::string without_times(std::string text) {
  const auto erase = [&](const std::string& key, const char* end) {
    for (std::size_t at = text.find(key); at != text.npos; at = text.find(key, at)) {
      at += key.size();
      text.erase(at, text.find_first_of(end, at) - at);
    }
  };
  erase("\"milliseconds\":{", "}");
  erase("\"seconds\":", ",}");
  return text;
}

}  // namespace foldproof::testing
