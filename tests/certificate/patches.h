/// Generated patches, charts of them, and motions, for the tests of this room and the search.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "certificate/chart_test.h"
#include "oracle/families.h"

namespace foldproof::testing {

using oracle::Rng;

inline double uniform(Rng& rng, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(rng);
}
/// Evenly spread orders of magnitude.
double log_uniform(Rng& rng, double low, double high);
Vec3 random_direction(Rng& rng);

/// A patch in a pose. Its vertices are numbered from 0.
struct PosedPatch {
  std::string name;
  Patch patch;
  std::vector<Vec3> x;
};

using Place3 = std::function<Vec3(double, double)>;
/// columns x rows cells of two triangles each; `place` maps (u, v) in [0,1]^2 to a point.
PosedPatch sheet(std::string name, int columns, int rows, const Place3& place);
/// Keeps the triangles that `keep` wants, by number, and the vertices that these use.
PosedPatch part_of(const PosedPatch& whole, const std::function<bool(std::size_t)>& keep);

/// Patches that can be drawn, about half a unit across: flat, bumpy, curved, with a hole, two parts that
/// touch in one vertex, with a bay, a long strip, a fan, slivers.
std::vector<PosedPatch> drawable_patches(Rng& rng);

/// What chart_holds reads, from a drawing.
struct Chart {
  Chart(const Patch& patch, const Drawing& drawing);
  ChartView view() const { return {vertices, points, triangles, weights, fit}; }

  std::vector<Index> vertices;
  std::vector<std::array<float, 3>> points;
  std::vector<std::array<std::uint16_t, 3>> triangles;
  std::vector<float> weights;
  ChartLibrary::Fit fit;
};

/// As ChartMaker draws a patch in a pose rounded to single precision.
ChartOutcome draw(const Patch& patch, std::span<const Vec3> x, Drawing& out);

/// Ends of a step, and the same in single precision; coordinates in [-1, 1].
struct Step {
  Step(std::vector<Vec3> from, std::vector<Vec3> to);
  std::vector<Vec3> x0, x1;
  std::vector<MovingVertex> vertices;
};

/// A smooth random deformation of size `amplitude` with noise of `roughness` times that.
std::vector<Vec3> deformed(std::span<const Vec3> x, double amplitude, double roughness, Rng& rng);
/// Turned about the origin by `angle` around a random axis, moved by up to `shift`.
std::vector<Vec3> moved(std::span<const Vec3> x, double angle, double shift, Rng& rng);
/// Scaled about its middle so that it fits into [-1, 1] with room to spare, when it does not.
void fit_into_frame(std::vector<Vec3>& x0, std::vector<Vec3>& x1);

/// A random step of a patch: deformed at both ends, turned by up to three radians.
Step random_step(const PosedPatch& patch, double amplitude, Rng& rng);

/// Picks sizes such that about half of all tries pass.
class HalfPass {
 public:
  explicit HalfPass(double size) : size_(size) {}
  double size() const { return size_; }
  void tell(bool passed) {
    size_ *= passed ? 1.4 : 1 / 1.4;
    ++(passed ? passes_ : failures_);
  }
  double rate() const { return passes_ / (passes_ + failures_); }

 private:
  double size_, passes_ = 0, failures_ = 0;
};

}  // namespace foldproof::testing
