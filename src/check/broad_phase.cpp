#include "check/broad_phase.h"

#include <atomic>

namespace foldproof::internal {
namespace {

// A front only gets finer, so it is made anew after this many steps.
constexpr std::size_t kFrontLifetime = 16;
// Tiles of earlier steps are kept, unless they are many more than those of this one and older than fronts.
constexpr std::size_t kMaxTilesPerTile = 4, kMaxTiles = 1024;

// Counts the pairs of leaves around a hub, whose boxes all overlap, without a visit to each.
class HubPairs final : public NodeCertificate {
 public:
  HubPairs(const Hubs& hubs, std::span<const Hierarchy::Node> nodes) : hubs_(hubs), nodes_(nodes) {}
  bool separates(NodePair pair) override {
    if (!hubs_.have_common_hub(pair)) return false;
    leaf_pairs += std::uint64_t{leaf_count(nodes_[pair.a])} * leaf_count(nodes_[pair.b]);
    return true;
  }
  std::uint64_t leaf_pairs = 0;

 private:
  const Hubs& hubs_;
  std::span<const Hierarchy::Node> nodes_;
};

}  // namespace

// Pairs of objects whose roots' boxes are near each other.
std::span<const SweepAndPrune::Pair> BroadPhase::near_objects(const StepMotion& motion, float margin) {
  object_boxes_.clear();
  for (const KineticBvh& bvh : motion.bvhs()) {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    SweptBox& box = object_boxes_.emplace_back();
    box.low.fill(kInfinity);
    box.high.fill(-kInfinity);
    if (bvh.boxes.empty()) continue;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto& x = bvh.boxes[0].x;
      box.low[axis] = std::min(x[0][0][axis], x[1][0][axis]);
      box.high[axis] = -std::min(x[0][1][axis], x[1][1][axis]);
    }
  }
  return sweep_.pairs(object_boxes_, margin);
}

// The subtrees of an object that are not proven, and near pairs of subtrees, proven or not, unless a proven
// node is above both.
void BroadPhase::list_within(const Step& step, Index object) {
  const auto nodes = step.motion.hierarchy(object).nodes();
  const Subtrees& subtrees = step.motion.subtrees(object);
  const auto proven = step.culling.proven(object);
  for (Index k = 0; k < subtrees.roots.size(); ++k) {
    if (!step.culling.is_covered(object, k) && !proven[subtrees.roots[k]])
      keys_.push_back({object, object, subtrees.roots[k], subtrees.roots[k]});
  }
  NodeIndex next;  // past everything below the last proven node
  for (const NodeIndex node : subtrees.top) {
    if (node < next) continue;
    if (proven[node]) {
      next = end_below(nodes, node);
    } else {
      list_pairs(step, object, object, children_of(nodes, node));
    }
  }
}

// The pairs of subtrees below two nodes that are near each other.
void BroadPhase::list_pairs(const Step& step, Index a, Index b, NodePair start) {
  const TaskFilter visited(step.filter, a, b);
  near_.filter = step.filter.asks_nodes() ? &visited : nullptr;
  near_.subtree_pairs.clear();
  const TraversalTask both = task(step, a, b);
  near_.certificate = step.culling.hub_planes(both);
  find_subtree_pairs(both.traversal, start, step.motion.subtrees(a).max_leaves, stack_, near_);
  for (const NodePair pair : near_.subtree_pairs) keys_.push_back({a, b, pair.a, pair.b});
}

// Finds or makes the tiles of this step.
void BroadPhase::choose_tiles() {
  std::ranges::sort(keys_);
  active_.clear();
  next_tiles_.clear();
  auto old = tiles_.begin();
  const bool drops = tiles_.size() > kMaxTilesPerTile * keys_.size() + kMaxTiles;
  const auto keep_before = [&](const Tile::Key* key) {
    for (; old != tiles_.end() && (key == nullptr || (*old)->key < *key); ++old) {
      if (!drops || (*old)->last_step + kFrontLifetime >= steps_) next_tiles_.push_back(std::move(*old));
    }
  };
  for (const Tile::Key& key : keys_) {
    keep_before(&key);
    const bool known = old != tiles_.end() && (*old)->key == key;
    next_tiles_.push_back(known ? std::move(*old++) : std::make_unique<Tile>(key));
    next_tiles_.back()->last_step = steps_;
    active_.push_back(next_tiles_.back().get());
  }
  keep_before(nullptr);
  swap_buffers(tiles_, next_tiles_);
}

