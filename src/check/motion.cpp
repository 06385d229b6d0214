#include "check/motion.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "base/parallel.h"
#include "base/try.h"

namespace foldproof::internal {
namespace {

// F1: beyond this coordinate, in units of the frame, a search does not look ahead.
constexpr double kMaxExtrapolatedCoordinate = 0x1p28;
// All objects together are cut into about as many subtrees, unless these would be smaller or larger.
constexpr std::size_t kSubtrees = 128, kMinSubtreeLeaves = 16, kMaxSubtreeLeaves = 512;

tl::unexpected<Error> not_finite(Index object, Index vertex, const char* end) {
  return fail(ErrorCode::NonFinite, fmt::format("object {}, vertex {}", object, vertex),
              fmt::format("has a coordinate in {} that is not finite", end), "repair the positions");
}

Result<void> check_vertex(Index object, Index vertex, Positions x0, Positions x1) {
  const Vec3 from = position(x0[object], vertex), to = position(x1[object], vertex);
  if ((to - from).allFinite()) return {};
  if (!from.allFinite()) return not_finite(object, vertex, "x0");
  if (!to.allFinite()) return not_finite(object, vertex, "x1");
  return fail(ErrorCode::NonFinite, fmt::format("object {}, vertex {}", object, vertex),
              "moves so far from x0 to x1 that the difference overflows", "scale the positions down");
}

Result<void> check_vertices(Index object, Positions x0, Positions x1) {
  for (Index v = 0; v < x0[object].size() / 3; ++v) FOLDPROOF_TRY(check_vertex(object, v, x0, x1));
  return {};
}

std::vector<Index> isolated_vertices(const Hierarchy& hierarchy) {
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

StepMotion::StepMotion(std::span<const Object> objects) {
  std::map<const Hierarchy*, std::shared_ptr<const std::vector<Index>>> isolated_of;  // shared by instances
  for (const Object& object : objects) {
    const std::shared_ptr<const Hierarchy>& hierarchy = object.hierarchy();
    first_leaf_.push_back(leaf_count_);
    leaf_count_ += hierarchy->leaf_count();
    auto& isolated = isolated_of[hierarchy.get()];
    if (!isolated) isolated = std::make_shared<const std::vector<Index>>(isolated_vertices(*hierarchy));
    isolated_.push_back(isolated);
    bvhs_.emplace_back(hierarchy);
  }
  leaf_needed_ = std::vector<std::atomic<std::uint8_t>>(leaf_count_);
  const auto max_leaves =
      static_cast<Index>(std::clamp(leaf_count_ / kSubtrees, kMinSubtreeLeaves, kMaxSubtreeLeaves));
  std::map<const Hierarchy*, std::shared_ptr<const Subtrees>> subtrees_of;
  for (const Object& object : objects) {
    auto& subtrees = subtrees_of[object.hierarchy().get()];
    if (!subtrees) subtrees = std::make_shared<const Subtrees>(*object.hierarchy(), max_leaves);
    subtrees_.push_back(subtrees);
  }
}

bool StepMotion::fits(Positions x0, Positions x1) const {
  if (x0.size() != bvhs_.size() || x1.size() != bvhs_.size()) return false;
  for (Index i = 0; i < bvhs_.size(); ++i) {
    const std::size_t expected = 3 * std::size_t{hierarchy(i).topology().vertex_count()};
    if (x0[i].size() != expected || x1[i].size() != expected) return false;
  }
  return true;
}

Result<void> StepMotion::check_sizes(Positions x0, Positions x1) const {
  if (x0.size() != bvhs_.size() || x1.size() != bvhs_.size()) {
    return fail(ErrorCode::InvalidArgument, "positions",
                fmt::format("given for {} and {} objects", x0.size(), x1.size()),
                fmt::format("give them for all {}", bvhs_.size()));
  }
  for (Index i = 0; i < bvhs_.size(); ++i) {
    const std::size_t expected = 3 * std::size_t{hierarchy(i).topology().vertex_count()};
    for (const auto& [end, x] : {std::pair("x0", x0[i]), std::pair("x1", x1[i])}) {
      if (x.size() != expected) {
        return fail(ErrorCode::InvalidArgument, fmt::format("object {}", i),
                    fmt::format("{} has {} numbers", end, x.size()),
                    fmt::format("give {}, three per vertex", expected));
      }
    }
  }
  return {};
}

Result<void> StepMotion::check(Positions x0, Positions x1) const {
  FOLDPROOF_TRY(check_sizes(x0, x1));
  for (Index i = 0; i < bvhs_.size(); ++i) FOLDPROOF_TRY(check_vertices(i, x0, x1));
  return {};
}

Result<void> StepMotion::check_isolated_vertices(Positions x0, Positions x1) const {
  for (Index i = 0; i < bvhs_.size(); ++i) {
    for (const Index v : *isolated_[i]) FOLDPROOF_TRY(check_vertex(i, v, x0, x1));
  }
  return {};
}

Result<void> StepMotion::update(Positions x0, Positions x1, Index steps) {
  FOLDPROOF_TRY(check_sizes(x0, x1));
  FOLDPROOF_TRY(check_isolated_vertices(x0, x1));
  steps_ = steps;
  FOLDPROOF_TRY(read(x0, x1));
  for (KineticBvh& bvh : bvhs_) bvh.refit_boxes();
  return {};
}

double largest_extent(const Bounds& bounds) {
  return std::min(2 * (bounds.high / 2 - bounds.low / 2).maxCoeff(), std::numeric_limits<double>::max());
}

// Reads into the frame of the last step, which is usually this one's as well. Otherwise reads again.
Result<void> StepMotion::read(Positions x0, Positions x1) {
  Bounds step, motion;
  const auto read_object = [&](Index i) {
    if (steps_ > 1) return bvhs_[i].set_extrapolated_positions(frame_, x0[i], x1[i], steps_);
    const Bounds b = bvhs_[i].set_positions(frame_, x0[i], x1[i]);
    return KineticBvh::ExtrapolatedBounds{b, b};
  };
  for (Index i = 0; i < bvhs_.size(); ++i) {
    const KineticBvh::ExtrapolatedBounds bounds = read_object(i);
    if (!bounds.first_step.finite) return check_vertices(i, x0, x1);
    step = united(step, bounds.first_step);
    motion = united(motion, bounds.all_steps);
  }
  if (!motion.low.allFinite() || !motion.high.allFinite()) {
    step_extent_ = motion_extent_ = 0;
    if (steps_ == 1) return {};  // there is no vertex
    steps_ = 1;
    return read(x0, x1);
  }
  step_extent_ = largest_extent(step);
  if (step_extent_ == std::numeric_limits<double>::max()) {  // a difference may overflow
    for (Index i = 0; i < bvhs_.size(); ++i) FOLDPROOF_TRY(check_vertices(i, x0, x1));
  }
  motion_extent_ = largest_extent(motion);
  const Frame frame = frame_around(motion.low, motion.high);
  // Far from the origin the rounding of extrapolated positions would exceed what the slack allows for.
  const double largest = std::max(-motion.low.minCoeff(), motion.high.maxCoeff());
  if (steps_ > 1 && largest * frame.scale > kMaxExtrapolatedCoordinate) {
    steps_ = 1;
    return read(x0, x1);
  }
  if (frame == std::exchange(frame_, frame)) return {};
  for (Index i = 0; i < bvhs_.size(); ++i) read_object(i);
  return {};
}

StepMotion::StepLocation StepMotion::locate(Positions x0, Positions x1) const {
  constexpr std::size_t kMinStride = 61, kMaxSamples = 4096;
  // Of each vertex: its displacement during the motion, and the step's ends, relative to the motion's start.
  const auto for_each_sample = [&](auto visit) {
    for (Index i = 0; i < bvhs_.size(); ++i) {
      const auto ids = hierarchy(i).vertex_ids();
      const std::size_t stride = std::max(kMinStride, ids.size() / kMaxSamples);
      for (std::size_t k = i % stride; k < ids.size(); k += stride) {
        const float* v = bvhs_[i].vertices[k].x;
        const Vec3 origin = Vec3::load(v);
        const Vec3 displacement = Vec3::load(v + 4) - origin;
        const auto relative = [&](std::span<const double> x) {
          return (position(x, ids[k]) - frame_.center) * frame_.scale - origin;
        };
        visit(displacement, relative(x0[i]), relative(x1[i]));
      }
    }
  };
  double square = 0, projection[2] = {0, 0}, motion_displacement = 0, step_displacement = 0;
  for_each_sample([&](const Vec3& displacement, const Vec3& start, const Vec3& end) {
    square += displacement.squaredNorm();
    motion_displacement = std::max(motion_displacement, displacement.cwiseAbs().maxCoeff());
    step_displacement = std::max(step_displacement, (end - start).cwiseAbs().maxCoeff());
    projection[0] += start.dot(displacement);
    projection[1] += end.dot(displacement);
  });
  StepLocation location{
      {0, 0}, 0, static_cast<float>(motion_displacement), static_cast<float>(step_displacement)};
  if (square > 0) {
    for (int e = 0; e < 2; ++e) {
      const double time = projection[e] / square;
      if (std::abs(time) < 0x1p100) location.times[e] = static_cast<float>(time);  // no NaN: F1 needs numbers
    }
  }
  double deviation = 0;
  for_each_sample([&](const Vec3& displacement, const Vec3& start, const Vec3& end) {
    deviation = std::max({deviation, (start - location.times[0] * displacement).cwiseAbs().maxCoeff(),
                          (end - location.times[1] * displacement).cwiseAbs().maxCoeff()});
  });
  location.deviation = static_cast<float>(deviation);
  return location;
}

KineticBvh::Deviation StepMotion::deviation(Positions x0, Positions x1, const float (&times)[2]) const {
  KineticBvh::Deviation all;
  for (Index i = 0; i < bvhs_.size(); ++i) {
    const auto one = bvhs_[i].deviation(frame_, x0[i], x1[i], times);
    all.bounds = united(all.bounds, one.bounds);
    all.max = std::max(all.max, one.max);
  }
  return all;
}

double StepMotion::mean_edge_length() const {
  constexpr std::size_t kMaxSamples = 256;
  std::array<double, kMaxSamples> lengths;
  double min_length = std::numeric_limits<double>::infinity();
  for (const KineticBvh& bvh : bvhs_) {
    const auto edges = bvh.hierarchy->edges();
    double sum = 0;
    std::size_t count = 0;
    for (std::size_t k = 0; k < edges.size(); k += edges.size() / kMaxSamples + 1, ++count) {
      const float *a = bvh.vertices[edges[k][0]].x, *b = bvh.vertices[edges[k][1]].x;
      const float x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
      lengths[count] = std::sqrt(x * x + (y * y + z * z));  // in this order, on which the last digit depends
      sum += lengths[count];
    }
    if (!(sum > 0)) continue;
    const auto quarter = lengths.begin() + static_cast<std::ptrdiff_t>(count / 4);
    std::nth_element(lengths.begin(), quarter, lengths.begin() + static_cast<std::ptrdiff_t>(count));
    const double mean = sum / static_cast<double>(count);
    min_length = std::min(min_length, *quarter > 0 ? std::min(mean, 8 * *quarter) : mean);
  }
  return std::isfinite(min_length) ? min_length / frame_.scale : 0;
}

double StepMotion::swept_extent_ratio() const {
  double at_start = 0, swept = 0;
  for (const KineticBvh& bvh : bvhs_) {
    for (Index leaf = 0; leaf < bvh.hierarchy->leaf_count(); ++leaf) {
      const auto& ends = bvh.boxes[bvh.leaf_node(LeafIndex(leaf))].x;
      for (int axis = 0; axis < 3; ++axis) {
        at_start -= ends[0][0][axis] + ends[0][1][axis];
        swept -= std::min(ends[0][0][axis], ends[1][0][axis]) + std::min(ends[0][1][axis], ends[1][1][axis]);
      }
    }
  }
  return at_start > 0 ? swept / at_start : 1;
}

void StepMotion::fill_features(std::span<const TraversalTask> tasks, std::span<const TaskLeaves> pairs) {
  if (pairs.empty()) return;
  // Threads may mark the same leaf.
  const auto needed = [&](Index object, Index leaf) -> auto& {
    return leaf_needed_[first_leaf_[object] + leaf];
  };
  parallel_for(IndexRange{0, pairs.size()}, 2048, [&](IndexRange range) {
    for (const TaskLeaves& pair : pairs.subspan(range.begin, range.size())) {
      needed(tasks[pair.task].object_a, pair.leaves.a).store(1, std::memory_order_relaxed);
      needed(tasks[pair.task].object_b, pair.leaves.b).store(1, std::memory_order_relaxed);
    }
  });
  parallel_for(IndexRange{0, leaf_count_}, 64, [&](IndexRange range) {
    auto object = static_cast<Index>(std::upper_bound(first_leaf_.begin(), first_leaf_.end(), range.begin) -
                                     first_leaf_.begin());
    for (std::size_t k = range.begin; k < range.end; ++k) {
      while (object < size() && first_leaf_[object] <= k) ++object;
      if (leaf_needed_[k].load(std::memory_order_relaxed) == 0) continue;
      leaf_needed_[k].store(0, std::memory_order_relaxed);
      bvhs_[object - 1].fill_features(LeafIndex(k - first_leaf_[object - 1]));
    }
  });
}

void StretchEnds::interpolate(const StepMotion& motion, const std::array<Positions, 2>& x,
                              const double (&times)[2], const Vec3& drift) {
  for (int end = 0; end < 2; ++end) {
    const double t = times[end];
    auto& spans = end == 0 ? starts_ : ends_;
    spans.clear();
    x_[end].resize(motion.size());
    for (Index i = 0; i < motion.size(); ++i) {
      auto& out = x_[end][i];
      out.resize(x[0][i].size());
      const auto ids = motion.hierarchy(i).vertex_ids();
      parallel_for(IndexRange{0, ids.size()}, 4096, [&](IndexRange range) {
        for (const Index v : ids.subspan(range.begin, range.size())) {
          const Vec3 from = position(x[0][i], v);
          (from + t * ((position(x[1][i], v) - from) - drift)).store(&out[3 * std::size_t{v}]);
        }
      });
      spans.emplace_back(out);
    }
  }
}

}  // namespace foldproof::internal
