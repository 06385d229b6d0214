#include "query/scene.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <cmath>
#include <map>

namespace foldproof {
namespace {

// Tasks per pair of objects; a constant, so that the order of the answer never depends on the threads.
constexpr std::size_t kEnoughTasks = 64;
// There is one front per pair of objects; of many objects only those with themselves, as most others never
// meet.
constexpr std::size_t kManyObjects = 16;
// A front is used for so many steps.
constexpr int kFrontUses = 15;

struct Bounds {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 high = -low;
  bool finite = true;
};

// Four vertices side by side, so that the compiler takes several coordinates at a time.
Bounds bounds_of(std::span<const double> x) {
  constexpr std::size_t kLanes = 12;
  double low[kLanes], high[kLanes],
      poison[kLanes] = {};  // poison: zero unless a coordinate is infinite or NaN
  std::fill_n(low, kLanes, std::numeric_limits<double>::infinity());
  std::fill_n(high, kLanes, -std::numeric_limits<double>::infinity());
  const auto look = [&](const double* c, std::size_t count) {
    for (std::size_t lane = 0; lane < count; ++lane) {
      poison[lane] += c[lane] * 0;
      low[lane] = c[lane] < low[lane] ? c[lane] : low[lane];
      high[lane] = c[lane] > high[lane] ? c[lane] : high[lane];
    }
  };
  std::size_t i = 0;
  for (; i + kLanes <= x.size(); i += kLanes) look(&x[i], kLanes);
  if (i < x.size()) look(&x[i], x.size() - i);
  Bounds b;
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    b.low[lane % 3] = std::min(b.low[lane % 3], low[lane]);
    b.high[lane % 3] = std::max(b.high[lane % 3], high[lane]);
    b.finite &= poison[lane] == 0;
  }
  return b;
}

Result<void> check_numbers(Index object, const char* end, std::span<const double> x) {
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (!std::isfinite(x[i])) {
      return fail(fmt::format("object {}, vertex {}", object, i / 3),
                  fmt::format("has a coordinate in {} that is not finite", end), "repair the positions");
    }
  }
  return {};
}

}  // namespace

