#include "repair/passes.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "base/try.h"

namespace foldproof {
namespace {

constexpr double kJump = 2;           // a correction that changes by more, in edges, is doubted:
constexpr double kHeldBack = 1;       // a correction of a free frame, in edges
constexpr double kHopeless = 1;       // of changes, in edges, after a few iterations
constexpr double kMaxParts = 8;       // the way is followed in up to so many parts
constexpr double kMuchBetter = 0.25;  // the square of the correction, where that one is taken
constexpr int kIterations = 12, kPartIterations = 4, kRelaxIterations = 8;
constexpr double kSmoothedAway = 1e-3;  // smoothed corrections below this, in clearances, are none

double square_distance(std::span<const double> a, std::span<const double> b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return sum;
}

// The largest distance of a vertex's a1 - a0 from its b1 - b0.
double largest_difference(std::span<const double> a1, std::span<const double> a0, std::span<const double> b1,
                          std::span<const double> b0) {
  double largest = 0;
  for (Index v = 0; v < a1.size() / 3; ++v)
    largest = std::max(largest, ((at(a1, v) - at(a0, v)) - (at(b1, v) - at(b0, v))).norm());
  return largest;
}

}  // namespace

FrameProblem RepairTools::problem(std::span<const double> before, std::span<const double> begin,
                                  std::span<const double> target, std::span<const double> frame,
                                  double time) const {
  const auto& touched = analysis->touched(static_cast<std::size_t>(std::lround(time)));
  FrameProblem out{before, begin, target, BarrierRange{thickness, range, rest, frame, touched}};
  out.accuracy = accuracy;
  out.iterations = kIterations;
  return out;
}

// The target is approached in equal parts, with the correction so far as the first guess. The way that is
// proven begins at `from` in any case.
Result<FrameOutcome> Passes::follow(std::span<const double> from, const Way& way, int parts,
                                    std::vector<double>& x) {
  const auto& [last_target, target, frame, time] = way;
  FrameOutcome outcome;
  x.assign(from.begin(), from.end());
  std::vector<double> before(last_target.begin(), last_target.end()), goal = before, guess;
  tools_.solver->set_ways({}, {});
  for (int part = 1; part <= parts; ++part) {
    for (std::size_t i = 0; i < goal.size(); ++i) {
      goal[i] = part == parts ? target[i] : last_target[i] + (target[i] - last_target[i]) * part / parts;
    }
    guess = x;
    tools_.solver->carry(before, goal, guess);
    FrameProblem problem = tools_.problem(from, x, goal, frame, time);
    problem.rough = rough_ || part < parts;
    if (parts == 1) problem.hopeless = kHopeless * tools_.edge;
    if (part < parts) problem.iterations = kPartIterations;
    outcome = FOLDPROOF_TRY(tools_.solver->solve(problem, guess));
    x.swap(guess);
    before = goal;
  }
  return outcome;
}

// Before corrections are averaged, a frame that is free needs none, unless what it is to go through is in the
// way.
bool Passes::is_held_back(double time, const Correction& correction) const {
  const auto k = static_cast<Index>(time);
  return time == k && tools_.analysis->is_free(k) && correction.largest > kHeldBack * tools_.edge;
}

// From x, the pose at time `from`, to the time `to`; adds frames between where it is late and `halvings`
// allow. False: there is no way.
Result<bool> Passes::advance(double from, double to, std::vector<double>& x, int halvings) {
  const auto last_target = FOLDPROOF_TRY(tools_.frames->at_time(from));
  const auto target = FOLDPROOF_TRY(tools_.frames->at_time(to));
  std::vector<double> next;
  FrameOutcome outcome = FOLDPROOF_TRY(follow(x, {last_target, target, target, to}, 1, next));
  const double jump = largest_difference(next, target, x, last_target) / tools_.edge;
  auto way = tools_.solver->ways()[0];
  if (jump > kJump || !outcome.arrived) {
    std::vector<double> other;
    const int parts = static_cast<int>(outcome.arrived ? std::min(kMaxParts, std::ceil(jump)) : kMaxParts);
    const FrameOutcome of_other = FOLDPROOF_TRY(follow(x, {last_target, target, target, to}, parts, other));
    if (of_other.arrived &&
        (!outcome.arrived || square_distance(other, target) < kMuchBetter * square_distance(next, target))) {
      outcome = of_other;
      next = std::move(other);
      way = tools_.solver->ways()[0];
    }
  }
  if ((!outcome.arrived || outcome.late) && halvings > 0) {
    const double middle = (from + to) / 2;
    std::vector<double> tried = x;
    const std::size_t kept = frames_.size();
    if (FOLDPROOF_TRY(advance(from, middle, tried, halvings - 1)) &&
        FOLDPROOF_TRY(advance(middle, to, tried, halvings - 1))) {
      x = std::move(tried);
      return true;
    }
    frames_.resize(kept);
  }
  if (!outcome.arrived) return false;
  auto correction = Correction::between(target, next);
  const bool held_back = is_held_back(to, correction);
  frames_.push_back({to, std::move(correction), outcome.late, held_back, RepairLimit::None, std::move(way)});
  x = std::move(next);
  return true;
}

Result<void> Passes::sweep(Index from, int direction, std::span<const double> begin) {
  std::vector<double> x(begin.begin(), begin.end());
  const int halvings = static_cast<int>(std::bit_width(in_betweens_ + 1)) - 1;
  bool proven = true;  // x is the end of a way that is free
  for (std::int64_t k = std::int64_t{from} + direction; k >= 0 && k < tools_.frames->count();
       k += direction) {
    const auto now = static_cast<Index>(k), last = static_cast<Index>(k - direction);
    const bool way_free = tools_.analysis->is_way_free(std::max(now, last));
    const auto frame = FOLDPROOF_TRY(tools_.frames->at_time(last));
    const bool moved = x != frame;
    const bool free = way_free && tools_.analysis->is_free(now) && !moved;
    if (!(proven && free) && proven && FOLDPROOF_TRY(advance(last, now, x, halvings))) {
      FOLDPROOF_TRY(tick_());
      continue;
    }
    // The frame as it came in. If it is free, what follows is proven again.
    x = FOLDPROOF_TRY(tools_.frames->at_time(now));
    proven = tools_.analysis->is_free(now);
    frames_.push_back(
        {static_cast<double>(now), {}, false, false, free ? RepairLimit::None : RepairLimit::GivenUp, {}});
    FOLDPROOF_TRY(tick_());
  }
  return {};
}

Result<void> Passes::follow_motion(Index start, std::span<const double> x, bool rough) {
  rough_ = rough;
  frames_.clear();
  auto backwards = sweep(start, -1, x);
  // Ways are to the frame before in time, not in the order in which they were found.
  std::reverse(frames_.begin(), frames_.end());
  const auto frame = FOLDPROOF_TRY(tools_.frames->at_time(start));
  frames_.push_back({static_cast<double>(start), Correction::between(frame, x)});
  for (std::size_t i = frames_.size(); i-- > 1;) {
    frames_[i].way = std::move(frames_[i - 1].way);
  }
  if (!backwards) return backwards;
  FOLDPROOF_TRY(sweep(start, 1, x));
  return close_loop();
}

Result<std::vector<double>> Passes::pose(std::size_t i) {
  std::vector<double> x = FOLDPROOF_TRY(tools_.frames->at_time(frames_[i].time));
  frames_[i].correction.apply(x);
  return x;
}

Result<void> Passes::relax() {
  smooth_.clear();
  for (const SolvedFrame& frame : frames_) smooth_.push_back(frame.correction);
  for (std::size_t i = 0; i < frames_.size(); ++i) {
    FOLDPROOF_TRY(relax_frame(i));
    FOLDPROOF_TRY(tick_());
  }
  return {};
}

// Where the motion ends as it begins, one pose stands for both ends: the one that was moved less, if it fits.
Result<void> Passes::close_loop() {
  const std::size_t last = frames_.size() - 1;
  const auto first_target = FOLDPROOF_TRY(tools_.frames->at_time(0));
  const auto last_target = FOLDPROOF_TRY(tools_.frames->at_time(tools_.frames->count() - 1));
  const bool is_free = frames_[0].limit == RepairLimit::None && frames_[last].limit == RepairLimit::None;
  loops_ = last > 1 && is_free && first_target == last_target;
  if (!loops_ || frames_[0].correction.x == frames_[last].correction.x) return {};
  const auto before = FOLDPROOF_TRY(pose(last - 1)), after = FOLDPROOF_TRY(pose(1));
  const bool first_is_less = frames_[0].correction.largest < frames_[last].correction.largest;
  for (const std::size_t end : {first_is_less ? 0 : last, first_is_less ? last : 0}) {
    const auto x = FOLDPROOF_TRY(pose(end));
    if (!FOLDPROOF_TRY(tools_.solver->is_way_free(before, x)) ||
        !FOLDPROOF_TRY(tools_.solver->is_way_free(x, after)))
      continue;
    frames_[last - end].correction = frames_[end].correction;
    return {};
  }
  loops_ = false;
  return {};
}

// Frame i again, between its neighbors, which stay: near the target with the correction averaged in time.
Result<void> Passes::relax_frame(std::size_t i) {
  const std::size_t end = frames_.size() - 1;
  const bool is_first = i == 0 && !loops_, is_last = i == end && !loops_;
  if (end == 0 || (loops_ && i == end)) return {};
  const std::size_t last = i > 0 ? i - 1 : loops_ ? end - 1 : 1, next = i < end ? i + 1 : last;
  SolvedFrame &solved = frames_[i], &arrives = frames_[i == 0 && loops_ ? end : i];
  for (const std::size_t k : {last, i, next}) {
    if (frames_[k].limit != RepairLimit::None) return {};
  }
  const auto target = FOLDPROOF_TRY(tools_.frames->at_time(solved.time));
  std::vector<double> goal = target;
  add_average(smooth_, i, loops_, kSmoothedAway * tools_.range, goal);
  if (solved.correction.vertices.empty() && goal == target) return {};
  const auto before = FOLDPROOF_TRY(pose(last)), after = FOLDPROOF_TRY(pose(next));
  const std::vector<double> begin = FOLDPROOF_TRY(pose(i));
  FrameProblem problem = tools_.problem(before, begin, goal, target, solved.time);
  if (is_first) problem.before = {};
  if (!is_last) problem.after = after;
  problem.iterations = kRelaxIterations;
  tools_.solver->set_ways(is_first ? std::vector<FeaturePair>() : arrives.way,
                          is_last ? std::vector<FeaturePair>() : frames_[next].way);
  std::vector<double> x = begin;
  const FrameOutcome outcome = FOLDPROOF_TRY(tools_.solver->solve(problem, x));
  auto ways = tools_.solver->ways();
  if (!is_first) arrives.way = std::move(ways[0]);
  if (!is_last) frames_[next].way = std::move(ways[1]);
  solved.correction = Correction::between(target, x);
  solved.late = outcome.late;
  arrives.correction = solved.correction;
  arrives.late = solved.late;
  return {};
}

}  // namespace foldproof
