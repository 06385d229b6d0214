#include "io/gltf_frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

namespace foldproof::io {
namespace {

/// Sampling rates in use, ascending. Those of television are rounded: it shows 30000 frames in 1001 seconds.
constexpr std::array kRates{12.0,      15.0,     23.976024, 24.0,  25.0,  29.97003, 30.0,  48.0,
                            50.0,      59.94006, 60.0,      72.0,  75.0,  90.0,     96.0,  100.0,
                            119.88012, 120.0,    144.0,     150.0, 192.0, 200.0,    240.0, 300.0,
                            360.0,     400.0,    480.0,     500.0, 600.0, 720.0,    960.0, 1000.0};

/// Sorts, and removes what occurs twice.
void make_distinct(std::vector<double>& times) {
  std::ranges::sort(times);
  times.erase(std::unique(times.begin(), times.end()), times.end());
}

/// The times of all keys, each once. Accessors may share bytes, so there can be many more keys than times:
/// what is kept meanwhile is at most a few times as long as the result.
std::vector<double> key_times(const GltfScene& scene) {
  std::vector<double> times;
  std::size_t limit = 1 << 16;
  std::set<std::size_t> seen;
  for (const GltfChannel& channel : scene.channels) {
    if (!seen.insert(channel.times_index).second) continue;
    for (std::uint64_t i = 0; i < channel.times.count(); ++i) {
      times.push_back(channel.times.get(i, 0));
      if (times.size() < limit) continue;
      make_distinct(times);
      limit = std::max(limit, 2 * times.size());
    }
  }
  make_distinct(times);
  return times;
}

}  // namespace

bool is_time_of_key(double time, double key) {
  constexpr double kRounding = 0x1p-22;  // two to four units in the last place of a float
  return std::abs(time - key) <= kRounding * key;
}

GltfFrames::GltfFrames(double fps, double duration) : fps_(fps), duration_(duration) {
  // A last key just after a frame is that frame: exporters add up rounded times. But a motion that is shorter
  // than this still has a first and a last key.
  constexpr double kRounding = 1e-4;
  last_ = std::max(std::ceil(duration * fps - kRounding), duration > 0 ? 1.0 : 0.0);
}

bool GltfFrames::shows(double key) const {
  const double nearest = std::min(std::round(key * fps_), last_);
  return is_time_of_key(time(nearest), key) || is_time_of_key(duration_, key);
}

std::string note_on_keys(const GltfScene& scene, double fps, double max_frames) {
  const std::vector<double> times = key_times(scene);
  const GltfFrames chosen(fps, scene.duration);
  const auto count = std::ranges::count_if(times, [&](double time) { return !chosen.shows(time); });
  if (count == 0) return "";
  // Lower rates show less of how a node turns; one that is nearly the chosen one may be what was meant.
  const auto shows_all = [&](double rate) {
    const GltfFrames frames(rate, scene.duration);
    return rate > 0.99 * fps && frames.count() <= max_frames &&
           std::ranges::all_of(times, [&](double time) { return frames.shows(time); });
  };
  const auto better = std::ranges::find_if(kRates, shows_all);
  return fmt::format("{} {} between frames at {} a second; {}", count, count == 1 ? "key lies" : "keys lie",
                     fps,
                     better != kRates.end() ? fmt::format("with --fps {} every key is a frame", *better)
                                            : "a higher --fps comes closer to them");
}

}  // namespace foldproof::io
