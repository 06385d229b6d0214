#include <fmt/format.h>

#include <charconv>

#include "report/joined.h"

namespace foldproof {
namespace {

/// A path with at most one "%d" or "%04d" in it.
struct Pattern {
  std::string before, after;
  bool numbered = false;
  int width = 0;

  std::string name(std::uint64_t number) const {
    return numbered ? fmt::format("{}{:0{}}{}", before, number, width, after) : before;
  }
};

Result<Pattern> parse_pattern(const std::string& path) {
  const std::size_t percent = path.find('%');
  if (percent == std::string::npos) return Pattern{.before = path, .after = {}};
  const std::size_t d = path.find_first_not_of("0123456789", percent + 1);
  int width = 0;
  const bool has_width = d != std::string::npos && d > percent + 1;
  if (has_width) std::from_chars(path.data() + percent + 1, path.data() + d, width);
  if (d == std::string::npos || path[d] != 'd' || width > 20 || (has_width && path[percent + 1] != '0') ||
      path.find('%', d) != std::string::npos) {
    return fail("--ply", fmt::format("'{}' has a '%' that is not one %d or %04d", path),
                "use one %d or %04d where the frame number goes, or no '%'");
  }
  return Pattern{
      .before = path.substr(0, percent), .after = path.substr(d + 1), .numbered = true, .width = width};
}

class PlyReport : public ReportWriter {
 public:
  PlyReport(Pattern pattern, Joined joined, Index substeps)
      : pattern_(std::move(pattern)), joined_(std::move(joined)), substeps_(substeps) {}

  Result<void> step(const CheckedStep& step) override {
    const std::uint64_t collisions = step.collisions.sum();
    if (pattern_.numbered) {
      if (collisions == 0) return {};
      keep(step);
      return write(std::uint64_t{step.place.frame} * substeps_ + step.place.substep);
    }
    if (positions_.empty() || collisions > most_collisions_) {
      keep(step);
      most_collisions_ = collisions;
    }
    return {};
  }

  Result<void> finish(const CheckTotals&) override { return pattern_.numbered ? Result<void>{} : write(0); }

 private:
  void keep(const CheckedStep& step) {
    joined_.pose(step, step.collisions.sum() > 0 ? step.earliest_toi : 0, positions_);
    marks_.assign(joined_.topology.triangles().size(), 0);
    if (step.pose) {
      for (const TriangleCrossing& c : step.pose->crossings) {
        mark_face(c.object_a, c.triangle_a);
        mark_face(c.object_b, c.triangle_b);
      }
    } else {
      mark_features(*step.step);
    }
  }

  void mark_face(Index object, Index face) { marks_[joined_.first_face[object] + face] = 1; }

  /// Marks the faces of a step's collisions, and those around its vertices and edges.
  void mark_features(const StepResult& result) {
    vertex_hit_.assign(joined_.topology.vertex_count(), 0);
    edge_hit_.assign(joined_.topology.edges().size(), 0);
    for (const VertexFaceCollision& c : result.vertex_face) {
      mark_face(c.face_object, c.face);
      vertex_hit_[joined_.first_vertex[c.vertex_object] + c.vertex] = 1;
    }
    for (const EdgeEdgeCollision& c : result.edge_edge) {
      mark_edge(c.object_a, c.a);
      mark_edge(c.object_b, c.b);
    }
    const auto triangles = joined_.topology.triangles();
    const auto triangle_edges = joined_.topology.triangle_edges();
    for (std::size_t face = 0; face < triangles.size(); ++face) {
      for (int k = 0; k < 3; ++k) {
        const Index edge = triangle_edges[face][k];
        if (vertex_hit_[triangles[face][k]] || (edge != kNoIndex && edge_hit_[edge])) marks_[face] = 1;
      }
    }
  }

  void mark_edge(Index object, Edge edge) {
    const auto offset = static_cast<Index>(joined_.first_vertex[object]);
    const auto edges = joined_.topology.edges();
    const auto found = std::lower_bound(edges.begin(), edges.end(), Edge{edge[0] + offset, edge[1] + offset});
    edge_hit_[static_cast<std::size_t>(found - edges.begin())] = 1;
  }

  Result<void> write(std::uint64_t number) const {
    return write_ply(pattern_.name(number), joined_.topology, positions_, marks_);
  }

  Pattern pattern_;
  Joined joined_;
  Index substeps_;
  std::uint64_t most_collisions_ = 0;
  std::vector<double> positions_;
  std::vector<std::uint8_t> marks_, vertex_hit_, edge_hit_;
};

}  // namespace

Result<std::unique_ptr<ReportWriter>> ply_report(const std::string& path, Motions motions,
                                                 const CheckSettings& settings) {
  auto pattern = parse_pattern(path);
  if (!pattern) return tl::unexpected(pattern.error());
  // The mesh is written at the end of a check that may be long: see now that it can be.
  if (const auto probe = FileWriter::open(pattern->name(0)); !probe) return tl::unexpected(probe.error());
  auto joined = join(motions, "--ply");
  if (!joined) return tl::unexpected(joined.error());
  return std::make_unique<PlyReport>(std::move(*pattern), std::move(*joined), settings.substeps);
}

}  // namespace foldproof
