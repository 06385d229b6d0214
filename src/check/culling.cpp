#include "check/culling.h"

#include <fmt/format.h>

#include <bit>
#include <map>
#include <utility>

#include "base/try.h"

namespace foldproof::internal {
namespace {

// After a plane fails, its pair of leaves backs off for 3 steps, then for 7.
constexpr std::uint8_t kMaxFailures = 2;
// While planes rarely separate pairs without a cached one, one in kProbe of such pairs is tested.
constexpr Index kProbe = 8;

std::uint64_t hash_of(const TraversalTask& task, LeafPair leaves) {
  std::uint64_t hash = (std::uint64_t{leaves.a} << 32 | leaves.b) * 0x9E3779B97F4A7C15u;
  hash = (hash ^ (std::uint64_t{task.object_a} << 16 | task.object_b)) * 0x9E3779B97F4A7C15u;
  return hash >> 20;
}

}  // namespace

Culling::Culling(std::span<const Object> objects) {
  std::map<const Hierarchy*, std::shared_ptr<const PatchSlots>> slots_of;  // one for all instances of a mesh
  std::map<const Hierarchy*, std::shared_ptr<const Hubs>> hubs_of;
  for (const Object& object : objects) {
    auto& hubs = hubs_of[object.hierarchy().get()];
    if (!hubs) hubs = std::make_shared<const Hubs>(*object.hierarchy());
    hubs_.push_back(hubs);
    auto& slots = slots_of[object.hierarchy().get()];
    if (object.charts()) {
      slots = object.charts()->slots();
    } else if (!slots) {
      slots = std::make_shared<const PatchSlots>(object.hierarchy());
    }
    charts_.push_back(std::make_unique<ChartCache>(slots, object.charts()));
    objects_.emplace_back();
    objects_.back().proven.resize(object.hierarchy()->nodes().size());
    objects_.back().leaves.resize(object.hierarchy()->leaf_count());
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
    local.hub_planes.tests = local.hub_planes.passes = 0;
    tests += static_cast<double>(std::exchange(local.new_planes, 0));
    passes += static_cast<double>(std::exchange(local.new_planes_passed, 0));
  }
  new_planes_.tests = new_planes_.tests / 2 + tests;
  new_planes_.passes = new_planes_.passes / 2 + passes;
  new_planes_.pay = new_planes_.passes > new_planes_.tests / 4;
  tests_planes_ = steps_++ > 0 && declared_free_ == nullptr;

  uses_certificates_ = certificates_ && declared_free_ == nullptr;
  updates_policy_ = uses_certificates_ && motion.steps() == 1 && !explains_;
  // Charts that are built in a pose hold in it, so they pay at once.
  const bool is_first_pose = updates_policy_ && steps_ == 1 && motion.swept_extent_ratio() == 1;
  if (updates_policy_)
    uses_certificates_ =
        policy_.begin_step(is_first_pose || std::ranges::any_of(charts_, [](const auto& charts) {
                             return charts->is_trained();
                           }));
  uses_certificates_next_ = updates_policy_ && policy_.uses_next();
  const std::size_t budget = build_budget();
  for (Index i = 0; i < charts_.size(); ++i) {
    if (is_first_pose && !charts_[i]->is_trained()) {
      charts_[i]->begin_pose(motion.bvhs()[i].vertices);
    } else {
      charts_[i]->begin_step(motion.bvhs()[i].vertices, uses_certificates_ ? budget : 0);
    }
  }
  proven_nodes_.clear();
  return {};
}

// Threads may do different nodes at once.
ChartCache::Proof Culling::prove(const StepMotion& motion, Index object, NodeIndex node, Local& local) {
  const SlotIndex slot(charts_[object]->slots().of_node(node));
  if (declared_free_ != nullptr)
    return (*declared_free_)[object][node] ? charts_[object]->trained(slot) : ChartCache::Proof{};
  if (!uses_certificates_) return {};
  const auto proof = charts_[object]->prove(slot, motion.bvhs()[object].vertices, gap_, local.tester);
  local.passes += static_cast<bool>(proof);
  return proof;
}

// Notes a node that was tested. Returns whether it is proven.
bool Culling::add_node(Index object, NodeIndex node, ChartCache::Proof proof, SubtreeProofs& out) {
  ++out.node_tests;
  objects_[object].proven[node] = static_cast<bool>(proof);
  if (proof) {
    if (explains_) out.proven.push_back({object, node, proof});
    for (const Index leaf : proof.ring()) out.rings.push_back({LeafIndex(leaf), node});
    return true;
  }
  if ((uses_certificates_ || uses_certificates_next_) && charts_[object]->wants_node(node))
    out.requests.push_back(node);
  return false;
}

// The nodes above the subtrees, level by level.
void Culling::prove_top(const StepMotion& motion, const Filter& filter, Index object) {
  const auto nodes = motion.hierarchy(object).nodes();
  const Subtrees& subtrees = motion.subtrees(object);
  ObjectProofs& proofs = objects_[object];
  proofs.subtrees.resize(subtrees.roots.size());
  for (SubtreeProofs& subtree : proofs.subtrees) subtree.is_covered = false;
  proofs.top.clear();
  level_.clear();
  if (!subtrees.top.empty()) level_.emplace_back();
  const auto cover = [&](NodeIndex node, Index patch) {
    const Index last = subtrees.first_from(end_below(nodes, node));
    for (Index k = subtrees.first_from(node); k < last; ++k) {
      proofs.subtrees[k].is_covered = true;
      proofs.subtrees[k].patch = patch;
    }
  };
  while (!level_.empty()) {
    std::erase_if(level_, [&](NodeIndex node) {
      if (filter.nodes(object, node, object, node)) return false;
      proofs.proven[node] = 1;
      cover(node, kNoIndex);
      return true;
    });
    level_proofs_.resize(level_.size());
    parallel_for(std::size_t{0}, level_.size(), [&](std::size_t i) {
      level_proofs_[i] = prove(motion, object, level_[i], locals_.local());
    });
    next_level_.clear();
    for (std::size_t i = 0; i < level_.size(); ++i) {
      const NodeIndex node = level_[i];
      if (add_node(object, node, level_proofs_[i], proofs.top)) {
        cover(node, node);
        continue;
      }
      const auto [left, right] = children_of(nodes, node);
      for (const NodeIndex child : {left, right}) {
        if (leaf_count(nodes[child]) > subtrees.max_leaves) next_level_.push_back(child);
      }
    }
    swap_buffers(level_, next_level_);
  }
}

// A parent comes before everything below it.
void Culling::prove_subtree(const StepMotion& motion, const Filter& filter, Index object, Index subtree) {
  const auto nodes = motion.hierarchy(object).nodes();
  ObjectProofs& proofs = objects_[object];
  SubtreeProofs& out = proofs.subtrees[subtree];
  Local& local = locals_.local();
  out.clear();
  const NodeIndex root = motion.subtrees(object).roots[subtree];
  for (Index leaf = nodes[root].leaf_begin; leaf < nodes[root].leaf_end; ++leaf) {
    proofs.leaves[leaf].clear();
    if (out.is_covered && out.patch != kNoIndex) proofs.leaves[leaf].add(out.patch);
  }
  if (out.is_covered) return;
  const NodeIndex end = end_below(nodes, root);
  for (NodeIndex node = root; node < end;) {
    const Hierarchy::Node& n = nodes[node];
    const bool ignored = !filter.nodes(object, node, object, node);
    if (ignored) proofs.proven[node] = 1;
    if (ignored || add_node(object, node, prove(motion, object, node, local), out)) {
      for (Index leaf = n.leaf_begin; !ignored && leaf < n.leaf_end; ++leaf) proofs.leaves[leaf].add(node);
      node = end_below(nodes, node);
      continue;
    }
    if (n.is_leaf()) out.unproven_leaves.emplace_back(n.leaf_begin);
    node = NodeIndex(node + 1);
  }
}

// In an order that depends on the hierarchy alone: leaves keep a limited number of patches.
void Culling::gather(Index object, Work& work) {
  ObjectProofs& proofs = objects_[object];
  const auto add = [&](const SubtreeProofs& part) {
    for (const auto& [leaf, patch] : part.rings) proofs.leaves[leaf].add(patch);
    charts_[object]->request_nodes(part.requests);
    proven_nodes_.insert(proven_nodes_.end(), part.proven.begin(), part.proven.end());
    work.node_tests += part.node_tests;
  };
  add(proofs.top);
  for (const SubtreeProofs& subtree : proofs.subtrees) add(subtree);
}

void Culling::prove_nodes(const StepMotion& motion, const Filter& filter, Work& work) {
  all_subtrees_.clear();
  for (Index object = 0; object < motion.size(); ++object) {
    prove_top(motion, filter, object);
    for (Index k = 0; k < objects_[object].subtrees.size(); ++k) all_subtrees_.push_back({object, k});
  }
  parallel_for(std::size_t{0}, all_subtrees_.size(), [&](std::size_t i) {
    prove_subtree(motion, filter, all_subtrees_[i][0], all_subtrees_[i][1]);
  });
  for (Index object = 0; object < motion.size(); ++object) gather(object, work);
}

bool Culling::should_test_plane(std::uint64_t hash, const CachedPlane& cached) const {
  return tests_planes_ &&
         (new_planes_.pay || cached.normal != PlaneNormal{} || ((hash >> 24) + steps_) % kProbe == 0);
}

bool Culling::plane_separates_leaves(const TraversalTask& task, LeafPair leaves, CachedPlane& cached,
                                     Local& local) {
  const KineticBvh &a = *task.traversal.a, &b = *task.traversal.b;
  const bool is_new = cached.normal == PlaneNormal{};
  ++local.tests;
  local.new_planes += is_new;
  PlaneNormal normal = cached.normal;
  if (plane_separates(a.vertices, a.leaf_vertices(leaves.a), b.vertices, b.leaf_vertices(leaves.b), gap_,
                      &normal)) {
    local.new_planes_passed += is_new;
    cached = {normal};
    return true;
  }
  ++local.failed_planes;
  cached.failures = std::min<std::uint8_t>(cached.failures + 1, kMaxFailures);
  cached.back_off = static_cast<std::uint8_t>((2u << cached.failures) - 1);
  return false;
}

NodeCertificate* Culling::hub_planes(const TraversalTask& task) {
  const Hubs& hubs = *hubs_[task.object_a];
  if (task.object_a != task.object_b || hubs.empty() || !certificates_ || declared_free_ != nullptr)
    return nullptr;
  HubPlanes& planes = locals_.local().hub_planes;
  planes.begin(hubs, task.traversal.a->vertices, gap_);
  return &planes;
}

// The cheapest test first: common proven patches, then boxes, then charts and planes of the pair's own.
void Culling::cull_leaves(const TraversalTask& task, std::span<const NearLeafPair> near, bool boxes_overlap,
                          Tile& tile) {
  const bool within = task.object_a == task.object_b;
  const auto& proofs = objects_[task.object_a].leaves;
  ChartCache& charts = *charts_[task.object_a];
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
    test_leaf_boxes(task.traversal, local.leaves, local.separated);
    tile.node_tests += local.leaves.size();
  }
  for (const NearLeafPair& pair : local.unproven) tile.plane_pairs += pair.slot == kNoIndex;
  if (uses_certificates_) tile.planes.reserve(tile.plane_pairs);
  for (std::size_t i = 0; i < local.unproven.size(); ++i) {
    if (local.separated[i]) continue;
    const auto& [leaves, slot] = local.unproven[i];
    bool is_proven = false;
    if (uses_certificates_ && slot != kNoIndex) {
      is_proven = static_cast<bool>(charts.prove(slot, task.traversal.a->vertices, gap_, local.tester));
      if (!is_proven && charts.wants_pair(slot)) tile.requests.push_back(slot);
    } else if (uses_certificates_) {
      const std::uint64_t hash = hash_of(task, leaves);
      CachedPlane& cached = tile.planes.at(hash);
      if (cached.back_off > 0) {
        --cached.back_off;
      } else if (should_test_plane(hash, cached)) {
        is_proven = plane_separates_leaves(task, leaves, cached, local);
      }
    }
    local.passes += is_proven;
    if (!is_proven) tile.remaining.push_back(leaves);
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
    work.certificate_tests += local.tests + local.tester.tests + local.hub_planes.tests;
    work.certificate_passes += local.passes + local.hub_planes.passes;
    counts.chart_triangles += local.tester.triangles;
    counts.planes += local.tests;
    counts.failed_planes += local.failed_planes;
  }
  if (!updates_policy_) return;
  if (policy_.is_unmeasured()) counts.swept_extent_ratio = motion.swept_extent_ratio();
  policy_.end_step(counts);
}

}  // namespace foldproof::internal
