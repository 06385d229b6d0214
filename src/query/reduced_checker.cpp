#include <fmt/format.h>

#include <cmath>

#include "query/reduced_scene.h"

namespace foldproof {

struct ReducedChecker::Impl {
  std::vector<ReducedObject> objects;
  std::vector<KineticTree> trees;
  std::vector<TraversalTask> tasks;  // one per object, one per two objects
  std::vector<LeafPairRef> leaf_pairs;
  std::vector<Chunk> chunks;
  std::vector<NodePair> stack;
  ReducedShape::Scratch scratch;
  std::vector<std::span<const double>> x0, x1;

  void traverse_within(Index object, Index task, double distance, const StepSettings& settings, Work& work);
  void traverse(Index task, NodePair start, double distance, Work& work);
  double bound(Vec3& low, Vec3& high);
};

ReducedChecker::ReducedChecker(std::vector<std::shared_ptr<const ReducedShape>> objects) : impl_(new Impl) {
  for (auto& shape : objects) {
    impl_->trees.emplace_back(shape->motion()->hierarchy());
    impl_->objects.emplace_back(std::move(shape));
  }
  for (Index a = 0; a < impl_->trees.size(); ++a) {
    for (Index b = a; b < impl_->trees.size(); ++b) {
      TraversalTask& task = impl_->tasks.emplace_back();
      task.object_a = a;
      task.object_b = b;
      task.traversal = {&impl_->trees[a], &impl_->trees[b], 0};
    }
  }
}
ReducedChecker::~ReducedChecker() = default;
ReducedChecker::ReducedChecker(ReducedChecker&&) noexcept = default;
ReducedChecker& ReducedChecker::operator=(ReducedChecker&&) noexcept = default;

// The box around everything, from the roots' boxes; gives its largest side.
double ReducedChecker::Impl::bound(Vec3& low, Vec3& high) {
  low = Vec3::Constant(std::numeric_limits<double>::infinity());
  high = -low;
  for (ReducedObject& object : objects) {
    const ReducedBox& box = object.box(0);
    for (int e = 0; e < 2; ++e) {
      low = low.cwiseMin(box.low[e]);
      high = high.cwiseMax(box.high[e]);
    }
  }
  return std::min(2 * (high / 2 - low / 2).maxCoeff(), std::numeric_limits<double>::max());
}

// Follows a pair of nodes down to the pairs of leaves whose boxes are not apart.
void ReducedChecker::Impl::traverse(Index task, NodePair start, double distance, Work& work) {
  ReducedObject &object_a = objects[tasks[task].object_a], &object_b = objects[tasks[task].object_b];
  const bool within = &object_a == &object_b;
  const auto nodes_a = trees[tasks[task].object_a].hierarchy->nodes();
  const auto nodes_b = trees[tasks[task].object_b].hierarchy->nodes();
  stack.assign(1, start);
  while (!stack.empty()) {
    const NodePair pair = stack.back();
    stack.pop_back();
    const Hierarchy::Node &a = nodes_a[pair.a], &b = nodes_b[pair.b];
    ++work.node_tests;
    if (within && pair.a == pair.b) {
      if (a.is_leaf()) {
        leaf_pairs.push_back({task, {a.leaf_begin, a.leaf_begin}});
      } else {
        push_below_self(nodes_a, pair.a, stack);
      }
      continue;
    }
    if (boxes_apart(object_a.box(pair.a), object_b.box(pair.b), distance)) continue;
    if (a.is_leaf() && b.is_leaf()) {
      leaf_pairs.push_back({task, {a.leaf_begin, b.leaf_begin}});
    } else {
      push_below(nodes_a, nodes_b, pair, stack);
    }
  }
}

// Eq. 8 first; what it leaves open goes by boxes.
void ReducedChecker::Impl::traverse_within(Index object, Index task, double distance,
                                           const StepSettings& settings, Work& work) {
  const ReducedShape& shape = objects[object].shape();
  if (!settings.certificates || !objects[object].balls_hold(distance))
    return traverse(task, {0, 0}, distance, work);
  shape.find_open(objects[object].pose(0).p, objects[object].pose(1).p, scratch);
  work.certificate_tests += scratch.visits;
  work.certificate_passes += scratch.visits - scratch.open.size();
  for (const auto& [a, b] : scratch.open) traverse(task, {a, b}, distance, work);
  const auto leaf_node = [&](Index leaf) { return trees[object].leaf_node(leaf); };
  for (const auto& [a, b] : shape.always_open()) traverse(task, {leaf_node(a), leaf_node(b)}, distance, work);
}

Result<void> ReducedChecker::check(std::span<const ReducedPose> begin, std::span<const ReducedPose> end,
                                   const StepSettings& settings, StepResult& out) {
  Stopwatch watch;
  clear(out);
  Impl& m = *impl_;
  if (auto ok = check_settings(settings); !ok) return ok;
  if (begin.size() != m.objects.size() || end.size() != m.objects.size()) {
    return fail("poses", fmt::format("given for {} and {} objects", begin.size(), end.size()),
                fmt::format("give them for all {}", m.objects.size()));
  }
  for (Index i = 0; i < m.objects.size(); ++i) {
    if (auto ok = m.objects[i].begin_step(i, begin[i], end[i]); !ok) return ok;
  }
  if (m.objects.empty()) return {};
  Vec3 low, high;
  const double side = m.bound(low, high);
  if (!low.allFinite() || !high.allFinite())
    return fail("poses", "reach beyond what numbers hold", "make their coordinates smaller");
  out.tolerance = tolerance_for(settings, side);
  out.milliseconds.update = watch.lap();

  const double distance = settings.thickness + out.tolerance;
  const Frame frame = frame_around(low, high);
  m.leaf_pairs.clear();
  for (Index k = 0; k < m.tasks.size(); ++k) {
    const Index a = m.tasks[k].object_a, b = m.tasks[k].object_b;
    m.tasks[k].traversal.margin = separation_margin(frame, distance);
    if (a == b && settings.within) m.traverse_within(a, k, distance, settings, out.work);
    if (a != b && settings.between) m.traverse(k, {0, 0}, distance, out.work);
  }
  for (const LeafPairRef& pair : m.leaf_pairs) {
    const TraversalTask& task = m.tasks[pair.task];
    m.objects[task.object_a].need_leaf(frame, pair.leaves.a, m.trees[task.object_a]);
    m.objects[task.object_b].need_leaf(frame, pair.leaves.b, m.trees[task.object_b]);
  }
  out.work.leaf_pairs = m.leaf_pairs.size();
  out.milliseconds.traverse = watch.lap();
  out.milliseconds.total = out.milliseconds.update + out.milliseconds.traverse;
  if (m.leaf_pairs.empty()) return {};

  m.x0.clear();
  m.x1.clear();
  for (const ReducedObject& object : m.objects) {
    m.x0.push_back(object.positions(0));
    m.x1.push_back(object.positions(1));
  }
  std::atomic<double> earliest{1};
  NarrowStep step{m.trees, m.tasks, m.x0, m.x1, {}, settings.earliest_only ? &earliest : nullptr};
  step.ccd.thickness = settings.thickness;
  step.ccd.tolerance = out.tolerance;
  in_rounds(m.leaf_pairs, m.chunks,
            [&](std::size_t count) { test_round(step, std::span(m.chunks).first(count), watch, out); });
  finish(settings, out);
  out.milliseconds.narrow += watch.lap();
  out.milliseconds.total = out.milliseconds.update + out.milliseconds.traverse + out.milliseconds.narrow;
  return {};
}

}  // namespace foldproof
