#include "model/trainer.h"

#include <tbb/parallel_for.h>

namespace foldproof {

Trainer::Trainer(std::shared_ptr<const PatchSlots> slots, const TrainSettings& settings)
    : slots_(std::move(slots)),
      settings_(settings),
      charts_(std::make_shared<ChartLibrary>(slots_)),
      tree_(slots_->hierarchy()),
      locals_(slots_) {
  for (Index leaf = 0; leaf < slots_->hierarchy()->leaf_count(); ++leaf) {
    hard_.push_back({leaf, 0, Obstacle::TooCurved});
  }
}

std::vector<HardLeaf> Trainer::hard_leaves() const {
  std::vector<HardLeaf> hard;
  for (const HardLeaf& leaf : hard_) {
    if (leaf.references > 0) hard.push_back(leaf);
  }
  return hard;
}

void Trainer::learn(Index pose, std::span<const double> positions) {
  pose_ = pose;
  enter(positions);
}

float Trainer::prove(std::span<const double> positions) {
  pose_ = kNoIndex;
  enter(positions);
  const Hierarchy& h = *slots_->hierarchy();
  const std::size_t pairs = (slots_->count() - h.nodes().size()) / 2;
  return static_cast<float>(static_cast<double>(proven_) / static_cast<double>(h.leaf_count() + pairs));
}

void Trainer::enter(std::span<const double> positions) {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (std::size_t i = 0; i < positions.size(); i += 3) {
    const Eigen::Map<const Vec3> x(&positions[i]);
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  tree_.refit(frame_around(low, high), positions, positions);
  proven_ = 0;
  cover_nodes();
  cover_pairs();
}

bool Trainer::holds(const ChartLibrary& library, Index first, Local& local, Finding& out) const {
  for (Index c = first; c != kNoIndex; c = library.charts()[c].next) {
    const ChartLibrary::Chart& chart = library.charts()[c];
    const ChartView view{library.vertices(chart), library.points(chart), library.triangles(chart), chart.fit};
    if (!chart_holds(view, tree_.vertices, 0, local.scratch)) continue;
    out.collar = library.collar(chart);
    return true;
  }
  return false;
}

void Trainer::look_at(Index slot, Finding& out) {
  Local& local = locals_.local();
  out.is_new = false;
  out.holds = holds(*charts_, charts_->first(slot), local, out);
  if (out.holds || pose_ == kNoIndex || slots_->triangles_of(slot) > settings_.most_triangles) return;
  out.drawn.slot = slot;
  local.drawer.draw(tree_.vertices, out.drawn);
  if (out.drawn.outcome != ChartOutcome::Made) {
    out.obstacle = out.drawn.outcome == ChartOutcome::Tangled ? Obstacle::Tangled : Obstacle::TooCurved;
    return;
  }
  // A drawing that proves nothing in the pose it was made in is of no use.
  if (local.trial.charts().empty()) {
    local.trial.add(slot, pose_, out.drawn.patch, out.drawn.collar, out.drawn.drawing);
  } else {
    local.trial.replace(0, pose_, out.drawn.patch, out.drawn.collar, out.drawn.drawing);
  }
  out.holds = out.is_new = holds(local.trial, 0, local, out);
  out.collar = out.drawn.collar;
  out.obstacle = Obstacle::TooThin;
}

// Fills findings_. What is found depends on the slots' order only, never on the threads.
void Trainer::look_at(std::span<const Index> slots) {
  if (findings_.size() < slots.size()) findings_.resize(slots.size());
  tbb::parallel_for(std::size_t{0}, slots.size(), [&](std::size_t i) { look_at(slots[i], findings_[i]); });
}

void Trainer::keep(const Finding& finding) {
  if (!finding.is_new) return;
  charts_->add(finding.drawn.slot, pose_, finding.drawn.patch, finding.drawn.collar, finding.drawn.drawing);
}

// Marks every pair of leaves that lies in a proven patch.
void Trainer::cover(Index node, std::span<const Index> collar) {
  const Hierarchy::Node& n = slots_->hierarchy()->nodes()[node];
  proven_ += n.leaf_end - n.leaf_begin;
  const auto for_each_leaf = [&](auto visit) {
    for (Index leaf = n.leaf_begin; leaf < n.leaf_end; ++leaf) visit(leaf);
    for (const Index leaf : collar) visit(leaf);
  };
  for_each_leaf([&](Index leaf) { patch_of_[leaf] = node; });
  for_each_leaf([&](Index leaf) {
    for (const Index other : slots_->neighbours(leaf)) {
      if (leaf < other && patch_of_[other] == node) covered_[slots_->of_leaves(leaf, other)] = 1;
    }
  });
}

// From the root down to nodes that are proven, a level at a time.
void Trainer::cover_nodes() {
  const auto nodes = slots_->hierarchy()->nodes();
  covered_.assign(slots_->count(), 0);
  patch_of_.assign(slots_->hierarchy()->leaf_count(), kNoIndex);
  for (level_.assign(1, 0); !level_.empty(); level_.swap(below_)) {
    look_at(level_);
    below_.clear();
    for (std::size_t i = 0; i < level_.size(); ++i) {
      const Index node = level_[i];
      if (findings_[i].holds) {
        cover(node, findings_[i].collar);
      } else if (!nodes[node].is_leaf()) {
        below_.insert(below_.end(), {node + 1, nodes[node].right});
      } else if (pose_ != kNoIndex) {
        HardLeaf& hard = hard_[nodes[node].leaf_begin];
        ++hard.references;
        hard.obstacle = findings_[i].obstacle;
      }
    }
    for (std::size_t i = 0; i < level_.size(); ++i) keep(findings_[i]);
  }
}

// Then the seams that no node's patch covers.
void Trainer::cover_pairs() {
  level_.clear();
  for (Index leaf = 0; leaf < patch_of_.size(); ++leaf) {
    for (const Index other : slots_->neighbours(leaf)) {
      if (leaf > other) continue;
      const Index slot = slots_->of_leaves(leaf, other);
      proven_ += covered_[slot];
      if (!covered_[slot]) level_.push_back(slot);
    }
  }
  look_at(level_);
  for (std::size_t i = 0; i < level_.size(); ++i) {
    proven_ += findings_[i].holds;
    keep(findings_[i]);
  }
}

}  // namespace foldproof
