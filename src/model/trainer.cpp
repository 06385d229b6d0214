#include "model/trainer.h"

#include "base/parallel.h"

namespace foldproof::internal {
namespace {

// Bytes of the file that charts may take, per triangle and reference. Spare charts are built while they fit.
// The rest of the file takes about 20.
constexpr std::int64_t kBytesPerTriangle = 100;
constexpr std::size_t kBytesPerChart = 20;

// Slots processed at once. Memory holds a chart of each.
constexpr std::size_t kPoseBatch = 1024;

}  // namespace

Trainer::Trainer(std::shared_ptr<const PatchSlots> slots, const TrainSettings& settings)
    : slots_(std::move(slots)),
      settings_(settings),
      charts_(std::make_shared<ChartLibrary>(slots_)),
      bvh_(slots_->hierarchy()),
      locals_([this] { return Local(slots_); }) {
  for (Index leaf = 0; leaf < slots_->hierarchy()->leaf_count(); ++leaf) {
    hard_leaves_.push_back({leaf, 0, Obstacle::TooCurved});
  }
}

std::vector<HardLeaf> Trainer::hard_leaves() const {
  std::vector<HardLeaf> hard;
  for (const HardLeaf& leaf : hard_leaves_) {
    if (leaf.references > 0) hard.push_back(leaf);
  }
  return hard;
}

void Trainer::learn(Index pose, std::span<const double> positions) {
  pose_ = pose;
  budget_ += kBytesPerTriangle * static_cast<std::int64_t>(slots_->hierarchy()->triangles().size());
  prove_pose(positions);
  build_spares();
}

float Trainer::prove(std::span<const double> positions) {
  pose_ = kNoIndex;
  prove_pose(positions);
  const Hierarchy& h = *slots_->hierarchy();
  const std::size_t pairs = (slots_->count() - h.nodes().size()) / 2;
  return static_cast<float>(static_cast<double>(proven_) / static_cast<double>(h.leaf_count() + pairs));
}

void Trainer::prove_pose(std::span<const double> positions) {
  bvh_.refit(frame_around(positions), positions, positions);
  proven_ = 0;
  prove_nodes();
  prove_pairs();
}

Index Trainer::first_that_holds(const ChartLibrary& library, Index first, ChartScratch& scratch) const {
  for (Index c = first; c != kNoIndex; c = library.charts()[c].next) {
    const ChartView view = view_of(library, library.charts()[c]);
    if (chart_holds(view, bvh_.vertices, 0, scratch)) return c;
  }
  return kNoIndex;
}

void Trainer::process(Index slot, SlotResult& out) {
  Local& local = locals_.local();
  out.built_holds = false;
  out.known_chart = first_that_holds(*charts_, charts_->first(slot), local.scratch);
  if (out.is_proven() || pose_ == kNoIndex || slots_->triangle_count(slot) > settings_.max_triangles) return;
  BuiltChart& built = out.built;
  built.slot = slot;
  local.builder.build(bvh_.vertices, built);
  if (built.outcome != ChartOutcome::Made) {
    out.obstacle = built.outcome == ChartOutcome::Overlapping ? Obstacle::Overlapping : Obstacle::TooCurved;
    return;
  }
  // A chart that does not hold in its own pose is useless.
  if (local.trial.charts().empty()) {
    local.trial.add(slot, pose_, built.patch, built.ring, built.uv_map);
  } else {
    local.trial.replace(0, pose_, built.patch, built.ring, built.uv_map);
  }
  out.built_holds = first_that_holds(local.trial, 0, local.scratch) != kNoIndex;
  out.obstacle = Obstacle::TooThin;
}

// Visits the results in the order of the slots, so that the charts do not depend on the number of threads.
template <class Visit>
void Trainer::process(std::span<const Index> slots, Visit visit) {
  results_.resize(kPoseBatch);
  for (std::size_t first = 0; first < slots.size(); first += kPoseBatch) {
    const auto batch = slots.subspan(first, std::min(kPoseBatch, slots.size() - first));
    parallel_for(std::size_t{0}, batch.size(), [&](std::size_t i) { process(batch[i], results_[i]); });
    for (std::size_t i = 0; i < batch.size(); ++i) visit(batch[i], results_[i]);
  }
}

void Trainer::keep(const SlotResult& result, bool spare) {
  if (!result.built_holds) return;
  const auto& [slot, patch, ring, uv_map, outcome] = result.built;
  const std::size_t bytes =
      kBytesPerChart + 4 * ring.size() + 6 * (uv_map.uvs.size() + uv_map.scaffold.size());
  if (spare && budget_ < static_cast<std::int64_t>(bytes)) return;
  budget_ -= static_cast<std::int64_t>(bytes);
  charts_->add(slot, pose_, patch, ring, uv_map);
}

// Marks every pair of neighboring leaves in a proven patch.
void Trainer::mark_proven(Index node, std::span<const Index> ring) {
  const Hierarchy::Node& n = slots_->hierarchy()->nodes()[node];
  proven_ += n.leaf_end - n.leaf_begin;
  const auto for_each_leaf = [&](auto visit) {
    for (Index leaf = n.leaf_begin; leaf < n.leaf_end; ++leaf) visit(leaf);
    for (const Index leaf : ring) visit(leaf);
  };
  for_each_leaf([&](Index leaf) { last_patch_[leaf] = node; });
  for_each_leaf([&](Index leaf) {
    for (const Index other : slots_->neighbors(leaf)) {
      if (leaf < other && last_patch_[other] == node) covered_[slots_->of_leaves(leaf, other)] = 1;
    }
  });
}

// Descends from the root to proven nodes, level by level.
void Trainer::prove_nodes() {
  const auto nodes = slots_->hierarchy()->nodes();
  covered_.assign(slots_->count(), 0);
  last_patch_.assign(slots_->hierarchy()->leaf_count(), kNoIndex);
  proven_nodes_.clear();
  for (level_.assign(1, 0); !level_.empty(); level_.swap(next_level_)) {
    next_level_.clear();
    process(level_, [&](Index node, const SlotResult& result) {
      if (result.is_proven()) {
        mark_proven(node, result.built_holds ? result.built.ring
                                             : charts_->ring(charts_->charts()[result.known_chart]));
        proven_nodes_.push_back(node);
      } else if (!nodes[node].is_leaf()) {
        next_level_.insert(next_level_.end(), {node + 1, nodes[node].right});
      } else if (pose_ != kNoIndex) {
        HardLeaf& hard = hard_leaves_[nodes[node].leaf_begin];
        ++hard.references;
        hard.obstacle = result.obstacle;
      }
      keep(result, false);
    });
  }
}

// Processes the pairs of neighboring leaves that no proven node's patch contains.
void Trainer::prove_pairs() {
  level_.clear();
  for (Index leaf = 0; leaf < last_patch_.size(); ++leaf) {
    for (const Index other : slots_->neighbors(leaf)) {
      if (leaf > other) continue;
      const Index slot = slots_->of_leaves(leaf, other);
      proven_ += covered_[slot];
      if (!covered_[slot]) level_.push_back(slot);
    }
  }
  process(level_, [&](Index, const SlotResult& result) {
    proven_ += result.is_proven();
    keep(result, false);
  });
}

// Where the chart of a large patch fails in a later pose, charts of smaller patches inside it may hold. So
// this also builds charts of the nodes below proven ones, then of the pairs of leaves that their patches
// contain.
void Trainer::build_spares() {
  const auto nodes = slots_->hierarchy()->nodes();
  for (level_.swap(proven_nodes_); !level_.empty() && budget_ > 0; level_.swap(next_level_)) {
    next_level_.clear();
    for (const Index node : level_) {
      if (!nodes[node].is_leaf()) next_level_.insert(next_level_.end(), {node + 1, nodes[node].right});
    }
    process(next_level_, [&](Index, const SlotResult& result) { keep(result, true); });
  }
  level_.clear();
  for (Index slot = static_cast<Index>(nodes.size()); slot < covered_.size(); ++slot) {
    if (covered_[slot]) level_.push_back(slot);
  }
  if (budget_ > 0) process(level_, [&](Index, const SlotResult& result) { keep(result, true); });
}

}  // namespace foldproof::internal
