#include "query/scene.h"

#include <fmt/format.h>

#include <cmath>
#include <map>

#include "base/parallel.h"

namespace foldproof {
namespace {

// About how much there is to do.
std::size_t weight_of(const TraversalShare::Part& part, Index leaves) {
  return part.fresh ? 4 * static_cast<std::size_t>(std::sqrt(leaves)) : part.starts.size() + part.near.size();
}

// Tasks per pair of objects; a constant, so that the order of the answer never depends on the threads.
constexpr std::size_t kEnoughTasks = 64;
// There is one front per pair of objects; of many objects only those with themselves, as most others never
// meet.
constexpr std::size_t kManyObjects = 16;
// The front of a node is made anew from its children every so many steps, as it only ever gets finer.
constexpr std::size_t kFrontUses = 16;

std::vector<Index> unused_vertices(const Hierarchy& hierarchy) {
  const std::size_t count = hierarchy.topology().vertex_count();
  std::vector<Index> unused;
  if (hierarchy.vertex_ids().size() == count) return unused;
  std::vector<bool> used(count, false);
  for (const Index v : hierarchy.vertex_ids()) used[v] = true;
  for (std::size_t v = 0; v < count; ++v) {
    if (!used[v]) unused.push_back(static_cast<Index>(v));
  }
  return unused;
}

}  // namespace

Scene::Scene(std::vector<std::shared_ptr<const Hierarchy>> objects,
             std::vector<std::shared_ptr<const ChartLibrary>> charts,
             std::vector<std::shared_ptr<const Learned>> learned) {
  charts.resize(objects.size());
  learned.resize(objects.size());
  std::map<const Hierarchy*, std::shared_ptr<const PatchSlots>> slots_of;  // one for all instances of a mesh
  std::map<const Hierarchy*, std::shared_ptr<const std::vector<Index>>> unused_of;  // the same
  for (std::size_t i = 0; i < objects.size(); ++i) {
    leaf_count_ += objects[i]->leaf_count();
    leaf_needed_.emplace_back(objects[i]->leaf_count(), std::uint8_t{0});
    auto& unused = unused_of[objects[i].get()];
    if (!unused) unused = std::make_shared<const std::vector<Index>>(unused_vertices(*objects[i]));
    unused_.push_back(unused);
    auto& slots = slots_of[objects[i].get()];
    if (charts[i]) {
      slots = charts[i]->slots();
    } else if (!slots) {
      slots = std::make_shared<const PatchSlots>(objects[i]);
    }
    books_.push_back(std::make_unique<ChartBook>(slots, std::move(charts[i])));
    const bool predicted = learned[i] && learned[i]->certificates;
    beliefs_.push_back(
        predicted ? std::make_unique<Beliefs>(std::move(learned[i]), objects[i]->nodes().size()) : nullptr);
    leaf_proofs_.emplace_back(objects[i]->leaf_count());
    trees_.emplace_back(std::move(objects[i]));
  }
  fronts_.resize(trees_.size() > kManyObjects ? trees_.size() : trees_.size() * trees_.size());
}

Result<void> Scene::predict(Positions x0, Positions x1, const StepSettings& settings) {
  believes_ = settings.mode == Mode::Paper;
  if (!believes_ || !settings.within) return {};
  for (Index i = 0; i < trees_.size(); ++i) {
    if (!beliefs_[i])
      return fail(fmt::format("object {}", i), "has nothing learned that predicts its certificates",
                  "train a model on at least 3 poses that differ, or leave the mode paper");
    beliefs_[i]->look(x0[i], x1[i], settings.miss_rate);
  }
  return {};
}

// By the roots' boxes.
std::span<const BroadPhase::Pair> Scene::near_objects(float margin) {
  object_boxes_.clear();
  for (const KineticTree& tree : trees_) {
    constexpr double kNowhere = std::numeric_limits<double>::infinity();
    SweptBox& box = object_boxes_.emplace_back();
    box.low.fill(kNowhere);
    box.high.fill(-kNowhere);
    if (tree.boxes.empty()) continue;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto& x = tree.boxes[0].x;
      box.low[axis] = std::min(x[0][0][axis], x[1][0][axis]);
      box.high[axis] = -std::min(x[0][1][axis], x[1][1][axis]);
    }
  }
  return broad_phase_.pairs(object_boxes_, margin);
}