// Traverses what is below a pair of nodes, the children of `node`, from where the last traversal stopped.
// Then culls the pairs of leaves that were near and those found now.
void BroadPhase::run_part(const Step& step, const TraversalTask& task, NodeIndex node, NodePair start,
                          const Front::Segment* last, Tile& tile) {
  Local& local = locals_.local();
  Front& front = local.front;
  front.segments.push_back({node, front.pairs.size(), front.near.size()});
  std::span<const NodePair> starts{&start, 1};
  if (last != nullptr) {
    const bool is_end = last == &tile.front.segments.back();
    const std::size_t pairs = is_end ? tile.front.pairs.size() : last[1].pairs,
                      near = is_end ? tile.front.near.size() : last[1].near;
    starts = std::span(tile.front.pairs).subspan(last->pairs, pairs - last->pairs);
    const std::span were_near = std::span(tile.front.near).subspan(last->near, near - last->near);
    front.near.insert(front.near.end(), were_near.begin(), were_near.end());
    step.culling.cull_leaves(task, were_near, false, tile);
  }
  traverse(task.traversal, starts, local.stack, local.found);
  const PatchSlots* slots =
      task.object_a == task.object_b && step.keeps_fronts ? &step.culling.slots(task.object_a) : nullptr;
  const std::size_t known = front.near.size();
  for (const LeafPair leaves : local.found.leaf_pairs)
    front.near.push_back(
        {leaves, SlotIndex(slots != nullptr ? slots->of_leaves(leaves.a, leaves.b) : kNoIndex)});
  local.found.leaf_pairs.clear();
  step.culling.cull_leaves(task, std::span(front.near).subspan(known), true, tile);
}

void BroadPhase::run(const Step& step, const TraversalTask& task, Tile& tile) {
  const auto [object_a, object_b, a, b] = tile.key;
  tile.begin_step();
  Local& local = locals_.local();
  local.front.clear();
  const TaskFilter visited(step.filter, object_a, object_b);
  local.found.filter = step.filter.asks_nodes() ? &visited : nullptr;
  local.found.certificate = step.culling.hub_planes(task);
  local.found.front = step.keeps_fronts ? &local.front.pairs : nullptr;
  local.found.leaf_pairs.clear();
  local.found.node_tests = 0;
  const Front::Segment* last = tile.front.segments.data();
  const Front::Segment* const end = last + tile.front.segments.size();
  const auto resumes = [&](Index node, NodePair start) {
    const Tile::Key& key = tile.key;
    const bool is_due = (steps_ + (key.is_self() ? node : key.a + key.b)) % kFrontLifetime == 0;
    if (last == end || last->node != node || is_due) return false;
    const bool is_end = last + 1 == end;
    const std::size_t pairs = (is_end ? tile.front.pairs.size() : last[1].pairs) - last->pairs,
                      near = (is_end ? tile.front.near.size() : last[1].near) - last->near;
    // Around a hub one plane that fails brings many leaves near, and in the next step it may hold again.
    return 8 * near <= pairs || key.object_a != key.object_b ||
           !step.culling.hubs(key.object_a).have_common_hub(start);
  };
  if (tile.key.is_self()) {
    const auto nodes = step.motion.hierarchy(object_a).nodes();
    const auto proven = step.culling.proven(object_a);
    for (const LeafIndex leaf :
         step.culling.unproven_leaves(object_a, step.motion.subtrees(object_a).first_from(a)))
      tile.remaining.push_back({leaf, leaf});
    const NodeIndex end_of_tile = end_below(nodes, a);
    for (NodeIndex node = a; node < end_of_tile;) {
      if (proven[node]) {
        node = end_below(nodes, node);
        continue;
      }
      if (!nodes[node].is_leaf()) {
        while (last != end && last->node < node) ++last;
        const NodePair children = children_of(nodes, node);
        run_part(step, task, node, children, resumes(node, children) ? last : nullptr, tile);
      }
      node = NodeIndex(node + 1);
    }
  } else {
    run_part(step, task, {}, {a, b}, resumes({}, {a, b}) ? last : nullptr, tile);
  }
  tile.node_tests += local.found.node_tests;
  if (step.keeps_fronts) {
    tile.front = local.front;
  } else {
    tile.front.clear();
  }
}

