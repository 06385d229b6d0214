#include "check/broad_phase.h"

#include <atomic>
#include <cmath>

namespace foldproof::internal {
namespace {

// Maximum tasks per pair of objects. A constant, so that the order of results does not depend on threads.
constexpr std::size_t kTasksPerPair = 64;
// Up to this many objects there is a front per pair of objects. Otherwise only one per object, since most
// pairs never come near each other.
constexpr std::size_t kMaxObjectsWithPairFronts = 16;
// The front of a node only gets finer, so it is rebuilt from the node's children after this many steps.
constexpr std::size_t kFrontLifetime = 16;

}  // namespace

BroadPhase::BroadPhase(const StepMotion& motion)
    : objects_(motion.size()),
      fronts_(objects_ > kMaxObjectsWithPairFronts ? objects_ : objects_ * objects_) {}

std::size_t BroadPhase::WorkItem::weight(Index leaves) const {
  return from_children ? 4 * static_cast<std::size_t>(std::sqrt(leaves)) : starts.size() + near.size();
}

// Reserves what most tasks need.
BroadPhase::TaskData::TaskData() {
  constexpr std::size_t kUsualSize = 32;
  front.pairs.reserve(kUsualSize);
  front.near.reserve(kUsualSize);
  found.leaf_pairs.reserve(kUsualSize);
  culled.remaining.reserve(kUsualSize);
}

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

// Null where there is none.
BroadPhase::Front* BroadPhase::front_of(Index a, Index b) {
  if (!uses_fronts_) return nullptr;
  if (objects_ > kMaxObjectsWithPairFronts) return a == b ? &fronts_[a] : nullptr;
  return &fronts_[a * objects_ + b];
}

// In proportion to the objects' sizes: small objects need no more than one task.
std::size_t BroadPhase::target_task_count(const StepMotion& motion, Index a, Index b) const {
  const std::size_t leaves = std::size_t{motion.hierarchy(a).leaf_count()} + motion.hierarchy(b).leaf_count();
  return std::max<std::size_t>(1, kTasksPerPair * leaves / (2 * motion.leaf_count()));
}

BroadPhase::TaskData& BroadPhase::add_task(const StepMotion& motion, Index a, Index b, float margin) {
  tasks_.push_back({{&motion.bvhs()[a], &motion.bvhs()[b], margin}, a, b});
  if (task_data_.size() < tasks_.size()) task_data_.emplace_back();
  TaskData& data = task_data_[tasks_.size() - 1];
  data.items.clear();
  data.starts.clear();
  data.front.clear();
  data.culled.clear();
  data.found.node_tests = 0;
  data.found.front = front_of(a, b) != nullptr ? &data.front.pairs : nullptr;
  data.filter.filter = filter_;
  data.filter.object_a = a;
  data.filter.object_b = b;
  data.found.filter = filter_->asks_nodes() ? &data.filter : nullptr;
  return data;
}

// Lists the traversals within an object: for each node that is neither proven nor below a proven one, that
// between its children, from the last front where there is one. Returns the sum of their weights.
std::size_t BroadPhase::list_items(const StepMotion& motion, Index object,
                                   std::span<const std::uint8_t> proven) {
  const auto nodes = motion.hierarchy(object).nodes();
  const Front* front = front_of(object, object);
  std::size_t at = 0, weight = 0;
  items_.clear();
  for (Index self = 0; self < nodes.size();) {
    const Hierarchy::Node& node = nodes[self];
    const Index leaves = node.leaf_end - node.leaf_begin;
    if (proven[self]) {
      self += 2 * leaves - 1;  // past everything below it
      continue;
    }
    if (!node.is_leaf()) {
      WorkItem& item = items_.emplace_back(WorkItem{self, true, {}, {}});
      while (front != nullptr && at < front->segments.size() && front->segments[at].node < self) ++at;
      if (front != nullptr && at < front->segments.size() && front->segments[at].node == self &&
          (steps_ + self) % kFrontLifetime != 0) {
        const bool last = at + 1 == front->segments.size();
        const Front::Segment begin = front->segments[at],
                             end = last ? Front::Segment{0, front->pairs.size(), front->near.size()}
                                        : front->segments[at + 1];
        item.from_children = false;
        item.starts = std::span(front->pairs).subspan(begin.pairs, end.pairs - begin.pairs);
        item.near = std::span(front->near).subspan(begin.near, end.near - begin.near);
      }
      weight += item.weight(leaves);
    }
    ++self;
  }
  return weight;
}

// Distributes the items to tasks of about the same weight.
void BroadPhase::make_self_tasks(const StepMotion& motion, Index object, const Culling::SelfPairs& self_pairs,
                                 float margin) {
  const auto nodes = motion.hierarchy(object).nodes();
  TaskData& leaves = add_task(motion, object, object, margin);
  for (const Index leaf : self_pairs.unproven_leaves) leaves.culled.remaining.push_back({leaf, leaf});
  const std::size_t max_weight =
      list_items(motion, object, self_pairs.proven) / target_task_count(motion, object, object) + 1;
  TaskData* data = nullptr;
  std::size_t capacity = 0;
  for (WorkItem item : items_) {
    const Hierarchy::Node& node = nodes[item.node];
    do {
      if (capacity == 0) {
        data = &add_task(motion, object, object, margin);
        capacity = max_weight;
      }
      WorkItem part = item;
      part.starts = item.starts.first(std::min(item.starts.size(), capacity));
      part.near = item.near.first(std::min(item.near.size(), capacity));
      item.starts = item.starts.subspan(part.starts.size());
      item.near = item.near.subspan(part.near.size());
      data->items.push_back(part);
      capacity -= std::min(capacity, part.weight(node.leaf_end - node.leaf_begin));
    } while (!item.starts.empty() || !item.near.empty());
  }
}

// Starts from the last front, or descends from the roots until there are enough pairs for all tasks. Pairs of
// leaves that the descent finds get a task of their own.
void BroadPhase::make_pair_tasks(const StepMotion& motion, Index a, Index b, float margin) {
  const Front* front = front_of(a, b);
  const std::size_t target = target_task_count(motion, a, b);
  std::span<const NodePair> starts;
  std::span<const NearLeafPair> near;
  if (front != nullptr && !front->segments.empty() && steps_ % kFrontLifetime != 0) {
    starts = front->pairs;
    near = front->near;
  } else {
    TaskData& descent_task = add_task(motion, a, b, margin);
    descent_.assign(1, {0, 0});
    for (int level = 0; level < 12 && !descent_.empty() && descent_.size() < 4 * target; ++level)
      descend_once(tasks_.back().traversal, descent_, descent_scratch_, descent_task.found);
    starts = descent_;
  }
  const std::size_t count = std::max<std::size_t>(1, std::min(target, starts.size() + near.size()));
  const auto part = [&](auto all, std::size_t k) {
    const std::size_t begin = k * all.size() / count;
    return all.subspan(begin, (k + 1) * all.size() / count - begin);
  };
  for (std::size_t k = 0; k < count; ++k) {
    TaskData& data = add_task(motion, a, b, margin);
    const auto own = part(starts, k);
    data.starts.assign(own.begin(), own.end());
    data.items.push_back({0, false, data.starts, part(near, k)});
  }
}

// Per item: traverses, then culls the pairs of leaves of the front and the newly found ones.
void BroadPhase::run_task(Index k, Culling& culling) {
  const TraversalTask& task = tasks_[k];
  TaskData& data = task_data_[k];
  const PatchSlots* slots =
      task.object_a == task.object_b && uses_fronts_ ? &culling.slots(task.object_a) : nullptr;
  const auto cull_found = [&] {
    for (const NodePair leaves : data.found.leaf_pairs)
      data.front.near.push_back({leaves, slots != nullptr ? slots->of_leaves(leaves.a, leaves.b) : kNoIndex});
    culling.cull_leaves(task, std::span(data.front.near).last(data.found.leaf_pairs.size()), true,
                        data.culled);
    data.found.leaf_pairs.clear();
  };
  const auto begin_segment = [&](Index node) {
    data.front.segments.push_back({node, data.front.pairs.size(), data.front.near.size()});
  };
  // Pairs of leaves that the descent found when it cut the traversal of two objects into tasks.
  if (data.items.empty() && !data.found.leaf_pairs.empty()) begin_segment(0);
  cull_found();
  for (const WorkItem& item : data.items) {
    const NodePair children{item.node + 1, task.traversal.a->hierarchy->nodes()[item.node].right};
    begin_segment(item.node);
    traverse(task.traversal, item.from_children ? std::span(&children, 1) : item.starts,
             locals_.local().stack, data.found);
    data.front.near.insert(data.front.near.end(), item.near.begin(), item.near.end());
    culling.cull_leaves(task, item.near, false, data.culled);
    cull_found();
  }
}

void BroadPhase::store_fronts() {
  for (Index k = 0; k < tasks_.size(); ++k) {
    Front* front = front_of(tasks_[k].object_a, tasks_[k].object_b);
    if (front == nullptr) continue;
    if (k == 0 || front != front_of(tasks_[k - 1].object_a, tasks_[k - 1].object_b)) front->clear();
    const Front& found = task_data_[k].front;
    for (const Front::Segment& segment : found.segments) {
      // The parts of an item form one segment.
      if (!front->segments.empty() && front->segments.back().node == segment.node) continue;
      front->segments.push_back(
          {segment.node, front->pairs.size() + segment.pairs, front->near.size() + segment.near});
    }
    front->pairs.insert(front->pairs.end(), found.pairs.begin(), found.pairs.end());
    front->near.insert(front->near.end(), found.near.begin(), found.near.end());
  }
}

void BroadPhase::find(const StepMotion& motion, Culling& culling, const Filter& filter,
                      const StepSettings& settings, double distance, Work& work) {
  const float margin = separation_margin(motion.frame(), distance);
  filter_ = &filter;
  ++steps_;
  uses_fronts_ = culling.may_cull_later();
  tasks_.clear();
  if (settings.within) {
    for (Index object = 0; object < motion.size(); ++object) {
      if (filter.nodes(object, 0, object, 0))
        make_self_tasks(motion, object, culling.cull_self_pairs(motion, object, filter, work), margin);
    }
  }
  if (settings.between) {
    for (const auto& [a, b] : near_objects(motion, margin)) {
      if (filter.nodes(a, 0, b, 0)) make_pair_tasks(motion, a, b, margin);
    }
  }
  const auto count = static_cast<Index>(tasks_.size());
  parallel_for(Index{0}, count, [&](Index k) { run_task(k, culling); });
  store_fronts();
  leaf_pairs_.clear();
  std::uint64_t node_tests = 0;
  for (Index k = 0; k < count; ++k) {
    node_tests += task_data_[k].found.node_tests + task_data_[k].culled.node_tests;
    culling.cache_planes(tasks_[k], task_data_[k].culled.planes);
    for (const NodePair leaves : task_data_[k].culled.remaining) leaf_pairs_.push_back({k, leaves});
  }
  for (const LeafPair& pair : leaf_pairs_) culling.note_remaining(tasks_[pair.task], pair.leaves);
  work.node_tests += node_tests;
  work.leaf_pairs += leaf_pairs_.size();
  culling.end_step(motion, node_tests, leaf_pairs_.size(), work);
}

std::uint64_t BroadPhase::count_near_leaves(const StepMotion& motion, const Filter& filter,
                                            const StepSettings& settings, double distance) {
  const float margin = separation_margin(motion.frame(), distance);
  std::atomic<std::uint64_t> count{0};
  const auto count_below = [&](Index a, Index b, NodePair start) {
    TaskFilter visited;
    visited.filter = &filter;
    visited.object_a = a;
    visited.object_b = b;
    Local& local = locals_.local();
    local.counted.leaf_pairs.clear();
    local.counted.filter = &visited;
    traverse({&motion.bvhs()[a], &motion.bvhs()[b], margin}, start, local.stack, local.counted);
    count += local.counted.leaf_pairs.size();
  };
  for (Index a = 0; settings.within && a < motion.size(); ++a) {
    const auto nodes = motion.hierarchy(a).nodes();
    parallel_for(Index{0}, static_cast<Index>(nodes.size()), [&](Index n) {
      if (nodes[n].is_leaf()) {
        count += static_cast<std::uint64_t>(filter.nodes(a, n, a, n));
      } else {
        count_below(a, a, {n + 1, nodes[n].right});
      }
    });
  }
  if (settings.between) {
    const auto near = near_objects(motion, margin);
    parallel_for(std::size_t{0}, near.size(), [&](std::size_t k) {
      count_below(near[k][0], near[k][1], {0, 0});
    });
  }
  return count;
}

}  // namespace foldproof::internal
