#include "certificate/patch_drawer.h"

namespace foldproof {

PatchDrawer::PatchDrawer(const PatchSlots& slots)
    : slots_(slots), reader_(slots), seen_(slots.hierarchy()->leaf_count(), 0) {}

void PatchDrawer::read_positions(std::span<const MovingVertex> vertices, const Patch& patch) {
  // Half way through the step: where a patch turns fast, both ends are then equally far.
  positions_.clear();
  for (const Index v : patch.vertices) {
    const float* x = vertices[v].x;
    positions_.push_back({(x[0] + x[4]) / 2, (x[1] + x[5]) / 2, (x[2] + x[6]) / 2});
  }
}

// Neighbours that face the same way, so that the seam between nodes is mostly covered from both sides.
void PatchDrawer::add_collar(std::span<const MovingVertex> vertices, const Eigen::Vector3f& facing,
                             DrawnPatch& out) {
  const Hierarchy& h = *slots_.hierarchy();
  const Hierarchy::Node& node = h.nodes()[out.slot];
  ++drawings_;
  const auto faces = [&](Index leaf) {
    for (Index t = h.leaves()[leaf].triangles; t < h.leaves()[leaf + 1].triangles; ++t) {
      Eigen::Vector3f corners[3];
      for (int k = 0; k < 3; ++k)
        corners[k] = Eigen::Map<const Eigen::Vector3f>(vertices[h.triangles()[t][k]].x);
      if (!ChartMaker::faces(facing, corners)) return false;
    }
    return true;
  };
  for (Index leaf = node.leaf_begin; leaf < node.leaf_end; ++leaf) {
    for (const Index other : slots_.neighbours(leaf)) {
      if ((node.leaf_begin <= other && other < node.leaf_end) || seen_[other] == drawings_) continue;
      seen_[other] = drawings_;
      if (!faces(other)) continue;
      out.collar.push_back(other);
      reader_.add_leaf(other, out.patch);
    }
  }
}

void PatchDrawer::draw(std::span<const MovingVertex> vertices, DrawnPatch& out) {
  out.collar.clear();
  reader_.read(out.slot, out.patch);
  read_positions(vertices, out.patch);
  const Eigen::Vector3f facing = maker_.facing(out.patch, positions_);
  out.outcome = ChartOutcome::TooCurved;
  if (facing.isZero()) return;
  if (!slots_.is_pair(out.slot)) {
    add_collar(vertices, facing, out);
    read_positions(vertices, out.patch);
  }
  out.outcome = maker_.draw(out.patch, positions_, facing, out.drawing);
  if (out.outcome == ChartOutcome::Made || out.collar.empty()) return;
  out.collar.clear();
  reader_.read(out.slot, out.patch);
  read_positions(vertices, out.patch);
  out.outcome = maker_.draw(out.patch, positions_, facing, out.drawing);
}

}  // namespace foldproof
