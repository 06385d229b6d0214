/// Finds what a certificate excludes: features of a patch without a common vertex that come too close.
#pragma once

#include <string>

#include "certificate/library.h"
#include "oracle/oracle.h"

namespace foldproof::testing {

/// Two features of a patch, by vertex numbers: v f0 f1 f2 or ea0 ea1 eb0 eb1.
struct FeaturePair {
  oracle::Kind kind;
  std::array<std::uint16_t, 4> vertices;
};

/// Every vertex-face and edge-edge pair of a patch without a common vertex.
std::vector<FeaturePair> all_pairs(const Patch& patch);

FourPoints points_of(const FeaturePair& pair, std::span<const Vec3> x);

/// An estimate of how near the pair comes during the step.
double rough_distance(const FeaturePair& pair, std::span<const Vec3> x0, std::span<const Vec3> x1);

/// Whether the pair comes within `gap`, exactly. Counts as no where exact brackets, which end at a relative
/// 2^-24, do not decide.
bool comes_within(const FeaturePair& pair, std::span<const Vec3> x0, std::span<const Vec3> x1, double gap);

/// The first pair that comes within `gap`, with its coordinates; empty where there is none. Skips pairs that
/// the narrow phase separates; other tests compare it with the exact oracle.
std::string find_contact(const Patch& patch, std::span<const Vec3> x0, std::span<const Vec3> x1, double gap);

/// The first two triangles that meet outside of their common vertices and edges; empty where there are none.
/// Exact.
std::string find_crossing(const Patch& patch, std::span<const Vec3> x);

}  // namespace foldproof::testing