// Goes down from the root through the pairs of a node with itself, level by level. Marks the proven ones in
// self_proven_, and leaves the leaves that are not in unproven_leaves_.
void Scene::descend_selves(Index object, const StepSettings& settings, double gap, Work& work) {
  ChartBook& book = *books_[object];
  const auto nodes = hierarchy(object).nodes();
  auto& leaf_proofs = leaf_proofs_[object];
  for (LeafProofs& proofs : leaf_proofs) proofs.clear();
  self_proven_.assign(nodes.size(), 0);
  unproven_leaves_.clear();
  selves_.assign(nodes.empty() ? 0 : 1, 0);
  for (Index level = 0; !selves_.empty(); ++level) {
    work.node_tests += selves_.size();
    self_proofs_.assign(selves_.size(), {});
    if (believes_) {
      believe_selves(object);
    } else if (settings.certificates) {
      prove_selves(object, gap);
    }
    selves_below_.clear();
    for (std::size_t i = 0; i < selves_.size(); ++i) {
      const Index self = selves_[i];
      const Hierarchy::Node& node = nodes[self];
      if (self_proofs_[i]) {
        self_proven_[self] = 1;
        if (settings.explain) proven_nodes_.push_back({object, self, level, self_proofs_[i]});
        for (Index leaf = node.leaf_begin; leaf < node.leaf_end; ++leaf) leaf_proofs[leaf].add(self);
        for (const Index leaf : self_proofs_[i].collar()) leaf_proofs[leaf].add(self);
        continue;
      }
      if (settings.certificates && !believes_) book.want_node(self);
      if (node.is_leaf()) {
        unproven_leaves_.push_back(node.leaf_begin);
      } else {
        selves_below_.push_back(self + 1);
        selves_below_.push_back(node.right);
      }
    }
    selves_.swap(selves_below_);
  }
}

// Null where none is kept.
Front* Scene::front_of(Index a, Index b) {
  const std::size_t n = trees_.size();
  if (!keeps_fronts_) return nullptr;
  if (n > kManyObjects) return a == b ? &fronts_[a] : nullptr;
  return &fronts_[a * n + b];
}

// A share of all by size: many small objects need not be cut up.
std::size_t Scene::enough_tasks(Index a, Index b) const {
  const std::size_t leaves = std::size_t{hierarchy(a).leaf_count()} + hierarchy(b).leaf_count();
  return std::max<std::size_t>(1, kEnoughTasks * leaves / (2 * leaf_count_));
}

TraversalShare& Scene::add_task(Index a, Index b, float margin) {
  tasks_.push_back({{&trees_[a], &trees_[b], margin}, a, b});
  if (shares_.size() < tasks_.size()) shares_.emplace_back().reserve();
  TraversalShare& share = shares_[tasks_.size() - 1];
  share.parts.clear();
  share.starts.clear();
  share.front.clear();
  share.unproven.clear();
  share.found.node_tests = 0;
  share.found.front = front_of(a, b) != nullptr ? &share.front.pairs : nullptr;
  share.planes.clear();
  return share;
}

// What there is to traverse within an object: for each node that is neither proven nor below one that is,
// what lies between its children, from the last front on where there is one. Gives about how much it is.
std::size_t Scene::list_parts(Index object) {
  const auto nodes = hierarchy(object).nodes();
  const Front* front = front_of(object, object);
  std::size_t run = 0, weight = 0;
  parts_.clear();
  for (Index self = 0; self < nodes.size();) {
    const Hierarchy::Node& node = nodes[self];
    const Index leaves = node.leaf_end - node.leaf_begin;
    if (self_proven_[self]) {
      self += 2 * leaves - 1;  // past everything below it
      continue;
    }
    if (!node.is_leaf()) {
      TraversalShare::Part& part = parts_.emplace_back(TraversalShare::Part{self, true, {}, {}});
      while (front != nullptr && run < front->runs.size() && front->runs[run].node < self) ++run;
      if (front != nullptr && run < front->runs.size() && front->runs[run].node == self &&
          (steps_ + self) % kFrontUses != 0) {
        const bool last = run + 1 == front->runs.size();
        const Front::Run begin = front->runs[run],
                         end = last ? Front::Run{0, static_cast<Index>(front->pairs.size()),
                                                 static_cast<Index>(front->near.size())}
                                    : front->runs[run + 1];
        part.fresh = false;
        part.starts = std::span(front->pairs).subspan(begin.pairs, end.pairs - begin.pairs);
        part.near = std::span(front->near).subspan(begin.near, end.near - begin.near);
      }
      weight += weight_of(part, leaves);
    }
    ++self;
  }
  return weight;
}

