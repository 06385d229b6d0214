/// Numbers for people.
#pragma once

#include <cstdint>
#include <string>

namespace foldproof {

/// "9,248".
inline std::string grouped(std::uint64_t number) {
  std::string digits = std::to_string(number);
  for (std::size_t at = digits.size(); at > 3; at -= 3) digits.insert(at - 3, 1, ',');
  return digits;
}

/// "1 step", "2 steps".
inline std::string counted(std::uint64_t number, const char* noun) {
  return grouped(number) + " " + noun + (number == 1 ? "" : "s");
}

}  // namespace foldproof
