#include "io/parts.h"

#include <fmt/format.h>

#include <unordered_map>

namespace foldproof {

const MotionInfo& Motion::info() const {
  static const MotionInfo kNone;
  return kNone;
}

namespace io {

ObjectParts parts_by_name(std::span<const std::string> names, std::span<const Index> of_triangle) {
  ObjectParts parts;
  std::vector<Index> part_of(names.size(), kNoIndex);
  std::unordered_map<std::string_view, Index> known;
  parts.of_triangle.reserve(of_triangle.size());
  for (const Index id : of_triangle) {
    if (part_of[id] == kNoIndex) {
      const auto [at, is_new] = known.try_emplace(names[id], static_cast<Index>(parts.names.size()));
      if (is_new) parts.names.push_back(names[id]);
      part_of[id] = at->second;
    }
    parts.of_triangle.push_back(part_of[id]);
  }
  return parts.names.size() < 2 ? ObjectParts() : parts;
}

ObjectParts parts_by_number(std::string_view kind, std::span<const std::int64_t> of_triangle) {
  ObjectParts parts;
  std::unordered_map<std::int64_t, Index> known;
  parts.of_triangle.reserve(of_triangle.size());
  for (const std::int64_t number : of_triangle) {
    const auto [at, is_new] = known.try_emplace(number, static_cast<Index>(parts.names.size()));
    if (is_new) parts.names.push_back(fmt::format("{} {}", kind, number));
    parts.of_triangle.push_back(at->second);
  }
  return parts.names.size() < 2 ? ObjectParts() : parts;
}

std::string_view part_kind(std::string_view name) {
  if (name.starts_with("face_")) name.remove_prefix(5);
  for (const std::string_view ending : {"_id", "_ids", "s"}) {
    if (name.ends_with(ending)) {
      name.remove_suffix(ending.size());
      break;
    }
  }
  for (const std::string_view kind : {"part", "label", "segment", "group"}) {
    if (name == kind) return kind;
  }
  return {};
}

void NameRuns::begin(std::size_t triangle, std::string_view name) {
  if (!runs_.empty() && runs_.back().first == triangle) runs_.pop_back();  // had no triangles
  runs_.push_back({triangle, name.empty() ? "default" : std::string(name)});
}

ObjectParts NameRuns::parts(std::size_t triangles) const {
  if (runs_.empty()) return {};
  std::vector<std::string> names{"default"};
  std::vector<Index> of_triangle(std::min(runs_.front().first, triangles), 0);
  of_triangle.reserve(triangles);
  for (std::size_t i = 0; i < runs_.size(); ++i) {
    names.push_back(runs_[i].name);
    const std::size_t end = i + 1 < runs_.size() ? runs_[i + 1].first : triangles;
    of_triangle.resize(end, static_cast<Index>(i + 1));
  }
  return parts_by_name(names, of_triangle);
}

}  // namespace io
}  // namespace foldproof