// Deals what there is out to tasks of about the same size.
void Scene::start_within(Index object, float margin) {
  const auto nodes = hierarchy(object).nodes();
  TraversalShare& leaves = add_task(object, object, margin);
  for (const Index leaf : unproven_leaves_) leaves.unproven.push_back({leaf, leaf});
  const std::size_t most = list_parts(object) / enough_tasks(object, object) + 1;
  TraversalShare* share = nullptr;
  std::size_t room = 0;
  for (TraversalShare::Part part : parts_) {
    const Hierarchy::Node& node = nodes[part.node];
    do {
      if (room == 0) {
        share = &add_task(object, object, margin);
        room = most;
      }
      TraversalShare::Part cut = part;
      cut.starts = part.starts.first(std::min(part.starts.size(), room));
      cut.near = part.near.first(std::min(part.near.size(), room));
      part.starts = part.starts.subspan(cut.starts.size());
      part.near = part.near.subspan(cut.near.size());
      share->parts.push_back(cut);
      room -= std::min(room, weight_of(cut, node.leaf_end - node.leaf_begin));
    } while (!part.starts.empty() || !part.near.empty());
  }
}

// From the last front on, or down from the roots until there are enough pairs for all tasks; what is found on
// the way gets a task of its own.
void Scene::start_between(Index a, Index b, float margin) {
  const Front* front = front_of(a, b);
  const std::size_t enough = enough_tasks(a, b);
  std::span<const NodePair> starts;
  std::span<const NearLeaves> near;
  if (front != nullptr && !front->runs.empty() && steps_ % kFrontUses != 0) {
    starts = front->pairs;
    near = front->near;
  } else {
    TraversalShare& above = add_task(a, b, margin);
    spread_.assign(1, {0, 0});
    for (int level = 0; level < 12 && !spread_.empty() && spread_.size() < 4 * enough; ++level)
      descend_once(tasks_.back().traversal, spread_, spread_below_, above.found);
    starts = spread_;
  }
  const std::size_t count = std::max<std::size_t>(1, std::min(enough, starts.size() + near.size()));
  const auto cut = [&](auto all, std::size_t k) {
    const std::size_t begin = k * all.size() / count;
    return all.subspan(begin, (k + 1) * all.size() / count - begin);
  };
  for (std::size_t k = 0; k < count; ++k) {
    TraversalShare& share = add_task(a, b, margin);
    const auto part = cut(starts, k);
    share.starts.assign(part.begin(), part.end());
    share.parts.push_back({0, false, share.starts, cut(near, k)});
  }
}

// Nodes first, then the leaves that were near before and those that are for the first time.
void Scene::run_task(Index k, bool prove, double gap) {
  const TraversalTask& task = tasks_[k];
  TraversalShare& share = shares_[k];
  Local& local = locals_.local();
  const PatchSlots* slots = task.object_a == task.object_b ? &books_[task.object_a]->slots() : nullptr;
  const auto take_found = [&] {
    for (const NodePair leaves : share.found.leaf_pairs) {
      const Index slot = slots != nullptr && prove ? slots->of_leaves(leaves.a, leaves.b) : kNoIndex;
      share.front.near.push_back({leaves, slot});
    }
    const std::size_t count = share.found.leaf_pairs.size();
    if (prove) {
      ask_near_leaves(k, std::span(share.front.near).last(count), true, gap, local);
    } else {
      share.unproven.insert(share.unproven.end(), share.found.leaf_pairs.begin(),
                            share.found.leaf_pairs.end());
    }
    share.found.leaf_pairs.clear();
  };
  const auto begin_run = [&](Index node) {
    share.front.runs.push_back(
        {node, static_cast<Index>(share.front.pairs.size()), static_cast<Index>(share.front.near.size())});
  };
  // Found when the traversal of two objects was cut into tasks.
  if (share.parts.empty() && !share.found.leaf_pairs.empty()) begin_run(0);
  take_found();
  for (const TraversalShare::Part& part : share.parts) {
    const NodePair children{part.node + 1, hierarchy(task.object_a).nodes()[part.node].right};
    begin_run(part.node);
    foldproof::traverse(task.traversal, part.fresh ? std::span(&children, 1) : part.starts, local.stack,
                        share.found);
    share.front.near.insert(share.front.near.end(), part.near.begin(), part.near.end());
    ask_near_leaves(k, part.near, false, gap, local);
    take_found();
  }
}

void Scene::keep_fronts() {
  for (Index k = 0; k < tasks_.size(); ++k) {
    Front* front = front_of(tasks_[k].object_a, tasks_[k].object_b);
    if (front == nullptr) continue;
    if (k == 0 || front != front_of(tasks_[k - 1].object_a, tasks_[k - 1].object_b)) front->clear();
    const Front& found = shares_[k].front;
    for (const Front::Run& run : found.runs) {
      // A part that was cut up is one run again.
      if (!front->runs.empty() && front->runs.back().node == run.node) continue;
      front->runs.push_back({run.node, static_cast<Index>(front->pairs.size() + run.pairs),
                             static_cast<Index>(front->near.size() + run.near)});
    }
    front->pairs.insert(front->pairs.end(), found.pairs.begin(), found.pairs.end());
    front->near.insert(front->near.end(), found.near.begin(), found.near.end());
  }
}

