/// Motions in memory, their repair, and what is promised of it.
#pragma once

#include <gtest/gtest.h>

#include <cmath>

#include "contacts/scenes.h"
#include "foldproof/repair.h"

namespace foldproof::oracle {

/// Objects and frames, each frame the positions of all objects one after the other.
struct TestMotion {
  std::vector<Mesh> meshes;
  std::vector<Pose> frames;
  std::vector<std::vector<std::uint8_t>> movable = {};  ///< Per object; none: all may move.
  std::shared_ptr<const PairFilter> filter = nullptr;

  void fix(std::size_t object) {
    movable.resize(meshes.size());
    movable[object].assign(meshes[object].vertex_count, 0);
  }
  std::vector<Object> objects() const {
    std::vector<Object> out;
    std::size_t first = 0;
    for (const Mesh& mesh : meshes) {
      const auto x = std::span(frames[0]).subspan(3 * first, 3 * std::size_t{mesh.vertex_count});
      out.emplace_back(Hierarchy::build(mesh.topology(), x).value());
      first += mesh.vertex_count;
    }
    return out;
  }
  RepairInput input() const {
    RepairInput in;
    const auto all = objects();
    for (std::size_t i = 0; i < all.size(); ++i)
      in.objects.push_back({all[i], movable.empty() ? std::vector<std::uint8_t>() : movable[i]});
    in.frame_count = static_cast<Index>(frames.size());
    in.filter = filter;
    in.read = [this](Index k, std::span<double> x) -> Result<void> {
      std::copy(frames[k].begin(), frames[k].end(), x.begin());
      return {};
    };
    return in;
  }
  std::vector<std::span<const double>> spans(const Pose& x) const {
    std::vector<std::span<const double>> out;
    std::size_t first = 0;
    for (const Mesh& mesh : meshes) {
      out.push_back(std::span(x).subspan(3 * first, 3 * std::size_t{mesh.vertex_count}));
      first += mesh.vertex_count;
    }
    return out;
  }
};

struct Repaired {
  RepairReport report;
  std::vector<double> times;
  std::vector<Pose> frames;

  /// How far a vertex of a frame was moved.
  Vec3 correction(const TestMotion& motion, std::size_t frame, Index vertex) const {
    const auto at = [&](const Pose& x) { return Vec3::load(&x[3 * std::size_t{vertex}]); };
    return at(frames[frame]) - at(motion.frames[frame]);
  }
  double largest(const TestMotion& motion, std::size_t frame, Index begin, Index end) const {
    double largest = 0;
    for (Index v = begin; v < end; ++v) largest = std::max(largest, correction(motion, frame, v).norm());
    return largest;
  }
};

inline Repaired repaired(const TestMotion& motion, const RepairSettings& settings = {}) {
  Repaired out;
  auto report = repair(motion.input(), settings, [&](double time, std::span<const double> x) -> Result<void> {
    out.times.push_back(time);
    out.frames.emplace_back(x.begin(), x.end());
    return {};
  });
  EXPECT_TRUE(report) << report.error().line();
  if (report) out.report = std::move(*report);
  return out;
}

inline std::string error_of(const RepairInput& input, const RepairSettings& settings = {}) {
  const auto report =
      repair(input, settings, [](double, std::span<const double>) -> Result<void> { return {}; });
  return report ? "" : report.error().line();
}

/// How many of the written steps and poses touch, by a checker without any filter.
inline std::size_t touching(const TestMotion& motion, std::span<const Pose> frames, double thickness = 0) {
  StepChecker checker(motion.objects());
  StepSettings settings;
  settings.thickness = thickness;
  StepResult step;
  StaticResult pose;
  std::size_t count = 0;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    EXPECT_TRUE(checker.check_static(motion.spans(frames[k]), {}, pose));
    EXPECT_TRUE(
        checker.check(motion.spans(frames[k == 0 ? 0 : k - 1]), motion.spans(frames[k]), settings, step));
    count += pose.crossing_count + step.count();
  }
  return count;
}

inline void expect_proven(const TestMotion& motion, const Repaired& done, double thickness = 0) {
  EXPECT_TRUE(done.report.free);
  EXPECT_TRUE(done.report.written);
  EXPECT_TRUE(done.report.remaining.empty());
  ASSERT_EQ(done.frames.size(), motion.frames.size());
  EXPECT_EQ(touching(motion, done.frames, thickness), 0u);
}

/// The first of the first mesh's vertices that are farthest along a direction.
inline Index farthest(const TestMotion& motion, const Vec3& direction) {
  const Mesh& ball = motion.meshes[0];
  const auto reach = [&](Index v) { return Vec3::load(&ball.positions[3 * std::size_t{v}]).dot(direction); };
  Index farthest = 0;
  for (Index v = 0; v < ball.vertex_count; ++v) farthest = reach(v) > reach(farthest) ? v : farthest;
  return farthest;
}

/// Where pressed_balls are pressed.
inline const Vec3 kAxis = Vec3(1, 0.3, 0.2).normalized();

/// Two balls of radius 1 that approach along an axis until they are `depth` deep, and part again. `turned`:
/// the second is, so that no edges are parallel.
inline TestMotion pressed_balls(double depth, Index divisions = 12, int steps = 6, bool turned = false,
                                const Vec3& axis = kAxis) {
  TestMotion motion;
  const Mesh ball = unit_sphere(divisions);
  Mesh other = ball;
  for (std::size_t i = 0; i < other.positions.size() && turned; i += 3) {
    const Vec3 p = Vec3::load(&other.positions[i]);
    // By an angle whose cosine is 0.8, about x and then about z.
    const Vec3 q(p.x(), 0.8 * p.y() - 0.6 * p.z(), 0.6 * p.y() + 0.8 * p.z());
    Vec3(0.8 * q.x() - 0.6 * q.y(), 0.6 * q.x() + 0.8 * q.y(), q.z()).store(&other.positions[i]);
  }
  motion.meshes = {ball, other};
  for (int k = -steps; k <= steps; ++k) {
    const double distance = 2 - depth + (0.3 + depth) * std::abs(k) / steps;
    Pose x = ball.positions;
    const Pose there = placed(other, 1, axis * distance);
    x.insert(x.end(), there.begin(), there.end());
    motion.frames.push_back(std::move(x));
  }
  return motion;
}

}  // namespace foldproof::oracle
