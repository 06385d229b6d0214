// Which pairs of leaves certificates prove apart.

#include <bit>

#include "base/parallel.h"
#include "query/scene.h"

namespace foldproof {
namespace {

// A pair of leaves that had no plane is not asked again for 3 steps, and then for 7. The memory is
// found by a hash of the pair: two pairs that share one only lose a chance.
constexpr std::uint8_t kMostVain = 2;
// While few of the pairs that were asked for the first time had a plane, one in so many is.
constexpr Index kProbe = 8;

}  // namespace

void Scene::prove_selves(Index object, double gap) {
  parallel_for(IndexRange{0, selves_.size()}, 8, [&](IndexRange range) {
    Local& local = locals_.local();
    for (std::size_t i = range.begin; i < range.end; ++i) {
      self_proofs_[i] = books_[object]->prove(selves_[i], trees_[object].vertices, gap, local.tester);
      local.passes += static_cast<bool>(self_proofs_[i]);
    }
  });
}

void Scene::believe_selves(Index object) {
  for (std::size_t i = 0; i < selves_.size(); ++i) {
    if (beliefs_[object]->holds(selves_[i])) self_proofs_[i] = books_[object]->trained(selves_[i]);
  }
}

std::uint64_t Scene::hash_of(const LeafPairRef& pair) const {
  const TraversalTask& task = tasks_[pair.task];
  std::uint64_t hash = (std::uint64_t{pair.leaves.a} << 32 | pair.leaves.b) * 0x9E3779B97F4A7C15u;
  hash = (hash ^ (std::uint64_t{task.object_a} << 16 | task.object_b)) * 0x9E3779B97F4A7C15u;
  return hash >> 20;
}

Scene::PlaneMemory& Scene::plane_memory(const LeafPairRef& pair) {
  return plane_memory_[hash_of(pair) & (plane_memory_.size() - 1)];
}

bool Scene::may_have_plane(const LeafPairRef& pair, const PlaneMemory& memory) const {
  return ask_for_planes_ &&
         (planes_.pay || memory.normal != PlaneNormal{} || ((hash_of(pair) >> 24) + steps_) % kProbe == 0);
}

// Of two leaves that no proven patch has in common. `found`: where a plane proved it, its normal; where
// something else did, left alone.
bool Scene::proves(const LeafPairRef& pair, Index slot, double gap, Local& local, PlaneNormal& found) {
  const TraversalTask& task = tasks_[pair.task];
  if (believes_) return false;
  if (slot != kNoIndex) {
    const std::span<const MovingVertex> vertices = trees_[task.object_a].vertices;
    return static_cast<bool>(books_[task.object_a]->prove(slot, vertices, gap, local.tester));
  }
  const PlaneMemory& memory = plane_memory(pair);
  if (memory.rest != 0 || !may_have_plane(pair, memory)) return false;
  const bool known = memory.normal != PlaneNormal{};
  ++local.tests;
  local.new_planes += !known;
  found = memory.normal;
  const KineticTree &tree_a = *task.traversal.a, &tree_b = *task.traversal.b;
  const bool separates = plane_separates(tree_a.vertices, tree_a.leaf_vertices(pair.leaves.a),
                                         tree_b.vertices, tree_b.leaf_vertices(pair.leaves.b), gap, &found);
  local.new_planes_found += !known && separates;
  return separates;
}

// What a pair that was not proven leaves for the steps to come.
void Scene::note_unproven(const LeafPairRef& pair) {
  const TraversalTask& task = tasks_[pair.task];
  const auto [a, b] = pair.leaves;
  if (task.object_a == task.object_b) {
    if (a == b) return;
    const Index slot = books_[task.object_a]->slots().of_leaves(a, b);
    if (slot != kNoIndex) return books_[task.object_a]->want_pair(slot);
  }
  PlaneMemory& memory = plane_memory(pair);
  if (memory.rest > 0) {
    --memory.rest;
  } else if (may_have_plane(pair, memory)) {
    memory.vain = std::min<std::uint8_t>(memory.vain + 1, kMostVain);
    memory.rest = static_cast<std::uint8_t>((2u << memory.vain) - 1);
  }
}

void Scene::make_plane_memory() {
  if (plane_memory_.empty()) plane_memory_.resize(std::bit_ceil(std::max<std::size_t>(16, 4 * leaf_count_)));
}

void Scene::ask(Index task, NodePair leaves, Index slot, double gap, Local& local) {
  TraversalShare& share = shares_[task];
  PlaneNormal plane{};
  if (!proves({task, leaves}, slot, gap, local, plane)) {
    share.unproven.push_back(leaves);
    return;
  }
  ++local.passes;
  if (plane != PlaneNormal{}) share.planes.push_back({leaves, plane});
}

// The cheapest first: whether a proven patch has both leaves, then boxes, unless the traversal has just found
// these not to be apart, then charts and planes of their own.
void Scene::ask_near_leaves(Index task, std::span<const NearLeaves> near, bool just_found, double gap,
                            Local& local) {
  const bool within = tasks_[task].object_a == tasks_[task].object_b;
  const auto& proofs = leaf_proofs_[tasks_[task].object_a];
  local.asked.clear();
  local.slots.clear();
  for (const auto& [leaves, slot] : near) {
    if (within && proofs[leaves.a].meets(proofs[leaves.b])) {
      ++local.passes;
    } else {
      local.asked.push_back(leaves);
      local.slots.push_back(slot);
    }
  }
  if (just_found) {
    local.apart.assign(local.asked.size(), 0);
  } else {
    test_leaves(tasks_[task].traversal, local.asked, local.apart);
    shares_[task].found.node_tests += local.asked.size();
  }
  for (std::size_t i = 0; i < local.asked.size(); ++i) {
    if (!local.apart[i]) ask(task, local.asked[i], local.slots[i], gap, local);
  }
}

void Scene::remember_proofs() {
  for (Index task = 0; task < tasks_.size(); ++task) {
    for (const auto& [leaves, normal] : shares_[task].planes) plane_memory({task, leaves}) = {normal};
  }
  if (believes_) return;
  for (const LeafPairRef& pair : leaf_pairs_) note_unproven(pair);
}

}  // namespace foldproof
