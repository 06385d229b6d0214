/// Every pair of features of a scene, one after the other, and what is true of each.
#pragma once

#include "adversary/truth.h"

namespace foldproof::adversary {

struct Tally {
  std::uint64_t cases = 0, steps = 0, hit_steps = 0, collisions = 0, undecided = 0, served = 0, poses = 0,
                hit_poses = 0, solver_calls = 0, reduced_steps = 0, asked = 0, touching = 0;
  bool operator==(const Tally&) const = default;
};

/// Edges of an object as vertex ids, the smaller first, in order. The library's own list is not asked.
std::vector<Edge> edges_of(const Object& object);

/// Holds the complete answer of a step (not earliest_only) against all pairs: none that comes within the
/// thickness is missing, a hit is within thickness and tolerance at its time and touches nothing before; and
/// the narrow phase says the same of each pair. A complaint, or nothing.
std::string check_step(const Case& c, const Step& step, const StepResult& answer, std::mt19937_64& rng,
                       Tally& tally);

/// The same for the crossings of a pose.
std::string check_pose(const Case& c, const Poses& x, const StepSettings& settings,
                       const StaticResult& answer, Tally& tally);

/// Exactly, but for neighbors that are plainly apart: do two triangles of one object cross?
bool triangles_cross(const Triangle& a, const Triangle& b, std::span<const double> x, Tally& tally);
/// Of triangles that have no vertex in common.
bool triangles_meet(std::span<const Vec3> a, std::span<const Vec3> b, Tally& tally);

inline Vec3 point(std::span<const double> x, Index v) { return {x[3 * v], x[3 * v + 1], x[3 * v + 2]}; }

}  // namespace foldproof::adversary
