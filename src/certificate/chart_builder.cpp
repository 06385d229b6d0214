#include "certificate/chart_builder.h"

namespace foldproof::internal {

ChartBuilder::ChartBuilder(const PatchSlots& slots)
    : slots_(slots), reader_(slots), last_build_(slots.hierarchy()->leaf_count(), 0) {}

void ChartBuilder::read_positions(std::span<const MovingVertex> vertices, const Patch& patch) {
  // Halfway through the step, so that a patch that turns fast is equally far from the chart at both ends.
  positions_.clear();
  for (const Index v : patch.vertices) {
    const float* x = vertices[v].x;
    positions_.push_back({(x[0] + x[4]) / 2, (x[1] + x[5]) / 2, (x[2] + x[6]) / 2});
  }
}

// The ring: neighbors that face the same way. The charts of two neighboring nodes then overlap, and most
// pairs of leaves across their boundary are proven. Around a vertex with many triangles all leaves are
// neighbors: with so many there is no ring, or each of the charts would have all triangles.
void ChartBuilder::add_ring(std::span<const MovingVertex> vertices, const Vec3& facing, BuiltChart& out) {
  const Hierarchy& h = *slots_.hierarchy();
  const Hierarchy::Node& node = h.nodes()[out.slot];
  ++build_number_;
  Index left = 16 + 4 * (node.leaf_end - node.leaf_begin);
  const auto faces = [&](Index leaf) {
    for (Index t = h.leaves()[leaf].triangles; t < h.leaves()[leaf + 1].triangles; ++t) {
      std::array<std::array<float, 3>, 3> corners;
      for (int k = 0; k < 3; ++k) {
        const float* x = vertices[h.triangles()[t][k]].x;
        corners[k] = {x[0], x[1], x[2]};
      }
      if (!Parametrizer::faces(facing, corners)) return false;
    }
    return true;
  };
  for (Index leaf = node.leaf_begin; leaf < node.leaf_end; ++leaf) {
    for (const Index other : slots_.neighbors(leaf)) {
      const bool own = node.leaf_begin <= other && other < node.leaf_end;
      if (own || last_build_[other] == build_number_) continue;
      last_build_[other] = build_number_;
      if (left-- == 0) {
        out.ring.clear();
        reader_.read(out.slot, out.patch);
        return;
      }
      if (!faces(other)) continue;
      out.ring.push_back(other);
      reader_.add_leaf(other, out.patch);
    }
  }
}

void ChartBuilder::build(std::span<const MovingVertex> vertices, BuiltChart& out) {
  out.ring.clear();
  reader_.read(out.slot, out.patch);
  read_positions(vertices, out.patch);
  const Vec3 facing = parametrizer_.facing(out.patch, positions_);
  out.outcome = ChartOutcome::TooCurved;
  if (facing == Vec3::Zero()) return;
  if (!slots_.is_pair(out.slot)) {
    add_ring(vertices, facing, out);
    read_positions(vertices, out.patch);
  }
  out.outcome = parametrizer_.build(out.patch, positions_, facing, out.uv_map);
  if (out.outcome == ChartOutcome::Made || out.ring.empty()) return;
  out.ring.clear();
  reader_.read(out.slot, out.patch);
  read_positions(vertices, out.patch);
  out.outcome = parametrizer_.build(out.patch, positions_, facing, out.uv_map);
}

}  // namespace foldproof::internal
