#include "model/trainer.h"
#include "base/parallel.h"

namespace foldproof {
namespace {

// What charts take in a file, in bytes per triangle and reference: spare ones are drawn while they fit. It
// leaves 20 for everything else.
constexpr std::int64_t kBytesPerTriangle = 100;
constexpr std::size_t kBytesPerChart = 20;

// Slots that are looked at together; memory holds a drawing for each.
constexpr std::size_t kBatch = 1024;

}  // namespace

Trainer::Trainer(std::shared_ptr<const PatchSlots> slots, const TrainSettings& settings)
    : slots_(std::move(slots)),
      settings_(settings),
      charts_(std::make_shared<ChartLibrary>(slots_)),
      tree_(slots_->hierarchy()),
      locals_([this] { return Local(slots_); }) {
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
  budget_ += kBytesPerTriangle * static_cast<std::int64_t>(slots_->hierarchy()->triangles().size());
  enter(positions);
  draw_spares();
}

float Trainer::prove(std::span<const double> positions) {
  pose_ = kNoIndex;
  enter(positions);
  const Hierarchy& h = *slots_->hierarchy();
  const std::size_t pairs = (slots_->count() - h.nodes().size()) / 2;
  return static_cast<float>(static_cast<double>(proven_) / static_cast<double>(h.leaf_count() + pairs));
}

void Trainer::enter(std::span<const double> positions) {
  tree_.refit(frame_around(positions), positions, positions);
  proven_ = 0;
  cover_nodes();
  cover_pairs();
}

Index Trainer::first_that_holds(const ChartLibrary& library, Index first, ChartScratch& scratch) const {
  for (Index c = first; c != kNoIndex; c = library.charts()[c].next) {
    const ChartView view = view_of(library, library.charts()[c]);
    if (chart_holds(view, tree_.vertices, 0, scratch)) return c;
  }
  return kNoIndex;
}

void Trainer::look_at(Index slot, Finding& out) {
  Local& local = locals_.local();
  out.drawn_holds = false;
  out.held = first_that_holds(*charts_, charts_->first(slot), local.scratch);
  if (out.holds() || pose_ == kNoIndex || slots_->triangles_of(slot) > settings_.most_triangles) return;
  DrawnPatch& drawn = out.drawn;
  drawn.slot = slot;
  local.drawer.draw(tree_.vertices, drawn);
  if (drawn.outcome != ChartOutcome::Made) {
    out.obstacle = drawn.outcome == ChartOutcome::Tangled ? Obstacle::Tangled : Obstacle::TooCurved;
    return;
  }
  // A drawing that proves nothing in the pose it was made in is of no use.
  if (local.trial.charts().empty()) {
    local.trial.add(slot, pose_, drawn.patch, drawn.collar, drawn.drawing);
  } else {
    local.trial.replace(0, pose_, drawn.patch, drawn.collar, drawn.drawing);
  }
  out.drawn_holds = first_that_holds(local.trial, 0, local.scratch) != kNoIndex;
  out.obstacle = Obstacle::TooThin;
}

// Visits slots and findings in order: what is found never depends on the threads.
template <class Visit>
void Trainer::look_at(std::span<const Index> slots, Visit visit) {
  findings_.resize(kBatch);
  for (std::size_t first = 0; first < slots.size(); first += kBatch) {
    const auto batch = slots.subspan(first, std::min(kBatch, slots.size() - first));
    parallel_for(std::size_t{0}, batch.size(), [&](std::size_t i) { look_at(batch[i], findings_[i]); });
    for (std::size_t i = 0; i < batch.size(); ++i) visit(batch[i], findings_[i]);
  }
}

void Trainer::keep(const Finding& finding, bool spare) {
  if (!finding.drawn_holds) return;
  const auto& [slot, patch, collar, drawing, outcome] = finding.drawn;
  const std::size_t bytes =
      kBytesPerChart + 4 * collar.size() + 6 * (drawing.places.size() + drawing.fillers.size());
  if (spare && budget_ < static_cast<std::int64_t>(bytes)) return;
  budget_ -= static_cast<std::int64_t>(bytes);
  charts_->add(slot, pose_, patch, collar, drawing);
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
  tops_.clear();
  for (level_.assign(1, 0); !level_.empty(); level_.swap(below_)) {
    below_.clear();
    look_at(level_, [&](Index node, const Finding& found) {
      if (found.holds()) {
        cover(node, found.drawn_holds ? found.drawn.collar : charts_->collar(charts_->charts()[found.held]));
        tops_.push_back(node);
      } else if (!nodes[node].is_leaf()) {
        below_.insert(below_.end(), {node + 1, nodes[node].right});
      } else if (pose_ != kNoIndex) {
        HardLeaf& hard = hard_[nodes[node].leaf_begin];
        ++hard.references;
        hard.obstacle = found.obstacle;
      }
      keep(found, false);
    });
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
  look_at(level_, [&](Index, const Finding& found) {
    proven_ += found.holds();
    keep(found, false);
  });
}

// Smaller patches prove more: where a large one fails in a pose to come, those inside it may not. So what
// lies below the proven nodes is drawn as well, and then the pairs of leaves that their patches cover.
void Trainer::draw_spares() {
  const auto nodes = slots_->hierarchy()->nodes();
  for (level_.swap(tops_); !level_.empty() && budget_ > 0; level_.swap(below_)) {
    below_.clear();
    for (const Index node : level_) {
      if (!nodes[node].is_leaf()) below_.insert(below_.end(), {node + 1, nodes[node].right});
    }
    look_at(below_, [&](Index, const Finding& found) { keep(found, true); });
  }
  level_.clear();
  for (Index slot = static_cast<Index>(nodes.size()); slot < covered_.size(); ++slot) {
    if (covered_[slot]) level_.push_back(slot);
  }
  if (budget_ > 0) look_at(level_, [&](Index, const Finding& found) { keep(found, true); });
}

}  // namespace foldproof
