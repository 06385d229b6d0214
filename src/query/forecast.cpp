#include "query/forecast.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace foldproof {
namespace {

// Room in the frame, well above its resolution.
constexpr double kLeastInFrame = 0x1p-16;
// What moves less than this, in mean lengths of an edge, stands still.
constexpr double kStill = 0x1p-10;
// Nothing is followed farther than this share of the scene: straight on from there lie poses that will never
// be, where everything meets everything.
constexpr double kFarthest = 0.25;
// What rounding may take from a distance along an axis that is computed in the frame (docs/soundness.md, F1).
constexpr double kRounding = 0x1p-20;
constexpr double kAlongAxis = 0.577;  // less than 1 / sqrt(3)

// About how many microseconds a search takes.
double effort_of(const Work& work, bool ahead) {
  const auto n = [](std::uint64_t count) { return static_cast<double>(count); };
  const double candidates = n(work.candidates_vf + work.candidates_ee);
  return 0.02 * n(work.node_tests) + 0.3 * n(work.certificate_tests) + (ahead ? 3 : 1) * n(work.leaf_pairs) +
         0.03 * candidates;
}

}  // namespace

bool Forecast::same_search(const StepSettings& settings) const {
  return settings.within == settings_.within && settings.between == settings_.between &&
         settings.thickness == settings_.thickness && settings.tolerance == settings_.tolerance &&
         settings.ahead == settings_.ahead && settings.certificates == settings_.certificates &&
         settings.mode == settings_.mode && !settings.explain;
}

bool Forecast::serves(const Scene& scene, Positions x0, Positions x1, const StepSettings& settings,
                      double& side) {
  ahead_ = 1;
  // Shut until the next search is made: an update that fails leaves a motion that nobody searched.
  const bool was_open = std::exchange(open_, false);
  if (!was_open || !same_search(settings) || !scene.fits(x0, x1)) return false;
  const Scene::Course course = scene.course_of(x0, x1);
  float most = course.off;
  for (int end = 0; end < 2; ++end) times_[end] = std::clamp(course.times[end], 0.f, 1.f);
  const double steps = steps_ * course.times[1];
  constexpr float kLate = 1.01f;  // times are rounded; what is later is another step's
  if (steps_ > 1 && most <= room_ && course.times[1] < kLate) {
    const KineticTree::Strayed strayed = scene.stray(x0, x1, times_);
    side = side_of(strayed.bounds);
    most = strayed.bounds.finite ? strayed.most : std::numeric_limits<float>::infinity();
    if (most <= room_ && settings.thickness + tolerance_for(settings, side) <= distance_) {
      outlook_.served(most / edge_, steps);
      open_ = true;
      return true;
    }
  }
  // The same step again, or a part of it, goes nowhere, unless everything stands still.
  const bool stands = course.way < kStill * edge_;
  const bool onwards = steps_ * course.times[0] > 0.5 && course.times[1] > course.times[0];
  const bool again = !stands && !onwards && most <= kRoom * edge_;
  const double sensible = kFarthest * scene.largest_side() * scene.frame().scale / course.stride;
  ahead_ = outlook_.search(most / edge_,
                           again    ? -1
                           : stands ? std::max(steps, 1.0)
                                    : std::max(steps, 0.0),
                           sensible);
  return false;
}

double Forecast::begin(const Scene& scene, const StepSettings& settings, double distance) {
  const double scale = scene.frame().scale, edge = scene.mean_edge();
  open_ = settings.ahead && settings.certificates && settings.mode == Mode::Proven && !settings.explain;
  settings_ = settings;
  edge_ = std::max(edge * scale, 0x1p-20);
  steps_ = scene.ahead();
  distance_ = distance;
  room_ = 0;
  if (scene.ahead() == 1) return distance;
  const double room = std::max(kRoom * edge, kLeastInFrame / scale);
  room_ = static_cast<float>(room * scale * kAlongAxis - kRounding);
  times_[0] = 0;
  times_[1] = static_cast<float>(1 / steps_);
  distance_ = settings.thickness + tolerance_for(settings, scene.reach() + 2 * room);
  const double reach = distance_ + 2 * room;
  reach_ = reach * scale * (1 + 0x1p-40);
  return reach;
}

void Forecast::gather(const NarrowStep& motion, std::span<const LeafPairRef> pairs,
                      std::vector<Chunk>& chunks) {
  meetings_.gather(motion, pairs, reach_, chunks);
}

void Forecast::note_search(const Work& work) { outlook_.took(effort_of(work, steps_ > 1)); }

}  // namespace foldproof