// Charts are drawn from the second step on: who asks only once should not pay for them. The budget keeps
// drawing, about 0.1 us a triangle, well below what the pairs of leaves took that were tested in the step
// before, about 1 us each: up to five triangles for each where charts prove to be of use, a fraction of one
// where they do not.
void Scene::begin_learning(const StepSettings& settings) {
  constexpr double kMost = 5, kLeast = 0.5;
  constexpr double kUsual = 3, kLittle = 256;  // what little meshes need costs little
  double drawn = 0, of_use = 0, asked = 0, found = 0;
  for (const auto& book : books_) drawn += static_cast<double>(book->drawings());
  for (Local& local : locals_) {
    of_use += static_cast<double>(std::exchange(local.tester.of_use, 0));
    local.tests = local.passes = local.tester.tests = 0;
    asked += static_cast<double>(std::exchange(local.new_planes, 0));
    found += static_cast<double>(std::exchange(local.new_planes_found, 0));
  }
  drawn_ = drawn_ / 2 + drawn;
  of_use_ = of_use_ / 2 + of_use;
  const double share = std::clamp(6 * (of_use_ + 3) / (drawn_ + 9), kLeast, kMost);
  planes_.asked = planes_.asked / 2 + asked;
  planes_.found = planes_.found / 2 + found;
  planes_.pay = planes_.found > planes_.asked / 4;
  ask_for_planes_ = steps_++ > 0 && !believes_;
  const double pairs = static_cast<double>(last_leaf_pairs_) / static_cast<double>(books_.size());
  const double budget = std::max(share * pairs, std::min(kUsual * pairs, kLittle));
  const bool draws = settings.certificates && !believes_;
  for (std::size_t i = 0; i < books_.size(); ++i)
    books_[i]->begin_step(trees_[i].vertices, draws ? static_cast<std::size_t>(budget) : 0);
}

void Scene::traverse(const StepSettings& settings, double distance, Work& work) {
  const float margin = separation_margin(frame_, distance);
  const double gap = distance * frame_.scale * (1 + 0x1p-50);
  begin_learning(settings);
  keeps_fronts_ = settings.certificates;
  tasks_.clear();
  proven_nodes_.clear();
  if (settings.within) {
    for (Index object = 0; object < trees_.size(); ++object) {
      descend_selves(object, settings, gap, work);
      start_within(object, margin);
    }
  }
  if (settings.between) {
    for (const auto& [a, b] : near_objects(margin)) start_between(a, b, margin);
  }
  const bool prove = settings.certificates || believes_;
  if (prove) make_plane_memory();
  parallel_for(Index{0}, static_cast<Index>(tasks_.size()), [&](Index k) { run_task(k, prove, gap); });
  keep_fronts();
  leaf_pairs_.clear();
  for (Index k = 0; k < tasks_.size(); ++k) {
    work.node_tests += shares_[k].found.node_tests;
    for (const NodePair leaves : shares_[k].unproven) leaf_pairs_.push_back({k, leaves});
  }
  if (prove) remember_proofs();
  for (const Local& local : locals_) {
    work.certificate_tests += local.tests + local.tester.tests;
    work.certificate_passes += local.passes;
  }
  work.leaf_pairs += leaf_pairs_.size();
  last_leaf_pairs_ = leaf_pairs_.size();
  fill_features();
}

void Scene::fill_features() {
  leaves_to_fill_.clear();
  const auto need = [&](Index object, Index leaf) {
    if (leaf_needed_[object][leaf]) return;
    leaf_needed_[object][leaf] = 1;
    leaves_to_fill_.emplace_back(object, leaf);
  };
  for (const LeafPairRef& pair : leaf_pairs_) {
    need(tasks_[pair.task].object_a, pair.leaves.a);
    need(tasks_[pair.task].object_b, pair.leaves.b);
  }
  parallel_for(IndexRange{0, leaves_to_fill_.size()}, 256, [&](IndexRange range) {
    for (std::size_t i = range.begin; i < range.end; ++i) {
      trees_[leaves_to_fill_[i].first].fill_features(leaves_to_fill_[i].second);
    }
  });
  for (const auto& [object, leaf] : leaves_to_fill_) leaf_needed_[object][leaf] = 0;
}

}  // namespace foldproof
