// Faces, lines and points as a topology, and what becomes of vertices in none of them.
#include <fmt/format.h>

#include <algorithm>

#include "base/try.h"
#include "io/readers.h"

namespace foldproof::io {
namespace {

Edge sorted(const Edge& e) { return {std::min(e[0], e[1]), std::max(e[0], e[1])}; }

// The numbers of the lines that are no side of a face, the first of each, ascending.
std::vector<std::size_t> lines_beside(std::span<const Triangle> faces, std::span<const Edge> lines) {
  using Numbered = std::pair<Edge, std::size_t>;
  // Only lines are sorted: they are few beside the sides of faces.
  std::vector<Numbered> different;
  different.reserve(lines.size());
  for (std::size_t i = 0; i < lines.size(); ++i) different.emplace_back(sorted(lines[i]), i);
  std::ranges::sort(different);
  const auto same = [](const Numbered& a, const Numbered& b) { return a.first == b.first; };
  different.erase(std::unique(different.begin(), different.end(), same), different.end());
  std::vector<bool> is_side(different.size());
  for (const Triangle& t : faces) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Edge side = sorted({t[k], t[(k + 1) % 3]});
      const auto at = std::ranges::lower_bound(different, side, {}, &Numbered::first);
      if (at != different.end() && at->first == side)
        is_side[static_cast<std::size_t>(at - different.begin())] = true;
    }
  }
  std::vector<std::size_t> kept;
  kept.reserve(different.size());
  for (std::size_t n = 0; n < different.size(); ++n) {
    if (!is_side[n]) kept.push_back(different[n].second);
  }
  std::ranges::sort(kept);
  return kept;
}

// The numbers of the points that are on no face and no line, the first of each.
std::vector<std::size_t> points_beside(std::vector<bool> used, std::span<const Edge> lines,
                                       std::span<const Index> points) {
  std::vector<std::size_t> kept;
  for (const Edge& line : lines) {
    for (const Index v : line) {
      if (v < used.size()) used[v] = true;
    }
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Index p = points[i];
    if (p >= used.size() || !used[p]) kept.push_back(i);
    if (p < used.size()) used[p] = true;
  }
  return kept;
}

class WithLooseVertices final : public Motion {
 public:
  WithLooseVertices(std::unique_ptr<Motion> motion, Topology topology, MotionInfo info)
      : motion_(std::move(motion)), topology_(std::move(topology)), info_(std::move(info)) {}

  const std::string& name() const override { return motion_->name(); }
  const Topology& topology() const override { return topology_; }
  const MotionInfo& info() const override { return info_; }
  Index frame_count() const override { return motion_->frame_count(); }
  Result<void> read_frame(Index k, std::span<double> out) override { return motion_->read_frame(k, out); }

 private:
  std::unique_ptr<Motion> motion_;
  Topology topology_;
  MotionInfo info_;
};

}  // namespace

std::vector<bool> named_vertices(Index vertex_count, std::span<const Triangle> triangles) {
  std::vector<bool> named(vertex_count);
  for (const Triangle& t : triangles) {
    for (const Index v : t) {
      if (v < vertex_count) named[v] = true;
    }
  }
  return named;
}

void add_parts(const Topology& topology, ObjectParts& parts) {
  if (parts.names.empty()) return;
  const auto add = [&](const char* name, Index count) {
    if (count == 0) return;
    const auto at = std::ranges::find(parts.names, name);
    const auto part = static_cast<Index>(at - parts.names.begin());
    if (at == parts.names.end()) parts.names.emplace_back(name);
    parts.of_triangle.insert(parts.of_triangle.end(), count, part);
  };
  if (parts.of_triangle.size() == topology.face_count()) add("lines", topology.line_count());
  if (parts.of_triangle.size() < topology.triangles().size())
    add("points", static_cast<Index>(topology.triangles().size() - parts.of_triangle.size()));
}

Result<Topology> make_topology(Index vertex_count, std::vector<Triangle> faces, std::span<const Edge> lines,
                               std::span<const Index> points, ObjectParts& parts) {
  const std::size_t face_count = faces.size();
  std::vector<Edge> other_lines;
  std::vector<Index> other_points, part_of;
  const bool all_have_parts = parts.of_triangle.size() == face_count + lines.size() + points.size();
  const auto keep_part = [&](std::size_t triangle) {
    if (all_have_parts) part_of.push_back(parts.of_triangle[triangle]);
  };
  if (!lines.empty()) {
    for (const std::size_t i : lines_beside(faces, lines)) {
      other_lines.push_back(lines[i]);
      keep_part(face_count + i);
    }
  }
  if (!points.empty()) {
    for (const std::size_t i : points_beside(named_vertices(vertex_count, faces), other_lines, points)) {
      other_points.push_back(points[i]);
      keep_part(face_count + lines.size() + i);
    }
  }
  if (all_have_parts) {
    parts.of_triangle.resize(face_count);
    parts.of_triangle.insert(parts.of_triangle.end(), part_of.begin(), part_of.end());
  }
  auto topology = FOLDPROOF_TRY(Topology::make(vertex_count, std::move(faces), other_lines, other_points));
  add_parts(topology, parts);
  return topology;
}

std::vector<Index> loose_vertices(const Topology& topology, std::span<const Index> merged) {
  const std::vector<bool> named = named_vertices(topology.vertex_count(), topology.triangles());
  std::vector<Index> loose;
  for (Index v = 0; v < named.size(); ++v) {
    if (!named[v] && (merged.empty() || merged[v] == v)) loose.push_back(v);
  }
  return loose;
}

std::string unchecked_vertices(const Topology& topology, std::size_t count) {
  return fmt::format("{} {} in no face{} {} not checked", count, count == 1 ? "vertex" : "vertices",
                     topology.line_count() > 0 ? " and no line" : "", count == 1 ? "was" : "were");
}

Result<std::unique_ptr<Motion>> with_loose_vertices(std::unique_ptr<Motion> motion, bool as_points) {
  MotionInfo info = motion->info();
  Topology topology = motion->topology();
  const auto loose = loose_vertices(topology, info.merged);
  if (loose.empty()) return motion;
  if (as_points) {
    std::vector<Index> points = topology.points();
    points.insert(points.end(), loose.begin(), loose.end());
    const auto faces = topology.faces();
    topology = FOLDPROOF_TRY(
        Topology::make(topology.vertex_count(), {faces.begin(), faces.end()}, topology.lines(), points));
    add_parts(topology, info.parts);
  } else {
    info.unchecked.push_back(unchecked_vertices(topology, loose.size()));
  }
  return std::make_unique<WithLooseVertices>(std::move(motion), std::move(topology), std::move(info));
}

}  // namespace foldproof::io
