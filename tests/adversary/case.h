/// A small scene that moves in steps, as plain data: whatever goes wrong with it can be cut down and printed.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "adversary/source.h"
#include "foldproof/check.h"

namespace foldproof::adversary {

using Pose = std::vector<double>;  ///< Three numbers per vertex.
using Poses = std::vector<Pose>;   ///< One per object.

struct Object {
  Index vertex_count = 0;
  std::vector<Triangle> triangles;
  Index leaf_triangles = 12;
};

struct Step {
  Poses x0, x1;
  StepSettings settings;
  /// Bits: what is compared in this step besides the step itself.
  unsigned checks = 0;
};

/// Of Step::checks.
enum Check : unsigned {
  kTargets = 1,    ///< every instruction set
  kOrder = 2,      ///< objects the other way round
  kThreads = 4,    ///< one thread and several
  kLeaves = 8,     ///< leaves of another size
  kPose = 16,      ///< static queries of both ends
  kSolver = 32,    ///< all calls of a ContactChecker
  kFailure = 64,   ///< a call that fails, before the step
  kSearches = 128  ///< a checker that does not look ahead, one without certificates
};

struct Case {
  std::vector<Object> objects;
  std::vector<Step> steps;
  std::uint64_t seed = 0;  ///< Of choices that need not be cut down.
};

/// Each coordinate from -1 to 1.
Vec3 random_vector(Source& source);

/// The generator: parts that differ in size, height and distance by up to a million, in motion.
Case make_case(Source& source);

/// Both ends of all steps and the triangles, to be read and pasted.
std::string describe(const Case& c);

}  // namespace foldproof::adversary
