#include "io/seams.h"

#include <fmt/format.h>

#include <map>
#include <numeric>
#include <utility>

#include "base/grouped.h"

namespace foldproof::io {
namespace {

/// The name in lower case, letters and digits only, without words for a side.
std::string without_side(std::string_view name) {
  std::string kept;
  for (const char c : name) {
    const char lower = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    const bool plain = static_cast<unsigned char>(c) >= 0x80 || (lower >= 'a' && lower <= 'z') ||
                       (lower >= '0' && lower <= '9');
    if (plain) kept += lower;
  }
  // Longer words before those that they contain.
  for (const std::string_view word : {"outside", "inside", "frontside", "backside", "frontface", "backface",
                                      "front", "back", "outer", "inner", "side"}) {
    if (const std::size_t at = kept.find(word); at != kept.npos) {
      kept.erase(at, word.size());
      break;
    }
  }
  return kept;
}

std::string faces(std::uint64_t count, const char* one, const char* several) {
  return fmt::format("{} {}", grouped(count), count == 1 ? one : several);
}

/// The triangle with its smallest vertex first, in its own order.
Triangle from_smallest(const Triangle& t) {
  if (t[0] < t[1] && t[0] < t[2]) return t;
  return t[1] < t[2] ? Triangle{t[1], t[2], t[0]} : Triangle{t[2], t[0], t[1]};
}

std::string note_on_seams(std::span<const Index> merged, std::uint64_t sides) {
  std::uint64_t count = 0;
  for (std::size_t v = 0; v < merged.size(); ++v) count += merged[v] != v;
  std::string layers = sides == 0
                           ? ""
                           : faces(sides, "face lies on another of its surface and counts as one with it",
                                   "faces lie on others of their surface and count as one with them");
  if (count == 0) return layers;
  return fmt::format("{} of {} vertices {} on seams and {} merged; what meets there counts as neighbors{}{}",
                     grouped(count), grouped(merged.size()), count == 1 ? "lies" : "lie",
                     count == 1 ? "was" : "were", layers.empty() ? "" : "; ", layers);
}

std::string note_on_layers(const Layers& layers) {
  if (layers.others == 0) return "";
  std::string turned = ", turned around";
  if (layers.turned < layers.others)
    turned = layers.turned == 0 ? "" : fmt::format(", {} of them turned around", grouped(layers.turned));
  return fmt::format("{}{}; that is not counted as contact, and --no-weld counts it",
                     faces(layers.others, "face lies on another", "faces lie on others"), turned);
}

}  // namespace

AlikeVertices::AlikeVertices(Index vertices) : vertices_(vertices), members_(vertices) {
  std::iota(members_.begin(), members_.end(), Index{0});
  if (vertices > 0) ends_.push_back(vertices);
}

std::vector<Index> AlikeVertices::first() const {
  std::vector<Index> first(vertices_);
  std::iota(first.begin(), first.end(), Index{0});
  for (std::size_t s = 0, begin = 0; s < ends_.size(); begin = ends_[s++]) {
    for (std::size_t i = begin; i < ends_[s]; ++i) first[members_[i]] = members_[begin];
  }
  return first;
}

void MeshElements::merge(std::span<const Index> merged) {
  for (Triangle& t : faces) {
    for (Index& v : t) v = merged[v];
  }
  for (Index& p : points) p = merged[p];
  std::vector<Edge> longer;
  std::vector<Index> shrunk, line_values, point_values;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const auto [a, b] = std::minmax(merged[lines[i][0]], merged[lines[i][1]]);
    if (a == b) {
      shrunk.push_back(a);
    } else {
      longer.push_back({a, b});
    }
    if (!values.empty()) (a == b ? point_values : line_values).push_back(values[faces.size() + i]);
  }
  if (shrunk.empty()) {
    lines.swap(longer);
    return;
  }
  if (!values.empty()) {
    const auto at = values.begin() + static_cast<std::ptrdiff_t>(faces.size());
    std::copy(point_values.begin(), point_values.end(),
              std::copy(line_values.begin(), line_values.end(), at));
  }
  lines.swap(longer);
  points.insert(points.begin(), shrunk.begin(), shrunk.end());
}

Layers count_layers(std::span<const Triangle> faces, Index vertices, std::span<const Index> surfaces) {
  struct Face {
    Index low, high;  // of the two larger vertices
    Index surface, number;
    bool turned;
    auto operator<=>(const Face&) const = default;
  };
  // Buckets by the smallest vertex.
  std::vector<Index> end(vertices + std::size_t{1}, 0);
  const auto for_each = [&](auto visit) {
    for (Index i = 0; i < faces.size(); ++i) {
      const Triangle t = from_smallest(faces[i]);
      if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) continue;
      const Index surface = surfaces.empty() ? i : surfaces[i];
      visit(t[0], Face{std::min(t[1], t[2]), std::max(t[1], t[2]), surface, i, t[2] < t[1]});
    }
  };
  for_each([&](Index smallest, const Face&) { ++end[smallest + std::size_t{1}]; });
  std::partial_sum(end.begin(), end.end(), end.begin());
  std::vector<Face> sorted(end.back());
  // Before this, end[v] is where bucket v begins; after it, where it ends.
  for_each([&](Index smallest, const Face& face) { sorted[end[smallest]++] = face; });
  Layers layers;
  for (std::size_t v = 0, begin = 0; v < vertices; begin = end[v++]) {
    const std::span<Face> bucket(sorted.data() + begin, end[v] - begin);
    std::ranges::sort(bucket);
    for (std::size_t i = 1, first = 0; i < bucket.size(); ++i) {
      if (bucket[i].low != bucket[first].low || bucket[i].high != bucket[first].high) {
        first = i;
      } else if (bucket[i].surface == bucket[i - 1].surface) {
        ++layers.sides;
      } else {
        ++layers.others;
        layers.turned += bucket[i].turned != bucket[first].turned;
      }
    }
  }
  return layers;
}

void add_notes(const Layers& layers, MotionInfo& info) {
  for (std::string note : {note_on_seams(info.merged, layers.sides), note_on_layers(layers)}) {
    if (!note.empty()) info.notes.push_back(std::move(note));
  }
}

std::vector<Index> surfaces_by_name(std::span<const std::string> names) {
  std::vector<Index> surfaces;
  std::map<std::string, Index> known;
  for (const std::string& name : names)
    surfaces.push_back(known.try_emplace(without_side(name), static_cast<Index>(known.size())).first->second);
  return surfaces;
}

}  // namespace foldproof::io
