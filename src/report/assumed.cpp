#include "report/assumed.h"

#include <fmt/format.h>

#include <cctype>

namespace foldproof {

std::string assumed(Motions motions, bool poses, const char* preposition) {
  std::string text;
  for (const auto& motion : motions) {
    const std::string& taken_as = motion->info().taken_as;
    if (taken_as.empty()) continue;
    const bool frames = std::isdigit(static_cast<unsigned char>(taken_as[0])) != 0;
    if (frames && poses) continue;
    const char* usual = frames ? "between" : "in";
    if (motions.size() == 1) return fmt::format(" {} {}", preposition ? preposition : usual, taken_as);
    text += fmt::format("{}{}: {}", text.empty() ? " (" : "; ", motion->name(), taken_as);
  }
  return text.empty() ? text : text + ")";
}

}  // namespace foldproof