Scene::Scene(std::vector<std::shared_ptr<const Hierarchy>> objects,
             std::vector<std::shared_ptr<const ChartLibrary>> charts,
             std::vector<std::shared_ptr<const Learned>> learned) {
  charts.resize(objects.size());
  learned.resize(objects.size());
  std::map<const Hierarchy*, std::shared_ptr<const PatchSlots>> slots_of;  // one for all instances of a mesh
  for (std::size_t i = 0; i < objects.size(); ++i) {
    leaf_count_ += objects[i]->leaf_count();
    leaf_needed_.emplace_back(objects[i]->leaf_count(), std::uint8_t{0});
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

Result<void> Scene::update(Positions x0, Positions x1, const StepSettings& settings) {
  if (x0.size() != trees_.size() || x1.size() != trees_.size()) {
    return fail("positions", fmt::format("given for {} and {} objects", x0.size(), x1.size()),
                fmt::format("give them for all {}", trees_.size()));
  }
  Bounds all;
  for (Index i = 0; i < trees_.size(); ++i) {
    const std::size_t expected = 3 * std::size_t{hierarchy(i).topology().vertex_count()};
    for (const auto& [end, x] : {std::pair("x0", x0[i]), std::pair("x1", x1[i])}) {
      if (x.size() != expected) {
        return fail(fmt::format("object {}", i), fmt::format("{} has {} numbers", end, x.size()),
                    fmt::format("give {}, three per vertex", expected));
      }
      const Bounds b = bounds_of(x);
      if (!b.finite) return check_numbers(i, end, x);
      all.low = all.low.cwiseMin(b.low);
      all.high = all.high.cwiseMax(b.high);
    }
  }
  frame_ = frame_around(all.low, all.high);
  largest_side_ = std::min(2 * (all.high / 2 - all.low / 2).maxCoeff(), std::numeric_limits<double>::max());
  for (std::size_t i = 0; i < trees_.size(); ++i) trees_[i].refit(frame_, x0[i], x1[i]);
  return predict(x0, x1, settings);
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

// Goes down from the root through the pairs of a node with itself. Leaves in front_ the pairs of children
// below those nodes that are not proven, and in above_ the leaves.
void Scene::descend_selves(Index object, const StepSettings& settings, double gap, Work& work) {
  ChartBook& book = *books_[object];
  const auto nodes = hierarchy(object).nodes();
  auto& leaf_proofs = leaf_proofs_[object];
  for (LeafProofs& proofs : leaf_proofs) proofs.count = 0;
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
        proven_selves_.push_back(self);
        if (settings.explain) proven_nodes_.push_back({object, self, level, self_proofs_[i]});
        for (Index leaf = node.leaf_begin; leaf < node.leaf_end; ++leaf) leaf_proofs[leaf].add(self);
        for (const Index leaf : self_proofs_[i].collar()) leaf_proofs[leaf].add(self);
        continue;
      }
      if (settings.certificates && !believes_) book.want_node(self);
      if (node.is_leaf()) {
        above_.leaf_pairs.push_back({node.leaf_begin, node.leaf_begin});
      } else {
        front_.push_back({self + 1, node.right});
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

// Deals the pairs in front_ out to tasks, or those of the last step's front when the same nodes were proven
// as then. Else it goes down until there are enough of them; leaf pairs found on the way get a task of their
// own.
void Scene::start_tasks(Index a, Index b, float margin, Work& work) {
  const Traversal traversal{&trees_[a], &trees_[b], margin};
  const std::size_t enough = enough_tasks(a, b);
  Front* front = front_of(a, b);
  const bool again = front != nullptr && front->uses_left > 0 && front->proven == proven_selves_;
  front_above_.clear();
  if (again) {
    front_.swap(front->pairs);
    --front->uses_left;
  } else {
    above_.front = &front_above_;
    for (int level = 0; level < 12 && !front_.empty() && front_.size() < 4 * enough; ++level) {
      descend_once(traversal, front_, below_, above_);
    }
    if (front != nullptr) front->uses_left = kFrontUses;
  }
  if (front != nullptr) {
    front->proven = proven_selves_;
    front->pairs.assign(front_above_.begin(), front_above_.end());
  }
  const std::size_t count = std::min(enough, front_.size()), first = task_count_;
  task_count_ += count + 1;
  if (tasks_.size() < task_count_) tasks_.resize(task_count_);
  for (std::size_t k = first; k < task_count_; ++k) {
    TraversalTask& task = tasks_[k];
    task.traversal = traversal;
    task.object_a = a;
    task.object_b = b;
    task.starts.clear();
    task.front.clear();
    task.found.leaf_pairs.clear();
    task.found.node_tests = 0;
  }
  // Runs of a front lie near each other; starts from the root differ in size, the largest first.
  for (std::size_t i = 0; i < front_.size(); ++i) {
    tasks_[first + (again ? i * count / front_.size() : i % count)].starts.push_back(front_[i]);
  }
  tasks_[first + count].found.leaf_pairs = above_.leaf_pairs;
  above_.leaf_pairs.clear();
  work.node_tests += std::exchange(above_.node_tests, 0);
}

void Scene::keep_fronts() {
  for (std::size_t k = 0; k < task_count_; ++k) {
    const TraversalTask& task = tasks_[k];
    if (Front* front = front_of(task.object_a, task.object_b)) {
      front->pairs.insert(front->pairs.end(), task.front.begin(), task.front.end());
    }
  }
}

// Charts are drawn from the second step on: who asks only once should not pay for them. The budget keeps
// drawing, about 0.2 us a triangle, well below what the pairs of leaves took that were tested in the step
// before, about 1 us each.
void Scene::begin_learning(const StepSettings& settings) {
  constexpr std::size_t kTrianglesPerLeafPair = 3;
  ask_for_planes_ = steps_++ > 0 && !believes_;
  const std::size_t budget =
      settings.certificates && !believes_ ? kTrianglesPerLeafPair * last_leaf_pairs_ : 0;
  for (std::size_t i = 0; i < books_.size(); ++i)
    books_[i]->begin_step(trees_[i].vertices, budget / books_.size());
}

void Scene::traverse(const StepSettings& settings, double distance, Work& work) {
  const float margin = separation_margin(frame_, distance);
  const double gap = distance * frame_.scale * (1 + 0x1p-50);
  for (Local& local : locals_) local.tests = local.passes = local.tester.tests = 0;
  begin_learning(settings);
  keeps_fronts_ = settings.certificates;
  task_count_ = 0;
  proven_nodes_.clear();
  if (settings.within) {
    for (Index object = 0; object < trees_.size(); ++object) {
      front_.clear();
      proven_selves_.clear();
      descend_selves(object, settings, gap, work);
      start_tasks(object, object, margin, work);
    }
  }
  if (settings.between) {
    proven_selves_.clear();
    for (const auto& [a, b] : near_objects(margin)) {
      front_.assign(1, {0, 0});
      start_tasks(a, b, margin, work);
    }
  }
  tbb::parallel_for(std::size_t{0}, task_count_, [&](std::size_t k) {
    TraversalTask& task = tasks_[k];
    task.found.front = front_of(task.object_a, task.object_b) != nullptr ? &task.front : nullptr;
    for (const NodePair start : task.starts) {
      foldproof::traverse(task.traversal, start, locals_.local().stack, task.found);
    }
  });
  keep_fronts();
  leaf_pairs_.clear();
  for (std::size_t k = 0; k < task_count_; ++k) {
    work.node_tests += tasks_[k].found.node_tests;
    for (const NodePair leaves : tasks_[k].found.leaf_pairs)
      leaf_pairs_.push_back({static_cast<Index>(k), leaves});
  }
  if (settings.certificates || believes_) prove_leaf_pairs(gap);
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
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, leaves_to_fill_.size(), 256),
                    [&](const tbb::blocked_range<std::size_t>& range) {
                      for (std::size_t i = range.begin(); i < range.end(); ++i) {
                        trees_[leaves_to_fill_[i].first].fill_features(leaves_to_fill_[i].second);
                      }
                    });
  for (const auto& [object, leaf] : leaves_to_fill_) leaf_needed_[object][leaf] = 0;
}

}  // namespace foldproof
