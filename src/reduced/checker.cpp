#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "check/answer.h"
#include "check/pipeline.h"
#include "reduced/object.h"

namespace foldproof {
namespace {

// With more unproven pairs of nodes, or more pairs of boxes to test, per leaf it takes less time to compute
// all of an object's vertices.
constexpr std::size_t kMaxUnprovenPerLeaf = 2, kMaxTestsPerLeaf = 8;

}  // namespace

struct ReducedChecker::Impl {
  std::vector<ReducedObject> objects;
  std::vector<foldproof::Object> meshes;             // the same objects, for checks of their vertices
  std::vector<std::unique_ptr<Pipeline>> pipelines;  // per object; null until all of its vertices were needed
  std::vector<KineticBvh> bvhs;
  std::vector<TraversalTask> tasks;  // one per object, then one per two objects near each other
  SweepAndPrune sweep;
  std::vector<SweptBox> object_boxes;
  std::vector<TaskLeaves> leaf_pairs;
  NarrowScratch narrow;
  std::vector<NodePair> stack;
  ReducedShape::Scratch scratch;
  std::vector<std::span<const double>> x0, x1;

  explicit Impl(const std::vector<ReducedChecker::Object>& given);
  Result<void> check(std::span<const ReducedPose> start, std::span<const ReducedPose> end,
                     const StepSettings& settings, StepResult& out);
  Result<void> start_step(std::span<const ReducedPose> start, std::span<const ReducedPose> end);
  bool traverse_balls(Index object, Index task, double distance, Work& work);
  Result<void> traverse_vertices(Index task, double distance, const StepSettings& settings, Work& work);
  Result<void> traverse_within(Index task, double distance, const StepSettings& settings, Work& work);
  void traverse_between(Index task, double distance, Work& work);
  Result<void> traverse_objects(const Frame& frame, double distance, const StepSettings& settings,
                                Work& work);
  bool traverse(Index task, NodePair start, double distance, std::uint64_t test_limit, Work& work);
  std::uint64_t max_tests(Index task) const;
  void compute_features(const Frame& frame, double distance);
  Bounds bound();
};

ReducedChecker::Impl::Impl(const std::vector<ReducedChecker::Object>& given) {
  pipelines.resize(given.size());
  for (const ReducedChecker::Object& object : given) {
    const std::shared_ptr<const Hierarchy>& hierarchy = object.shape->motion()->hierarchy();
    bvhs.emplace_back(hierarchy);
    meshes.push_back(object.charts ? foldproof::Object(object.charts) : hierarchy);
    objects.emplace_back(object.shape);
  }
}

ReducedChecker::ReducedChecker(std::vector<Object> objects)
    : objects_(std::move(objects)), impl_(new Impl(objects_)) {}
ReducedChecker::~ReducedChecker() = default;
ReducedChecker::ReducedChecker(ReducedChecker&&) noexcept = default;
ReducedChecker& ReducedChecker::operator=(ReducedChecker&&) noexcept = default;

// The box around everything. Stores the boxes of the roots in object_boxes.
Bounds ReducedChecker::Impl::bound() {
  Bounds all;
  object_boxes.clear();
  for (ReducedObject& object : objects) {
    const ReducedBox& root = object.box(0);
    const Vec3 low = root.low[0].cwiseMin(root.low[1]), high = root.high[0].cwiseMax(root.high[1]);
    SweptBox& box = object_boxes.emplace_back();
    low.store(box.low.data());
    high.store(box.high.data());
    all = united(all, {low, high, low.allFinite() && high.allFinite()});
  }
  return all;
}

std::uint64_t ReducedChecker::Impl::max_tests(Index task) const {
  const auto leaves = [&](Index object) { return bvhs[object].hierarchy->leaf_count(); };
  return kMaxTestsPerLeaf * (std::uint64_t{leaves(tasks[task].object_a)} + leaves(tasks[task].object_b)) / 2;
}

// Descends from a pair of nodes to the pairs of leaves whose boxes are not separated. Gives up and returns
// false once work.node_tests exceeds the limit.
bool ReducedChecker::Impl::traverse(Index task, NodePair start, double distance, std::uint64_t test_limit,
                                    Work& work) {
  ReducedObject &object_a = objects[tasks[task].object_a], &object_b = objects[tasks[task].object_b];
  const NodePairs nodes = tasks[task].traversal.nodes();
  stack.assign(1, start);
  traverse_pairs(nodes, stack, [&](NodePair pair) {
    if (++work.node_tests > test_limit) {
      stack.clear();
      return false;
    }
    if (!nodes.is_self(pair) && boxes_separated(object_a.box(pair.a), object_b.box(pair.b), distance))
      return false;
    if (!nodes.are_leaves(pair)) return true;
    leaf_pairs.push_back({task, nodes.leaves(pair)});
    return false;
  });
  return work.node_tests <= test_limit;
}

// Eq. 8 first, then boxes for the pairs that it leaves unproven. Gives up and returns false when these are
// too many.
bool ReducedChecker::Impl::traverse_balls(Index object, Index task, double distance, Work& work) {
  const ReducedShape& shape = objects[object].shape();
  const std::size_t max_unproven = kMaxUnprovenPerLeaf * std::size_t{bvhs[object].hierarchy->leaf_count()};
  shape.impl().find_unproven(objects[object].pose(0).p, objects[object].pose(1).p, max_unproven, scratch);
  work.certificate_tests += scratch.visited;
  work.certificate_passes += scratch.proven;
  if (scratch.unproven.size() > max_unproven) return false;
  const std::uint64_t test_limit = work.node_tests + max_tests(task);
  for (const auto& [a, b] : scratch.unproven) {
    if (!traverse(task, {NodeIndex(a), NodeIndex(b)}, distance, test_limit, work)) return false;
  }
  // Where no center is near, the pair of the roots is listed, which has all leaves below it.
  if (!scratch.unproven.empty() && scratch.unproven.front() == std::array<Index, 2>{0, 0}) return true;
  for (const auto& [a, b] : shape.never_certified()) {
    const NodePair leaves{bvhs[object].leaf_node(LeafIndex(a)), bvhs[object].leaf_node(LeafIndex(b))};
    if (!traverse(task, leaves, distance, test_limit, work)) return false;
  }
  return true;
}

// As StepChecker does it, charts and planes included. The features of these pairs are in the pipeline's BVH.
Result<void> ReducedChecker::Impl::traverse_vertices(Index task, double distance,
                                                     const StepSettings& settings, Work& work) {
  const Index object = tasks[task].object_a;
  objects[object].compute_all();
  std::unique_ptr<Pipeline>& pipeline = pipelines[object];
  if (!pipeline) pipeline = std::make_unique<Pipeline>(std::span(&meshes[object], 1));
  const std::span<const double> x0[] = {objects[object].positions(0)}, x1[] = {objects[object].positions(1)};
  const StepSettings within{.between = false, .certificates = settings.certificates};
  FOLDPROOF_TRY(pipeline->motion.update(x0, x1));
  ++work.refits;
  FOLDPROOF_TRY(pipeline->find_leaf_pairs(within, distance, work));
  for (const TaskLeaves& pair : pipeline->broad_phase.leaf_pairs()) {
    tasks[task].traversal = pipeline->broad_phase.tasks()[pair.task].traversal;
    leaf_pairs.push_back({task, pair.leaves});
  }
  return {};
}

Result<void> ReducedChecker::Impl::traverse_within(Index task, double distance, const StepSettings& settings,
                                                   Work& work) {
  const Index object = tasks[task].object_a;
  const std::size_t before = leaf_pairs.size();
  const bool by_balls = settings.certificates && objects[object].balls_apply(distance);
  if (by_balls ? traverse_balls(object, task, distance, work)
               : traverse(task, {}, distance, work.node_tests + max_tests(task), work))
    return {};
  leaf_pairs.resize(before);
  return traverse_vertices(task, distance, settings, work);
}

void ReducedChecker::Impl::traverse_between(Index task, double distance, Work& work) {
  const std::size_t before = leaf_pairs.size();
  if (traverse(task, {}, distance, work.node_tests + max_tests(task), work)) return;
  leaf_pairs.resize(before);
  objects[tasks[task].object_a].compute_all();
  objects[tasks[task].object_b].compute_all();
  traverse(task, {}, distance, std::numeric_limits<std::uint64_t>::max(), work);
}

Result<void> ReducedChecker::Impl::traverse_objects(const Frame& frame, double distance,
                                                    const StepSettings& settings, Work& work) {
  const auto near =
      settings.between ? sweep.pairs(object_boxes, distance) : std::span<const SweepAndPrune::Pair>{};
  const std::size_t count = objects.size() + near.size();
  if (tasks.size() < count) tasks.resize(count);
  for (Index k = 0; k < count; ++k) {
    const auto [a, b] = k < objects.size() ? SweepAndPrune::Pair{k, k} : near[k - objects.size()];
    tasks[k].object_a = a;
    tasks[k].object_b = b;
    tasks[k].traversal = {&bvhs[a], &bvhs[b], separation_margin(frame, distance)};
    if (a != b) {
      traverse_between(k, distance, work);
    } else if (settings.within) {
      FOLDPROOF_TRY(traverse_within(k, distance, settings, work));
    }
  }
  return {};
}

// Drops pairs of leaves whose boxes are separated once their vertices are known.
void ReducedChecker::Impl::compute_features(const Frame& frame, double distance) {
  const auto is_in_pipeline = [&](const TaskLeaves& pair) {
    return tasks[pair.task].traversal.a != &bvhs[tasks[pair.task].object_a];
  };
  const auto is_separated = [&](const TaskLeaves& pair) {
    if (is_in_pipeline(pair)) return false;
    const Index a = tasks[pair.task].object_a, b = tasks[pair.task].object_b;
    objects[a].compute_leaf(frame, pair.leaves.a, bvhs[a]);
    objects[b].compute_leaf(frame, pair.leaves.b, bvhs[b]);
    return boxes_separated(objects[a].box(bvhs[a].leaf_node(pair.leaves.a)),
                           objects[b].box(bvhs[b].leaf_node(pair.leaves.b)), distance);
  };
  leaf_pairs.erase(std::remove_if(leaf_pairs.begin(), leaf_pairs.end(), is_separated), leaf_pairs.end());
  for (const TaskLeaves& pair : leaf_pairs) {
    if (is_in_pipeline(pair)) continue;
    const Index a = tasks[pair.task].object_a, b = tasks[pair.task].object_b;
    objects[a].compute_features(pair.leaves.a, bvhs[a]);
    objects[b].compute_features(pair.leaves.b, bvhs[b]);
  }
}

Result<void> ReducedChecker::check(std::span<const ReducedPose> start, std::span<const ReducedPose> end,
                                   const StepSettings& settings, StepResult& out) {
  out.complete = false;
  auto done = run_on(
      impl_, [&] { return std::make_unique<Impl>(objects_); },
      [&](Impl& impl) { return impl.check(start, end, settings, out); });
  out.complete = done.has_value();
  return done;
}

Result<void> ReducedChecker::Impl::start_step(std::span<const ReducedPose> start,
                                              std::span<const ReducedPose> end) {
  if (start.size() != objects.size() || end.size() != objects.size()) {
    return fail(ErrorCode::InvalidArgument, "poses",
                fmt::format("are given for {} and {} objects", start.size(), end.size()),
                fmt::format("give them for all {}", objects.size()));
  }
  for (Index i = 0; i < objects.size(); ++i) {
    if (meshes[i].hierarchy() != bvhs[i].hierarchy)
      return fail(ErrorCode::InvalidArgument, fmt::format("object {}", i),
                  "has charts of another hierarchy than its shape's",
                  "build the shape with the hierarchy that the charts were trained with");
    FOLDPROOF_TRY(objects[i].start_step(i, start[i], end[i]));
  }
  return {};
}

Result<void> ReducedChecker::Impl::check(std::span<const ReducedPose> start, std::span<const ReducedPose> end,
                                         const StepSettings& settings, StepResult& out) {
  clear(out);
  FOLDPROOF_TRY(check_settings(settings, objects.size()));
  Bounds bounds;
  const auto update = [&]() -> Result<void> {
    FOLDPROOF_TRY(start_step(start, end));
    bounds = bound();
    if (!bounds.finite && !objects.empty())
      return fail(ErrorCode::LimitExceeded, "poses", "have positions beyond the range of double",
                  "make their coordinates smaller");
    return {};
  };
  const auto search = [&]() -> Result<void> {
    leaf_pairs.clear();
    if (objects.empty()) return {};
    out.tolerance = tolerance_for(settings, largest_extent(bounds));
    const double distance = settings.thickness + out.tolerance;
    const Frame frame = frame_around(bounds.low, bounds.high);
    FOLDPROOF_TRY(traverse_objects(frame, distance, settings, out.work));
    compute_features(frame, distance);
    out.work.leaf_pairs = leaf_pairs.size();
    return {};
  };
  const auto test = [&]() -> Result<void> {
    if (leaf_pairs.empty()) return {};
    x0.clear();
    x1.clear();
    for (const ReducedObject& object : objects) {
      x0.push_back(object.positions(0));
      x1.push_back(object.positions(1));
    }
    test_leaf_pairs({settings, out.tolerance, bvhs, tasks, x0, x1}, leaf_pairs, narrow, out);
    finish(settings, out);
    return {};
  };
  return run_stages(out.milliseconds, update, search, test);
}

}  // namespace foldproof
