// Merges vertices that have exactly the same position.
#include <fmt/format.h>

#include <algorithm>

#include "base/try.h"
#include "io/readers.h"
#include "io/seams.h"

namespace foldproof::io {
namespace {

class WeldedMotion final : public Motion {
 public:
  /// `by`, which says what vertices are one, and `remedy`, where they part, are for errors.
  WeldedMotion(std::unique_ptr<Motion> motion, Topology topology, MotionInfo info, const char* by,
               const char* remedy)
      : motion_(std::move(motion)),
        topology_(std::move(topology)),
        info_(std::move(info)),
        by_(by),
        remedy_(remedy) {}

  const std::string& name() const override { return motion_->name(); }
  const Topology& topology() const override { return topology_; }
  const MotionInfo& info() const override { return info_; }
  Index frame_count() const override { return motion_->frame_count(); }

  Result<void> read_frame(Index k, std::span<double> out) override {
    FOLDPROOF_TRY(motion_->read_frame(k, out));
    for (Index v = 0; v < info_.merged.size(); ++v) {
      const Index kept = info_.merged[v];
      const double* x = &out[std::size_t{3} * v];
      if (kept == v || std::equal(x, x + 3, &out[std::size_t{3} * kept])) continue;
      return fail(ErrorCode::InvalidMesh, name(),
                  fmt::format("vertices {} and {}, which {} merged, part in frame {}", kept, v, by_, k),
                  remedy_);
    }
    return {};
  }

 private:
  std::unique_ptr<Motion> motion_;
  Topology topology_;
  MotionInfo info_;
  const char *by_, *remedy_;
};

MeshElements elements_of(const Topology& topology, const ObjectParts& parts) {
  const auto faces = topology.faces();
  MeshElements elements{{faces.begin(), faces.end()}, topology.lines(), topology.points(), {}};
  if (parts.of_triangle.size() == topology.triangles().size()) elements.values = parts.of_triangle;
  return elements;
}

/// The surface of each face, by the names of parts.
std::vector<Index> surfaces_of(const ObjectParts& parts, std::size_t faces) {
  if (parts.of_triangle.size() < faces) return {};
  std::vector<Index> surfaces = surfaces_by_name(parts.names), of_face(faces);
  for (std::size_t i = 0; i < faces; ++i) of_face[i] = surfaces[parts.of_triangle[i]];
  return of_face;
}

}  // namespace

std::vector<Index> first_at_same_place(std::span<const double> positions) {
  AlikeVertices alike(static_cast<Index>(positions.size() / 3));
  alike.compare<3>([&](Index v) {
    const double* x = &positions[std::size_t{3} * v];
    return std::array{AlikeVertices::key(x[0]), AlikeVertices::key(x[1]), AlikeVertices::key(x[2])};
  });
  return alike.first();
}

Result<std::unique_ptr<Motion>> weld(std::unique_ptr<Motion> motion) {
  const Topology& topology = motion->topology();
  std::vector<double> positions(std::size_t{3} * topology.vertex_count());
  FOLDPROOF_TRY(motion->read_frame(0, positions));
  return merge(std::move(motion), first_at_same_place(positions), "--weld", "check without --weld");
}

Result<std::unique_ptr<Motion>> merge(std::unique_ptr<Motion> motion, std::vector<Index> merged,
                                      const char* by, const char* remedy) {
  const Topology& topology = motion->topology();
  MotionInfo info = motion->info();
  info.merged = std::move(merged);
  info.layered = true;
  MeshElements elements = elements_of(topology, info.parts);
  elements.merge(info.merged);
  if (!elements.values.empty()) info.parts.of_triangle = elements.values;
  const Layers layers =
      count_layers(elements.faces, topology.vertex_count(), surfaces_of(info.parts, elements.faces.size()));
  add_notes(layers, info);
  auto welded = FOLDPROOF_TRY(make_topology(topology.vertex_count(), std::move(elements.faces),
                                            elements.lines, elements.points, info.parts));
  return std::make_unique<WeldedMotion>(std::move(motion), std::move(welded), std::move(info), by, remedy);
}

}  // namespace foldproof::io