void BroadPhase::find(const StepMotion& motion, Culling& culling, const Filter& filter,
                      const StepSettings& settings, double distance, Work& work) {
  const Step step{motion, culling, filter, separation_margin(motion.frame(), distance),
                  culling.keeps_fronts()};
  ++steps_;
  keys_.clear();
  near_.node_tests = 0;
  if (settings.within) {
    culling.prove_nodes(motion, filter, work);
    for (Index object = 0; object < motion.size(); ++object) list_within(step, object);
  }
  if (settings.between) {
    for (const auto& [a, b] : near_objects(motion, step.margin)) list_pairs(step, a, b, {});
  }
  choose_tiles();
  tasks_.clear();
  for (const Tile* tile : active_) tasks_.push_back(task(step, tile->key.object_a, tile->key.object_b));
  parallel_for(std::size_t{0}, active_.size(), [&](std::size_t k) {
    if (!filter.asks_nodes()) return run(step, tasks_[k], *active_[k]);
    isolated([&] { run(step, tasks_[k], *active_[k]); });  // the user's filter may start loops
  });
  leaf_pairs_.clear();
  std::uint64_t node_tests = near_.node_tests;
  for (Index k = 0; k < active_.size(); ++k) {
    node_tests += active_[k]->node_tests;
    culling.request_charts(*active_[k]);
    for (const LeafPair leaves : active_[k]->remaining) leaf_pairs_.push_back({k, leaves});
  }
  work.node_tests += node_tests;
  work.leaf_pairs += leaf_pairs_.size();
  culling.end_step(motion, node_tests, leaf_pairs_.size(), work);
}

std::uint64_t BroadPhase::count_near_leaves(const StepMotion& motion, const Culling& culling,
                                            const Filter& filter, const StepSettings& settings,
                                            double distance) {
  const float margin = separation_margin(motion.frame(), distance);
  std::atomic<std::uint64_t> count{0};
  const auto count_below = [&](Index a, Index b, NodePair start) {
    const TaskFilter visited(filter, a, b);
    Local& local = locals_.local();
    local.counted.leaf_pairs.clear();
    local.counted.filter = &visited;
    HubPairs around_hub(culling.hubs(a), motion.hierarchy(a).nodes());
    local.counted.certificate = a == b && !filter.asks_nodes() ? &around_hub : nullptr;
    isolated([&] {
      traverse({&motion.bvhs()[a], &motion.bvhs()[b], margin}, start, local.stack, local.counted);
    });
    count += local.counted.leaf_pairs.size() + around_hub.leaf_pairs;
  };
  for (Index a = 0; settings.within && a < motion.size(); ++a) {
    const auto nodes = motion.hierarchy(a).nodes();
    parallel_for(Index{0}, static_cast<Index>(nodes.size()), [&](Index n) {
      if (nodes[n].is_leaf()) {
        count += static_cast<std::uint64_t>(filter.nodes(a, n, a, n));
      } else {
        count_below(a, a, children_of(nodes, NodeIndex(n)));
      }
    });
  }
  if (settings.between) {
    const auto near = near_objects(motion, margin);
    parallel_for(std::size_t{0}, near.size(),
                 [&](std::size_t k) { count_below(near[k][0], near[k][1], {}); });
  }
  return count;
}

}  // namespace foldproof::internal
