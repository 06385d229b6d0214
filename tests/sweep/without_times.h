#pragma once

#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

namespace foldproof::testing {

/// What lines of results say apart from how long things took.
inline std::string without_times(const std::string& lines) {
  std::string text;
  std::istringstream stream(lines);
  for (std::string line; std::getline(stream, line);) {
    auto json = nlohmann::ordered_json::parse(line);
    json["seconds"] = 0;
    if (json.contains("totals"))
      json["totals"]["milliseconds"] = json["totals"]["contacts"]["milliseconds"] = 0;
    text += json.dump() + '\n';
  }
  return text;
}

}  // namespace foldproof::testing
