#include "io/gltf_clips.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <set>

namespace foldproof::io {
namespace {

/// Clips that lose all or some of what they drive, and those that win it, by index.
struct Losers {
  std::set<std::size_t> clips, winners;
};

/// "'a'", "'a' and 'b'", "'a', 'b', 'c' and 9 more".
std::string enumerate(std::span<const GltfClip> clips, const std::set<std::size_t>& which) {
  constexpr std::size_t kShown = 4;
  std::vector<std::string> names;
  for (const std::size_t i : which) {
    if (names.size() + 1 == kShown && which.size() > kShown) {
      names.push_back(fmt::format("{} more", which.size() - names.size()));
      break;
    }
    names.push_back(clips[i].name);
  }
  if (names.size() == 1) return names[0];
  return fmt::format("{} and {}", fmt::join(names.begin(), names.end() - 1, ", "), names.back());
}

std::string note_on(const Losers& losers, std::span<const GltfClip> clips, bool whole) {
  const bool one = losers.clips.size() == 1;
  return fmt::format(
      "{} {} {} not shown{}: {} {}what {} {} as long or longer; export {} alone to check it",
      one ? "clip" : "clips", enumerate(clips, losers.clips), one ? "is" : "are", whole ? "" : " in full",
      one ? "it drives" : "they drive", whole ? "" : "some of ", enumerate(clips, losers.winners),
      losers.winners.size() == 1 ? "drives, which is" : "drive, which are", one ? "it" : "each");
}

}  // namespace

void play_together(std::vector<GltfClip> clips, GltfScene& scene) {
  std::ranges::stable_sort(clips, std::greater(), &GltfClip::duration);
  std::map<std::pair<std::size_t, GltfPath>, std::size_t> drivers;  // clips, by node and property
  Losers not_shown, shown_in_part;
  for (std::size_t i = 0; i < clips.size(); ++i) {
    scene.duration = std::max(scene.duration, clips[i].duration);
    std::set<std::size_t> winners;
    bool shown = false;
    for (GltfChannel& channel : clips[i].channels) {
      const auto [driver, wins] = drivers.emplace(std::pair(channel.node, channel.path), i);
      if (wins) {
        scene.channels.push_back(std::move(channel));
        shown = true;
      } else if (driver->second != i) {
        winners.insert(driver->second);
      }
    }
    if (winners.empty()) continue;
    Losers& losers = shown ? shown_in_part : not_shown;
    losers.clips.insert(i);
    losers.winners.merge(winners);
  }
  if (!not_shown.clips.empty()) scene.notes.push_back(note_on(not_shown, clips, true));
  if (!shown_in_part.clips.empty()) scene.notes.push_back(note_on(shown_in_part, clips, false));
}

}  // namespace foldproof::io
