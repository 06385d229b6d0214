/// Generated patches, their charts, and motions, for the tests of this module and for tests/search.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "certificate/chart_holds.h"
#include "oracle/families.h"

namespace foldproof::testing {

using oracle::Rng;
using oracle::uniform;

/// Evenly spread orders of magnitude.
double log_uniform(Rng& rng, double low, double high);
// Compilers evaluate arguments in different orders. So that cases are the same everywhere, what draws from
// `rng` is a declaration of its own, or one of these functions.
Vec3 random_direction(Rng& rng);
/// A random direction times a number between these.
Vec3 random_vector(Rng& rng, double low, double high);

/// A patch in a pose. Its vertices are numbered from 0.
struct PosedPatch {
  std::string name;
  Patch patch;
  std::vector<Vec3> x;
};

using Surface = std::function<Vec3(double, double)>;
/// columns x rows cells of two triangles each; `surface` maps (u, v) in [0,1]^2 to a point.
PosedPatch sheet(std::string name, int columns, int rows, const Surface& surface);
/// The triangles for whose numbers `keep` is true, and their vertices.
PosedPatch part_of(const PosedPatch& whole, const std::function<bool(std::size_t)>& keep);

/// Patches that have charts, about half a unit across: flat, bumpy, curved, with a hole, two parts that touch
/// in one vertex, not convex, a long strip, a fan, slivers.
std::vector<PosedPatch> chartable_patches(Rng& rng);

/// The data that chart_holds reads, from a UV map.
struct Chart {
  Chart(const Patch& patch, const UvMap& uv_map);
  ChartView view() const { return {vertices, points, triangles, weights, fit}; }

  std::vector<Index> vertices;
  std::vector<std::array<float, 3>> points;
  std::vector<std::array<std::uint16_t, 3>> triangles;
  std::vector<float> weights;
  ChartLibrary::Fit fit;
};

/// Parametrizer::build for a pose rounded to single precision.
ChartOutcome parametrize(const Patch& patch, std::span<const Vec3> x, UvMap& out);

/// Positions at both ends of a step, and the same in single precision; coordinates in [-1, 1].
struct Step {
  Step(std::vector<Vec3> from, std::vector<Vec3> to);
  std::vector<Vec3> x0, x1;
  std::vector<MovingVertex> vertices;
};

/// A smooth random deformation of size `amplitude` with noise of `roughness` times that.
std::vector<Vec3> deformed(std::span<const Vec3> x, double amplitude, double roughness, Rng& rng);
/// Rotated about the origin by `angle` around a random axis, translated by up to `shift`.
std::vector<Vec3> moved(std::span<const Vec3> x, double angle, double shift, Rng& rng);
/// Centers and scales positions that do not fit into [-1, 1] with a margin.
void fit_into_frame(std::vector<Vec3>& x0, std::vector<Vec3>& x1);

/// A random step of a patch: deformed at both ends, rotated by up to three radians.
Step random_step(const PosedPatch& patch, double amplitude, Rng& rng);

/// Adapts a size so that about half of all tries pass.
class HalfPass {
 public:
  explicit HalfPass(double size) : size_(size) {}
  double size() const { return size_; }
  void record(bool passed) {
    size_ *= passed ? 1.4 : 1 / 1.4;
    ++(passed ? passes_ : failures_);
  }
  double rate() const { return passes_ / (passes_ + failures_); }

 private:
  double size_, passes_ = 0, failures_ = 0;
};

}  // namespace foldproof::testing
