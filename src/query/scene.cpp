#include "query/scene.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <cmath>

namespace foldproof {
namespace {

// Tasks per pair of objects; a constant, so that the order of the answer never depends on the threads.
constexpr std::size_t kEnoughTasks = 64;

struct Bounds {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 high = -low;
  bool finite = true;
};

Bounds bounds_of(std::span<const double> x) {
  Bounds b;
  double poison = 0;  // stays zero unless some coordinate is infinite or NaN
  for (std::size_t i = 0; i + 2 < x.size(); i += 3) {
    for (int axis = 0; axis < 3; ++axis) {
      const double c = x[i + axis];
      poison += c * 0;
      b.low[axis] = c < b.low[axis] ? c : b.low[axis];
      b.high[axis] = c > b.high[axis] ? c : b.high[axis];
    }
  }
  b.finite = poison == 0;
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

// y = (x - center) * scale lies in [-1, 1]; halves first, so that the largest doubles do not overflow.
Frame frame_around(const Bounds& b, double& largest_side) {
  Frame frame;
  frame.center = b.low / 2 + b.high / 2;
  const double half = (b.high / 2 - b.low / 2).maxCoeff();
  largest_side = std::min(2 * half, std::numeric_limits<double>::max());
  // The centre is rounded, hence a little room.
  const double reach = half * (1 + 0x1p-50) + frame.center.cwiseAbs().maxCoeff() * 0x1p-52;
  frame.scale = reach > 0 ? std::ldexp(1.0, -std::clamp(std::ilogb(reach) + 1, -1022, 1024)) : 1;
  return frame;
}

}  // namespace

Scene::Scene(std::vector<std::shared_ptr<const Hierarchy>> objects) {
  for (auto& hierarchy : objects) {
    leaf_needed_.emplace_back(hierarchy->leaf_count(), std::uint8_t{0});
    trees_.emplace_back(std::move(hierarchy));
  }
  // Their contents are swapped, so both must have the room from the start.
  front_.reserve(3 * kEnoughTasks);
  below_.reserve(3 * kEnoughTasks);
}

Result<void> Scene::update(Positions x0, Positions x1) {
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
  frame_ = frame_around(all, largest_side_);
  for (std::size_t i = 0; i < trees_.size(); ++i) trees_[i].refit(frame_, x0[i], x1[i]);
  return {};
}

void Scene::start_tasks(const StepSettings& settings, float margin, Work& work) {
  task_count_ = 0;
  const auto add = [&](const TraversalTask& like, NodePair start) -> TraversalTask& {
    if (task_count_ == tasks_.size()) tasks_.emplace_back();
    TraversalTask& task = tasks_[task_count_++];
    task.traversal = like.traversal;
    task.object_a = like.object_a;
    task.object_b = like.object_b;
    task.start = start;
    task.found.leaf_pairs.clear();
    task.found.node_tests = 0;
    return task;
  };
  above_.leaf_pairs.clear();
  above_.node_tests = 0;
  for (Index a = 0; a < trees_.size(); ++a) {
    for (Index b = a; b < trees_.size(); ++b) {
      if (!(a == b ? settings.within : settings.between)) continue;
      const TraversalTask like{{&trees_[a], &trees_[b], margin}, a, b, {}, {}};
      front_.assign(1, {0, 0});
      for (int level = 0; level < 12 && !front_.empty() && front_.size() < kEnoughTasks; ++level) {
        descend_once(like.traversal, front_, below_, above_);
      }
      if (!above_.leaf_pairs.empty()) {
        add(like, {kNoIndex, kNoIndex}).found.leaf_pairs = above_.leaf_pairs;
        above_.leaf_pairs.clear();
      }
      for (const NodePair start : front_) add(like, start);
    }
  }
  work.node_tests += above_.node_tests;
}

void Scene::traverse(const StepSettings& settings, double distance, Work& work) {
  start_tasks(settings, separation_margin(frame_, distance), work);
  tbb::parallel_for(std::size_t{0}, task_count_, [&](std::size_t k) {
    TraversalTask& task = tasks_[k];
    if (task.start.a != kNoIndex)
      foldproof::traverse(task.traversal, task.start, stacks_.local(), task.found);
  });
  leaf_pairs_.clear();
  for (std::size_t k = 0; k < task_count_; ++k) {
    work.node_tests += tasks_[k].found.node_tests;
    for (const NodePair leaves : tasks_[k].found.leaf_pairs)
      leaf_pairs_.push_back({static_cast<Index>(k), leaves});
  }
  work.leaf_pairs += leaf_pairs_.size();
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
