#include "io/gltf_clips.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <string_view>

#include "base/nearest_name.h"

namespace foldproof::io {
namespace {

std::string number_of(std::size_t clip) { return fmt::format("animations[{}]", clip); }

/// What ReadOptions::clip calls each: their names where these are unique.
std::vector<std::string> names_of(std::span<const GltfClip> clips) {
  std::map<std::string_view, std::size_t> count;
  for (const GltfClip& clip : clips) ++count[clip.name];
  std::vector<std::string> names;
  for (std::size_t i = 0; i < clips.size(); ++i) {
    const std::string& name = clips[i].name;
    names.push_back(count[name] == 1 && !name.empty() && name != "all" ? name : number_of(i));
  }
  return names;
}

/// "'a'", "'a' and 'b'", "'a', 'b', 'c' and 9 more".
std::string enumerate(std::span<const std::string> names) {
  constexpr std::size_t kShown = 4;
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (i + 1 == kShown && names.size() > kShown) return text + fmt::format(" and {} more", names.size() - i);
    text += fmt::format("{}'{}'", i == 0 ? "" : i + 1 == names.size() ? " and " : ", ", names[i]);
  }
  return text;
}

tl::unexpected<Error> no_such_clip(std::span<const std::string> names, const std::string& name,
                                   const std::string& file) {
  const auto nearest = nearest_name(name, names);
  return fail(ErrorCode::InvalidArgument, file, fmt::format("has no clip '{}'", name),
              (nearest ? fmt::format("did you mean '{}'? it has ", *nearest) : "it has ") + enumerate(names));
}

}  // namespace

Result<void> show_clip(std::vector<GltfClip> clips, const std::string& name, const std::string& file,
                       GltfScene& scene) {
  if (clips.empty()) return {};
  scene.clips = names_of(clips);
  std::size_t shown = 0;
  if (name.empty()) {
    shown =
        static_cast<std::size_t>(std::ranges::max_element(clips, {}, &GltfClip::duration) - clips.begin());
  } else {
    while (shown < clips.size() && name != scene.clips[shown] && name != number_of(shown)) ++shown;
    if (shown == clips.size()) return no_such_clip(scene.clips, name, file);
  }
  GltfClip& clip = clips[shown];
  scene.clip = shown;
  scene.duration = clip.duration;
  std::set<std::pair<std::size_t, GltfPath>> driven;
  for (GltfChannel& channel : clip.channels) {
    if (driven.emplace(channel.node, channel.path).second) scene.channels.push_back(std::move(channel));
  }
  if (clips.size() == 1) return {};
  scene.taken_as = fmt::format("clip '{}'", scene.clips[shown]);
  if (!name.empty()) return {};
  scene.taken_as += fmt::format(", the longest of {}", clips.size());
  scene.unchecked = clips.size() == 2
                        ? "the other clip was not checked (--clip)"
                        : fmt::format("{} other clips were not checked (--clip)", clips.size() - 1);
  return {};
}

}  // namespace foldproof::io
