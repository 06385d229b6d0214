#include "check/culling.h"

#include <fmt/format.h>

#include <bit>
#include <map>
#include <utility>

#include "base/try.h"

namespace foldproof::internal {
namespace {

// After a plane fails, its pair of leaves backs off for 3 steps, then for 7. Cached planes are indexed by a
// hash of the pair; a collision costs time only.
constexpr std::uint8_t kMaxFailures = 2;
// While planes rarely separate pairs without a cached one, one in kProbe of such pairs is tested.
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
    charts_.push_back(std::make_unique<ChartCache>(slots, object.charts()));
    leaf_proofs_.emplace_back(object.hierarchy()->leaf_count());
  }
}

Result<void> Culling::check_declared(const StepMotion& motion) const {
  if (declared_free_ == nullptr) return {};
  for (Index i = 0; i < motion.size(); ++i) {
    const std::size_t nodes = motion.hierarchy(i).nodes().size();
    if (i < declared_free_->size() && (*declared_free_)[i].size() == nodes) continue;
    return fail(ErrorCode::InvalidArgument, fmt::format("declared_free, object {}", i),
                "does not have a number for each node", fmt::format("give {}", nodes));
  }
  return {};
}

// In triangles. Building takes about 0.1 us per triangle; testing a pair of leaves, about 1 us. So building
// costs less than the pairs that were tested in the last step: up to five triangles per pair where charts are
// useful, a fraction of one where they are not.
std::size_t Culling::build_budget() {
  constexpr double kMaxShare = 5, kMinShare = 0.5;
  constexpr double kSmallMeshShare = 3, kSmallMeshBudget = 256;  // costs little in any case
  double built = 0, useful = 0;
  for (const auto& charts : charts_) built += static_cast<double>(charts->charts_built());
  for (Local& local : locals_) useful += static_cast<double>(std::exchange(local.tester.first_proofs, 0));
  built_ = built_ / 2 + built;
  useful_ = useful_ / 2 + useful;
  const double share = std::clamp(6 * (useful_ + 3) / (built_ + 9), kMinShare, kMaxShare);
  const double pairs =
      static_cast<double>(last_leaf_pairs_) / static_cast<double>(std::max<std::size_t>(1, charts_.size()));
  return static_cast<std::size_t>(
      std::max(share * pairs, std::min(kSmallMeshShare * pairs, kSmallMeshBudget)));
}

Result<void> Culling::begin_step(const StepMotion& motion, const StepSettings& settings, double distance) {
  declared_free_ = settings.declared_free;
  if (settings.within) FOLDPROOF_TRY(check_declared(motion));
  certificates_ = settings.certificates;
  explains_ = settings.explain;
  gap_ = distance * motion.frame().scale * (1 + 0x1p-50);
  double tests = 0, passes = 0;
  for (Local& local : locals_) {
    local.tests = local.passes = local.failed_planes = local.tester.tests = local.tester.triangles = 0;
    tests += static_cast<double>(std::exchange(local.new_planes, 0));
    passes += static_cast<double>(std::exchange(local.new_planes_passed, 0));
  }
  new_planes_.tests = new_planes_.tests / 2 + tests;
  new_planes_.passes = new_planes_.passes / 2 + passes;
  new_planes_.pay = new_planes_.passes > new_planes_.tests / 4;
  tests_planes_ = steps_++ > 0 && declared_free_ == nullptr;

  uses_certificates_ = certificates_ && declared_free_ == nullptr;
  updates_policy_ = uses_certificates_ && motion.steps() == 1 && !explains_;
  if (updates_policy_)
    uses_certificates_ = policy_.begin_step(
        std::ranges::any_of(charts_, [](const auto& charts) { return charts->is_trained(); }));
  uses_certificates_next_ = updates_policy_ && policy_.uses_next();
  const std::size_t budget = build_budget();
  for (Index i = 0; i < charts_.size(); ++i)
    charts_[i]->begin_step(motion.bvhs()[i].vertices, uses_certificates_ ? budget : 0);
  if (plane_cache_.empty() && uses_certificates_)
    plane_cache_.resize(std::bit_ceil(std::max<std::size_t>(16, 4 * motion.leaf_count())));
  proven_nodes_.clear();
  return {};
}

// Sets level_proofs_ for the nodes of a level.
void Culling::prove_nodes(const StepMotion& motion, Index object) {
  level_proofs_.assign(level_.size(), {});
  if (declared_free_ != nullptr) {
    for (std::size_t i = 0; i < level_.size(); ++i) {
      if ((*declared_free_)[object][level_[i]]) level_proofs_[i] = charts_[object]->trained(level_[i]);
    }
  } else if (uses_certificates_) {
    parallel_for(IndexRange{0, level_.size()}, 8, [&](IndexRange range) {
      Local& local = locals_.local();
      for (std::size_t i = range.begin; i < range.end; ++i) {
        level_proofs_[i] =
            charts_[object]->prove(level_[i], motion.bvhs()[object].vertices, gap_, local.tester);
        local.passes += static_cast<bool>(level_proofs_[i]);
      }
    });
  }
}

