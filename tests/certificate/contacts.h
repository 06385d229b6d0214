/// What a certificate says cannot be: features of a patch, without a common vertex, that come too close.
#pragma once

#include <string>

#include "foldproof/certificate.h"
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

/// How near the pair comes during the step; not exact, for aiming.
double rough_distance(const FeaturePair& pair, std::span<const Vec3> x0, std::span<const Vec3> x1);

/// Exactly: does the pair come as close as `gap` or closer? Undecided by exact brackets, which end at a
/// relative 2^-24, counts as no.
bool comes_within(const FeaturePair& pair, std::span<const Vec3> x0, std::span<const Vec3> x1, double gap);

/// The first pair that comes within `gap`, with its coordinates; empty when there is none. The narrow phase,
/// which is held against the exact oracle elsewhere, leaves out what it proves to be farther apart.
std::string find_contact(const Patch& patch, std::span<const Vec3> x0, std::span<const Vec3> x1, double gap);

/// The first two triangles that have more in common than their common vertices and edges; empty when there
/// are none. Exact.
std::string find_crossing(const Patch& patch, std::span<const Vec3> x);

}  // namespace foldproof::testing
