#include "base/duration.h"

#include <fmt/format.h>

#include <cmath>

namespace foldproof::internal {

// Each limit is where rounding would reach the next unit.
std::string duration(double milliseconds) {
  if (!std::isfinite(milliseconds)) return "unknown";
  if (milliseconds <= 0) return "0 ms";
  if (milliseconds < 0.01) return "< 0.01 ms";
  if (milliseconds < 1) return fmt::format("{:.2g} ms", milliseconds);
  if (milliseconds < 999.5) return fmt::format("{:.3g} ms", milliseconds);
  const double seconds = milliseconds / 1000;
  if (seconds < 119.5) return fmt::format("{:.3g} s", seconds);
  const double minutes = std::floor((seconds + 0.5) / 60);
  if (minutes < 120)
    return fmt::format("{:.0f} min {:.0f} s", minutes, std::floor(seconds + 0.5) - 60 * minutes);
  const double all = std::round(seconds / 60), hours = std::floor(all / 60);
  return fmt::format("{:.0f} h {:.0f} min", hours, all - 60 * hours);
}

}  // namespace foldproof::internal