const Culling::SelfPairs& Culling::cull_self_pairs(const StepMotion& motion, Index object,
                                                   const Filter& filter, Work& work) {
  ChartCache& charts = *charts_[object];
  const auto nodes = motion.hierarchy(object).nodes();
  auto& leaf_proofs = leaf_proofs_[object];
  for (LeafProofs& proofs : leaf_proofs) proofs.clear();
  self_pairs_.proven.assign(nodes.size(), 0);
  self_pairs_.unproven_leaves.clear();
  level_.assign(nodes.empty() ? 0 : 1, 0);
  for (Index depth = 0; !level_.empty(); ++depth) {
    if (filter.asks_nodes()) {
      std::erase_if(level_, [&](Index self) {
        self_pairs_.proven[self] = !filter.nodes(object, self, object, self);
        return self_pairs_.proven[self] != 0;
      });
    }
    work.node_tests += level_.size();
    prove_nodes(motion, object);
    next_level_.clear();
    for (std::size_t i = 0; i < level_.size(); ++i) {
      const Index self = level_[i];
      const Hierarchy::Node& node = nodes[self];
      if (const ChartCache::Proof& proof = level_proofs_[i]) {
        self_pairs_.proven[self] = 1;
        if (explains_) proven_nodes_.push_back({object, self, depth, proof});
        for (Index leaf = node.leaf_begin; leaf < node.leaf_end; ++leaf) leaf_proofs[leaf].add(self);
        for (const Index leaf : proof.ring()) leaf_proofs[leaf].add(self);
        continue;
      }
      if (uses_certificates_ || uses_certificates_next_) charts.request_node(self);
      if (node.is_leaf()) {
        self_pairs_.unproven_leaves.push_back(node.leaf_begin);
      } else {
        next_level_.push_back(self + 1);
        next_level_.push_back(node.right);
      }
    }
    swap_levels(level_, next_level_);
  }
  return self_pairs_;
}

Culling::CachedPlane& Culling::cached_plane(const TraversalTask& task, NodePair leaves) {
  return plane_cache_[hash_of(task, leaves) & (plane_cache_.size() - 1)];
}

bool Culling::should_test_plane(const TraversalTask& task, NodePair leaves, const CachedPlane& cached) const {
  return tests_planes_ && (new_planes_.pay || cached.normal != PlaneNormal{} ||
                           ((hash_of(task, leaves) >> 24) + steps_) % kProbe == 0);
}

// Whether a chart or a plane of their own separates two leaves without a common proven patch. Sets `normal`
// only when a plane is tested.
bool Culling::is_proven(const TraversalTask& task, const NearLeafPair& pair, Local& local,
                        PlaneNormal& normal) {
  const KineticBvh &a = *task.traversal.a, &b = *task.traversal.b;
  if (pair.slot != kNoIndex)
    return static_cast<bool>(charts_[task.object_a]->prove(pair.slot, a.vertices, gap_, local.tester));
  const CachedPlane& cached = cached_plane(task, pair.leaves);
  if (cached.back_off != 0 || !should_test_plane(task, pair.leaves, cached)) return false;
  const bool is_new = cached.normal == PlaneNormal{};
  ++local.tests;
  local.new_planes += is_new;
  normal = cached.normal;
  const bool separates = plane_separates(a.vertices, a.leaf_vertices(pair.leaves.a), b.vertices,
                                         b.leaf_vertices(pair.leaves.b), gap_, &normal);
  local.new_planes_passed += is_new && separates;
  local.failed_planes += !separates;
  return separates;
}

// The cheapest test first: common proven patches, then boxes, then charts and planes of the pair's own.
void Culling::cull_leaves(const TraversalTask& task, std::span<const NearLeafPair> near, bool boxes_overlap,
                          Culled& out) {
  const bool within = task.object_a == task.object_b;
  const auto& proofs = leaf_proofs_[task.object_a];
  Local& local = locals_.local();
  local.unproven.clear();
  for (const NearLeafPair& pair : near) {
    if (within && proofs[pair.leaves.a].has_common_patch(proofs[pair.leaves.b])) {
      ++local.passes;
    } else {
      local.unproven.push_back(pair);
    }
  }
  local.separated.assign(local.unproven.size(), 0);
  if (!boxes_overlap) {
    local.leaves.clear();
    for (const NearLeafPair& pair : local.unproven) local.leaves.push_back(pair.leaves);
    test_leaves(task.traversal, local.leaves, local.separated);
    out.node_tests += local.leaves.size();
  }
  for (std::size_t i = 0; i < local.unproven.size(); ++i) {
    if (local.separated[i]) continue;
    PlaneNormal plane{};
    if (!uses_certificates_ || !is_proven(task, local.unproven[i], local, plane)) {
      out.remaining.push_back(local.unproven[i].leaves);
      continue;
    }
    ++local.passes;
    if (plane != PlaneNormal{}) out.planes.push_back({local.unproven[i].leaves, plane});
  }
}

void Culling::cache_planes(const TraversalTask& task, std::span<const Culled::Plane> planes) {
  for (const auto& [leaves, normal] : planes) cached_plane(task, leaves) = {normal};
}

void Culling::note_remaining(const TraversalTask& task, NodePair leaves) {
  if (!uses_certificates_) return;
  if (task.object_a == task.object_b) {
    if (leaves.a == leaves.b) return;
    ChartCache& charts = *charts_[task.object_a];
    const Index slot = charts.slots().of_leaves(leaves.a, leaves.b);
    if (slot != kNoIndex) return charts.request_pair(slot);
  }
  CachedPlane& cached = cached_plane(task, leaves);
  if (cached.back_off > 0) {
    --cached.back_off;
  } else if (should_test_plane(task, leaves, cached)) {
    cached.failures = std::min<std::uint8_t>(cached.failures + 1, kMaxFailures);
    cached.back_off = static_cast<std::uint8_t>((2u << cached.failures) - 1);
  }
}

void Culling::end_step(const StepMotion& motion, std::uint64_t node_tests, std::size_t leaf_pairs,
                       Work& work) {
  last_leaf_pairs_ = leaf_pairs;
  CullingPolicy::Counts counts;
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
  if (!updates_policy_) return;
  if (policy_.is_unmeasured()) counts.swept_extent_ratio = motion.swept_extent_ratio();
  policy_.end_step(counts);
}

}  // namespace foldproof::internal
