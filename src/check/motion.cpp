#include "check/motion.h"

#include <fmt/format.h>

#include <cmath>
#include <map>
#include <utility>

#include "base/parallel.h"

namespace foldproof {
namespace {

// F1: the largest coordinate, as a multiple of the frame's unit, up to which a search looks ahead.
constexpr double kFarthestInFrame = 0x1p28;

tl::unexpected<Error> not_finite(Index object, std::size_t vertex, const char* end) {
  return fail(fmt::format("object {}, vertex {}", object, vertex),
              fmt::format("has a coordinate in {} that is not finite", end), "repair the positions");
}

Result<void> check_numbers(Index object, const char* end, std::span<const double> x) {
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (!std::isfinite(x[i])) return not_finite(object, i / 3, end);
  }
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
  std::map<const Hierarchy*, std::shared_ptr<const std::vector<Index>>> isolated_of;  // one for all instances
  for (const Object& object : objects) {
    const std::shared_ptr<const Hierarchy>& hierarchy = object.hierarchy();
    leaf_count_ += hierarchy->leaf_count();
    leaf_needed_.emplace_back(hierarchy->leaf_count(), std::uint8_t{0});
    auto& isolated = isolated_of[hierarchy.get()];
    if (!isolated) isolated = std::make_shared<const std::vector<Index>>(isolated_vertices(*hierarchy));
    isolated_.push_back(isolated);
    trees_.emplace_back(hierarchy);
  }
}

bool StepMotion::fits(Positions x0, Positions x1) const {
  if (x0.size() != trees_.size() || x1.size() != trees_.size()) return false;
  for (Index i = 0; i < trees_.size(); ++i) {
    const std::size_t expected = 3 * std::size_t{hierarchy(i).topology().vertex_count()};
    if (x0[i].size() != expected || x1[i].size() != expected) return false;
  }
  return true;
}

Result<void> StepMotion::check_sizes(Positions x0, Positions x1) const {
  if (x0.size() != trees_.size() || x1.size() != trees_.size()) {
    return fail("positions", fmt::format("given for {} and {} objects", x0.size(), x1.size()),
                fmt::format("give them for all {}", trees_.size()));
  }
  for (Index i = 0; i < trees_.size(); ++i) {
    const std::size_t expected = 3 * std::size_t{hierarchy(i).topology().vertex_count()};
    for (const auto& [end, x] : {std::pair("x0", x0[i]), std::pair("x1", x1[i])}) {
      if (x.size() != expected) {
        return fail(fmt::format("object {}", i), fmt::format("{} has {} numbers", end, x.size()),
                    fmt::format("give {}, three per vertex", expected));
      }
    }
  }
  return {};
}

Result<void> StepMotion::check(Positions x0, Positions x1) const {
  if (auto ok = check_sizes(x0, x1); !ok) return ok;
  for (Index i = 0; i < trees_.size(); ++i) {
    if (auto ok = check_numbers(i, "x0", x0[i]); !ok) return ok;
    if (x1[i].data() == x0[i].data()) continue;
    if (auto ok = check_numbers(i, "x1", x1[i]); !ok) return ok;
  }
  return {};
}

Result<void> StepMotion::check_isolated_vertices(Positions x0, Positions x1) const {
  for (Index i = 0; i < trees_.size(); ++i) {
    for (const Index v : *isolated_[i]) {
      if (!position(x0[i], v).allFinite()) return not_finite(i, v, "x0");
      if (!position(x1[i], v).allFinite()) return not_finite(i, v, "x1");
    }
  }
  return {};
}

Result<void> StepMotion::update(Positions x0, Positions x1, Index ahead) {
  if (auto ok = check_sizes(x0, x1); !ok) return ok;
  if (auto ok = check_isolated_vertices(x0, x1); !ok) return ok;
  ahead_ = ahead;
  if (auto ok = read(x0, x1); !ok) return ok;
  for (KineticTree& tree : trees_) tree.fit();
  return {};
}

double largest_extent(const Bounds& bounds) {
  return std::min(2 * (bounds.high / 2 - bounds.low / 2).maxCoeff(), std::numeric_limits<double>::max());
}

// In the frame of the step before, which mostly is this one's too: then everything is read only once.
Result<void> StepMotion::read(Positions x0, Positions x1) {
  Bounds step, reach;
  const auto move_one = [&](Index i) {
    if (ahead_ > 1) return trees_[i].move_ahead(frame_, x0[i], x1[i], ahead_);
    const Bounds b = trees_[i].move(frame_, x0[i], x1[i]);
    return KineticTree::Ahead{b, b};
  };
  for (Index i = 0; i < trees_.size(); ++i) {
    const KineticTree::Ahead moved = move_one(i);
    if (!moved.step.finite) {
      if (auto ok = check_numbers(i, "x0", x0[i]); !ok) return ok;
      return check_numbers(i, "x1", x1[i]);
    }
    step = around(step, moved.step);
    reach = around(reach, moved.reach);
  }
  if (!reach.low.allFinite() || !reach.high.allFinite()) {
    largest_side_ = reach_ = 0;
    if (ahead_ == 1) return {};  // there is no vertex
    ahead_ = 1;
    return read(x0, x1);
  }
  largest_side_ = largest_extent(step);
  reach_ = largest_extent(reach);
  const Frame frame = frame_around(reach.low, reach.high);
  // Far from the origin rounding of the motion ahead would take more than its slack allows for.
  const double largest = std::max(-reach.low.minCoeff(), reach.high.maxCoeff());
  if (ahead_ > 1 && largest * frame.scale > kFarthestInFrame) {
    ahead_ = 1;
    return read(x0, x1);
  }
  if (frame == std::exchange(frame_, frame)) return {};
  for (Index i = 0; i < trees_.size(); ++i) move_one(i);
  return {};
}

StepMotion::Course StepMotion::course_of(Positions x0, Positions x1) const {
  constexpr std::size_t kEvery = 61;
  using Vector = Eigen::Vector3d;
  const auto visit = [&](auto look) {
    for (Index i = 0; i < trees_.size(); ++i) {
      const auto ids = hierarchy(i).vertex_ids();
      for (std::size_t k = i % kEvery; k < ids.size(); k += kEvery) {
        const float* v = trees_[i].vertices[k].x;
        const Vector from = Eigen::Map<const Eigen::Vector3f>(v).cast<double>();
        const Vector way = Eigen::Map<const Eigen::Vector3f>(v + 4).cast<double>() - from;
        const auto offset = [&](std::span<const double> x) -> Vector {
          return (position(x, ids[k]) - frame_.center) * frame_.scale - from;
        };
        look(way, offset(x0[i]), offset(x1[i]));
      }
    }
  };
  double square = 0, along[2] = {0, 0}, longest = 0, stride = 0;
  visit([&](const Vector& way, const Vector& begin, const Vector& end) {
    square += way.squaredNorm();
    longest = std::max(longest, way.cwiseAbs().maxCoeff());
    stride = std::max(stride, (end - begin).cwiseAbs().maxCoeff());
    along[0] += begin.dot(way);
    along[1] += end.dot(way);
  });
  Course course{{0, 0}, 0, static_cast<float>(longest), static_cast<float>(stride)};
  if (square > 0) {
    for (int e = 0; e < 2; ++e) course.times[e] = static_cast<float>(along[e] / square);
  }
  double off = 0;
  visit([&](const Vector& way, const Vector& begin, const Vector& end) {
    off = std::max({off, (begin - course.times[0] * way).cwiseAbs().maxCoeff(),
                    (end - course.times[1] * way).cwiseAbs().maxCoeff()});
  });
  course.off = static_cast<float>(off);
  return course;
}

KineticTree::Strayed StepMotion::stray(Positions x0, Positions x1, const float (&times)[2]) const {
  KineticTree::Strayed all;
  for (Index i = 0; i < trees_.size(); ++i) {
    const auto one = trees_[i].stray(frame_, x0[i], x1[i], times);
    all.bounds = around(all.bounds, one.bounds);
    all.most = std::max(all.most, one.most);
  }
  return all;
}

double StepMotion::mean_edge() const {
  constexpr std::size_t kLooks = 256;
  double least = std::numeric_limits<double>::infinity();
  for (const KineticTree& tree : trees_) {
    const auto edges = tree.hierarchy->edges();
    double sum = 0;
    std::size_t count = 0;
    for (std::size_t k = 0; k < edges.size(); k += edges.size() / kLooks + 1, ++count) {
      const auto at = [&](Index place) { return Eigen::Map<const Eigen::Vector3f>(tree.vertices[place].x); };
      sum += (at(edges[k][0]) - at(edges[k][1])).norm();
    }
    if (sum > 0) least = std::min(least, sum / static_cast<double>(count));
  }
  return std::isfinite(least) ? least / frame_.scale : 0;
}

double StepMotion::sweep_growth() const {
  double at_begin = 0, swept = 0;
  for (const KineticTree& tree : trees_) {
    for (Index leaf = 0; leaf < tree.hierarchy->leaf_count(); ++leaf) {
      const auto& ends = tree.boxes[tree.leaf_node(leaf)].x;
      for (int axis = 0; axis < 3; ++axis) {
        at_begin -= ends[0][0][axis] + ends[0][1][axis];
        swept -= std::min(ends[0][0][axis], ends[1][0][axis]) + std::min(ends[0][1][axis], ends[1][1][axis]);
      }
    }
  }
  return at_begin > 0 ? swept / at_begin : 1;
}

void StepMotion::fill_features(std::span<const TraversalTask> tasks, std::span<const LeafPairRef> pairs) {
  leaves_to_fill_.clear();
  const auto need = [&](Index object, Index leaf) {
    if (leaf_needed_[object][leaf]) return;
    leaf_needed_[object][leaf] = 1;
    leaves_to_fill_.emplace_back(object, leaf);
  };
  for (const LeafPairRef& pair : pairs) {
    need(tasks[pair.task].object_a, pair.leaves.a);
    need(tasks[pair.task].object_b, pair.leaves.b);
  }
  parallel_for(IndexRange{0, leaves_to_fill_.size()}, 256, [&](IndexRange range) {
    for (std::size_t i = range.begin; i < range.end; ++i) {
      trees_[leaves_to_fill_[i].first].fill_features(leaves_to_fill_[i].second);
    }
  });
  for (const auto& [object, leaf] : leaves_to_fill_) leaf_needed_[object][leaf] = 0;
}

}  // namespace foldproof
