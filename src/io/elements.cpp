// Faces, lines and points as a topology, and what becomes of vertices in none of them.
#include <fmt/format.h>

#include <algorithm>

#include "base/try.h"
#include "io/readers.h"

namespace foldproof::io {
namespace {

Edge sorted(const Edge& e) { return {std::min(e[0], e[1]), std::max(e[0], e[1])}; }

std::vector<bool> vertices_of(Index vertex_count, std::span<const Triangle> triangles) {
  std::vector<bool> used(vertex_count, false);
  for (const Triangle& t : triangles) {
    for (const Index v : t) {
      if (v < vertex_count) used[v] = true;
    }
  }
  return used;
}

// The numbers of the lines that are no side of a face, the first of each, ascending.
std::vector<std::size_t> lines_beside(std::span<const Triangle> faces, std::span<const Edge> lines) {
  std::vector<Edge> known;
  for (const Triangle& t : faces) {
    for (std::size_t k = 0; k < 3; ++k) known.push_back(sorted({t[k], t[(k + 1) % 3]}));
  }
  std::sort(known.begin(), known.end());
  std::vector<std::pair<Edge, std::size_t>> fresh;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (!std::binary_search(known.begin(), known.end(), sorted(lines[i])))
      fresh.emplace_back(sorted(lines[i]), i);
  }
  std::sort(fresh.begin(), fresh.end());
  const auto same = [](const auto& a, const auto& b) { return a.first == b.first; };
  fresh.erase(std::unique(fresh.begin(), fresh.end(), same), fresh.end());
  std::vector<std::size_t> kept;
  kept.reserve(fresh.size());
  for (const auto& [edge, i] : fresh) kept.push_back(i);
  std::sort(kept.begin(), kept.end());
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
    for (const std::size_t i : points_beside(vertices_of(vertex_count, faces), other_lines, points)) {
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
  const std::vector<bool> used = vertices_of(topology.vertex_count(), topology.triangles());
  std::vector<Index> loose;
  for (Index v = 0; v < used.size(); ++v) {
    if (!used[v] && (merged.empty() || merged[v] == v)) loose.push_back(v);
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
