#include "check/culling.h"

#include <fmt/format.h>

#include <bit>
#include <map>
#include <utility>

namespace foldproof {
namespace {

// A pair of leaves that had no plane is not asked again for 3 steps, and then for 7. The memory is
// found by a hash of the pair: two pairs that share one only lose a chance.
constexpr std::uint8_t kMostFailures = 2;
// While few of the pairs that were asked for the first time had a plane, one in so many is.
constexpr Index kProbe = 8;

std::uint64_t hash_of(const TraversalTask& task, NodePair leaves) {
  std::uint64_t hash = (std::uint64_t{leaves.a} << 32 | leaves.b) * 0x9E3779B97F4A7C15u;
  hash = (hash ^ (std::uint64_t{task.object_a} << 16 | task.object_b)) * 0x9E3779B97F4A7C15u;
  return hash >> 20;
}

}  // namespace

Culling::Culling(std::span<const Object> objects) {
  std::map<const Hierarchy*, std::shared_ptr<const PatchSlots>> slots_of;  // one for all instances of a mesh
  for (const Object& object : objects) {
    auto& slots = slots_of[object.hierarchy().get()];
    if (object.charts()) {
      slots = object.charts()->slots();
    } else if (!slots) {
      slots = std::make_shared<const PatchSlots>(object.hierarchy());
    }
    books_.push_back(std::make_unique<ChartBook>(slots, object.charts()));
    predictors_.push_back(object.predictor());
    leaf_proofs_.emplace_back(object.hierarchy()->leaf_count());
  }
}

Result<void> Culling::predict(Positions x0, Positions x1, const StepSettings& settings) {
  if (!trusts_predictions_ || !settings.within) return {};
  predicted_free_.resize(predictors_.size());
  for (std::size_t i = 0; i < predictors_.size(); ++i) {
    if (!predictors_[i])
      return fail(fmt::format("object {}", i), "has nothing learned that predicts its certificates",
                  "train a model on at least 3 poses that differ, or leave the mode paper");
    predicted_free_[i].resize(books_[i]->slots().hierarchy()->nodes().size());
    predictors_[i]->predict(x0[i], x1[i], settings.miss_rate, predicted_free_[i]);
  }
  return {};
}

// The budget keeps drawing, about 0.1 us a triangle, well below what the pairs of leaves took that were
// tested in the step before, about 1 us each: up to five triangles for each where charts prove to be of use,
// a fraction of one where they do not.
std::size_t Culling::drawing_budget() {
  constexpr double kMost = 5, kLeast = 0.5;
  constexpr double kUsual = 3, kLittle = 256;  // what little meshes need costs little
  double drawn = 0, of_use = 0;
  for (const auto& book : books_) drawn += static_cast<double>(book->drawings());
  for (Local& local : locals_) of_use += static_cast<double>(std::exchange(local.tester.of_use, 0));
  drawn_ = drawn_ / 2 + drawn;
  of_use_ = of_use_ / 2 + of_use;
  const double share = std::clamp(6 * (of_use_ + 3) / (drawn_ + 9), kLeast, kMost);
  const double pairs =
      static_cast<double>(last_leaf_pairs_) / static_cast<double>(std::max<std::size_t>(1, books_.size()));
  return static_cast<std::size_t>(std::max(share * pairs, std::min(kUsual * pairs, kLittle)));
}

Result<void> Culling::begin(const StepMotion& motion, Positions x0, Positions x1,
                            const StepSettings& settings, double distance) {
  trusts_predictions_ = settings.mode == Mode::Paper;
  if (auto ok = predict(x0, x1, settings); !ok) return ok;
  certificates_ = settings.certificates;
  explains_ = settings.explain;
  gap_ = distance * motion.frame().scale * (1 + 0x1p-50);
  double asked = 0, found = 0;
  for (Local& local : locals_) {
    local.tests = local.passes = local.failed_planes = local.tester.tests = local.tester.triangles = 0;
    asked += static_cast<double>(std::exchange(local.new_planes, 0));
    found += static_cast<double>(std::exchange(local.new_planes_found, 0));
  }
  planes_.asked = planes_.asked / 2 + asked;
  planes_.found = planes_.found / 2 + found;
  planes_.pay = planes_.found > planes_.asked / 4;
  ask_for_planes_ = steps_++ > 0 && !trusts_predictions_;

  uses_certificates_ = certificates_ && !trusts_predictions_;
  measures_gain_ = uses_certificates_ && motion.ahead() == 1 && !explains_;
  if (measures_gain_)
    uses_certificates_ =
        gain_.begin(std::ranges::any_of(books_, [](const auto& book) { return book->is_trained(); }));
  uses_certificates_next_ = measures_gain_ && gain_.used_next();
  const std::size_t budget = drawing_budget();
  for (Index i = 0; i < books_.size(); ++i)
    books_[i]->begin_step(motion.trees()[i].vertices, uses_certificates_ ? budget : 0);
  if (plane_memory_.empty() && uses_certificates_)
    plane_memory_.resize(std::bit_ceil(std::max<std::size_t>(16, 4 * motion.leaf_count())));
  proven_nodes_.clear();
  return {};
}

// What can be said of the nodes of one level.
void Culling::prove_nodes(const StepMotion& motion, Index object) {
  level_proofs_.assign(level_.size(), {});
  if (trusts_predictions_) {
    for (std::size_t i = 0; i < level_.size(); ++i) {
      if (predicted_free_[object][level_[i]]) level_proofs_[i] = books_[object]->trained(level_[i]);
    }
  } else if (uses_certificates_) {
    parallel_for(IndexRange{0, level_.size()}, 8, [&](IndexRange range) {
      Local& local = locals_.local();
      for (std::size_t i = range.begin; i < range.end; ++i) {
        level_proofs_[i] =
            books_[object]->prove(level_[i], motion.trees()[object].vertices, gap_, local.tester);
        local.passes += static_cast<bool>(level_proofs_[i]);
      }
    });
  }
}

const Culling::SelfPairs& Culling::cull_self_pairs(const StepMotion& motion, Index object, Work& work) {
  ChartBook& book = *books_[object];
  const auto nodes = motion.hierarchy(object).nodes();
  auto& leaf_proofs = leaf_proofs_[object];
  for (LeafProofs& proofs : leaf_proofs) proofs.clear();
  selves_.proven.assign(nodes.size(), 0);
  selves_.unproven_leaves.clear();
  level_.assign(nodes.empty() ? 0 : 1, 0);
  for (Index depth = 0; !level_.empty(); ++depth) {
    work.node_tests += level_.size();
    prove_nodes(motion, object);
    level_below_.clear();
    for (std::size_t i = 0; i < level_.size(); ++i) {
      const Index self = level_[i];
      const Hierarchy::Node& node = nodes[self];
      if (const ChartBook::Proof& proof = level_proofs_[i]) {
        selves_.proven[self] = 1;
        if (explains_) proven_nodes_.push_back({object, self, depth, proof});
        for (Index leaf = node.leaf_begin; leaf < node.leaf_end; ++leaf) leaf_proofs[leaf].add(self);
        for (const Index leaf : proof.collar()) leaf_proofs[leaf].add(self);
        continue;
      }
      if (uses_certificates_ || uses_certificates_next_) book.want_node(self);
      if (node.is_leaf()) {
        selves_.unproven_leaves.push_back(node.leaf_begin);
      } else {
        level_below_.push_back(self + 1);
        level_below_.push_back(node.right);
      }
    }
    level_.swap(level_below_);
  }
  return selves_;
}

Culling::PlaneMemory& Culling::plane_memory(const TraversalTask& task, NodePair leaves) {
  return plane_memory_[hash_of(task, leaves) & (plane_memory_.size() - 1)];
}

bool Culling::may_have_plane(const TraversalTask& task, NodePair leaves, const PlaneMemory& memory) const {
  return ask_for_planes_ && (planes_.pay || memory.normal != PlaneNormal{} ||
                             ((hash_of(task, leaves) >> 24) + steps_) % kProbe == 0);
}

// Of two leaves that no proven patch has in common. `found`: where a plane proved it, its normal; where
// something else did, left alone.
bool Culling::is_proven(const TraversalTask& task, const NearLeaves& pair, Local& local, PlaneNormal& found) {
  const KineticTree &tree_a = *task.traversal.a, &tree_b = *task.traversal.b;
  if (pair.slot != kNoIndex)
    return static_cast<bool>(books_[task.object_a]->prove(pair.slot, tree_a.vertices, gap_, local.tester));
  const PlaneMemory& memory = plane_memory(task, pair.leaves);
  if (memory.cooldown != 0 || !may_have_plane(task, pair.leaves, memory)) return false;
  const bool known = memory.normal != PlaneNormal{};
  ++local.tests;
  local.new_planes += !known;
  found = memory.normal;
  const bool separates = plane_separates(tree_a.vertices, tree_a.leaf_vertices(pair.leaves.a),
                                         tree_b.vertices, tree_b.leaf_vertices(pair.leaves.b), gap_, &found);
  local.new_planes_found += !known && separates;
  local.failed_planes += !separates;
  return separates;
}

// The cheapest first: whether a proven patch has both leaves, then boxes, then charts and planes of their
// own.
void Culling::cull_leaves(const TraversalTask& task, std::span<const NearLeaves> near, bool just_found,
                          Culled& out) {
  const bool within = task.object_a == task.object_b;
  const auto& proofs = leaf_proofs_[task.object_a];
  Local& local = locals_.local();
  local.to_test.clear();
  for (const NearLeaves& pair : near) {
    if (within && proofs[pair.leaves.a].meets(proofs[pair.leaves.b])) {
      ++local.passes;
    } else {
      local.to_test.push_back(pair);
    }
  }
  local.apart.assign(local.to_test.size(), 0);
  if (!just_found) {
    local.leaves.clear();
    for (const NearLeaves& pair : local.to_test) local.leaves.push_back(pair.leaves);
    test_leaves(task.traversal, local.leaves, local.apart);
    out.node_tests += local.leaves.size();
  }
  for (std::size_t i = 0; i < local.to_test.size(); ++i) {
    if (local.apart[i]) continue;
    PlaneNormal plane{};
    if (!uses_certificates_ || !is_proven(task, local.to_test[i], local, plane)) {
      out.remaining.push_back(local.to_test[i].leaves);
      continue;
    }
    ++local.passes;
    if (plane != PlaneNormal{}) out.planes.push_back({local.to_test[i].leaves, plane});
  }
}

void Culling::remember(const TraversalTask& task, std::span<const Culled::Plane> planes) {
  for (const auto& [leaves, normal] : planes) plane_memory(task, leaves) = {normal};
}

void Culling::remember_remaining(const TraversalTask& task, NodePair leaves) {
  if (!uses_certificates_) return;
  if (task.object_a == task.object_b) {
    if (leaves.a == leaves.b) return;
    ChartBook& book = *books_[task.object_a];
    const Index slot = book.slots().of_leaves(leaves.a, leaves.b);
    if (slot != kNoIndex) return book.want_pair(slot);
  }
  PlaneMemory& memory = plane_memory(task, leaves);
  if (memory.cooldown > 0) {
    --memory.cooldown;
  } else if (may_have_plane(task, leaves, memory)) {
    memory.failures = std::min<std::uint8_t>(memory.failures + 1, kMostFailures);
    memory.cooldown = static_cast<std::uint8_t>((2u << memory.failures) - 1);
  }
}

void Culling::end(const StepMotion& motion, std::uint64_t node_tests, std::size_t leaf_pairs, Work& work) {
  last_leaf_pairs_ = leaf_pairs;
  CullingGain::Counts counts;
  counts.node_tests = node_tests;
  counts.leaf_pairs = leaf_pairs;
  counts.leaves = motion.leaf_count();
  for (const Local& local : locals_) {
    work.certificate_tests += local.tests + local.tester.tests;
    work.certificate_passes += local.passes;
    counts.chart_triangles += local.tester.triangles;
    counts.planes += local.tests;
    counts.failed_planes += local.failed_planes;
  }
  if (!measures_gain_) return;
  if (gain_.knows_nothing()) counts.sweep_growth = motion.sweep_growth();
  gain_.took(counts);
}

}  // namespace foldproof
