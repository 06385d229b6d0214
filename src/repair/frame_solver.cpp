#include "repair/frame_solver.h"

#include <algorithm>
#include <cmath>
#include <queue>
#include <utility>

#include "base/try.h"
#include "repair/poses.h"
#include "solver/pair_distances.h"

namespace foldproof {
namespace {

constexpr double kStiffness = 30;  // of the barrier, in ranges times edges
// A change below `move`, in ranges, is none, nor is one of the energy below `energy`. `linear`: of conjugate
// gradients, in ranges.
struct Tolerances {
  double move, energy, linear;
};
constexpr Tolerances kRough{0.1, 1e-3, 5e-3}, kFine{0.05, 5e-4, 5e-3};
constexpr double kForcing = 0.02;      // LinearTolerance::share
constexpr int kHopelessAfter = 4;      // iterations
constexpr int kMostForAccuracy = 100;  // iterations of Newton's method

Tolerances tolerances_of(const FrameProblem& problem) {
  const Tolerances& t = problem.rough ? kRough : kFine;
  return {t.move * problem.accuracy, t.energy * problem.accuracy, t.linear * problem.accuracy};
}

constexpr double kOverrelaxation = 1.3;  // of steps, as rotations lag behind
constexpr double kNegligible = 0.01;     // a correction below this, in ranges, is none
constexpr double kRescaling = 0.8;       // how far to go towards a collision
constexpr double kReach = 3;             // falloffs along the surface from what is near to what moves
constexpr int kMaxTrials = 8;            // of shares that are limited around what collides
constexpr int kMaxMeritHalvings = 3;
constexpr double kLeastShare = 1e-3;
constexpr double kTight = 0.05;  // a gap below this, in ranges, may need a stiffer barrier
constexpr double kMaxStiffening = 1024;

// When two features on straight ways are closest, but for kTimeStep: of eight times, and around the best
// again. NaN where they are proven to stay farther apart than `farthest`.
constexpr int kRefinements = 3;
constexpr double kTimeStep = 1.0 / 256;
double time_when_closest(bool edges, const FourPoints& from, const FourPoints& to, double farthest) {
  PairBatch batch{};
  NearestBatch nearest;
  double length = 0;  // of the longest relative way
  const std::size_t n = edges ? 2 : 1;
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = n; k < 4; ++k)
      length = std::max(length, ((to[i] - from[i]) - (to[k] - from[k])).norm());
  }
  double time = 0.5, width = 0.5, least = std::numeric_limits<double>::infinity();
  for (int round = 0; round < kRefinements; ++round, width /= 4) {
    const double middle = time;
    const auto time_of = [&](int lane) { return std::clamp(middle + width * (2 * lane - 7) / 8, 0.0, 1.0); };
    for (int lane = 0; lane < 8; ++lane) {
      for (int k = 0; k < 4; ++k) {
        const auto i = static_cast<std::size_t>(k);
        const Vec3 p = from[i] + time_of(lane) * (to[i] - from[i]);
        batch.set(lane, k, p.data(), p.data());
      }
    }
    nearest_points(batch, 8, edges, std::numeric_limits<double>::infinity(), nearest);
    for (int lane = 0; lane < 8; ++lane) {
      if (!(nearest.distance[lane] < least * (1 - 1e-7)))
        continue;  // rounding does not choose between equals
      least = nearest.distance[lane];
      time = time_of(lane);
    }
    if (least - width * length / 8 > farthest) return std::numeric_limits<double>::quiet_NaN();
  }
  return time;
}

}  // namespace

void FrameSolver::round(std::span<double> x) const {
  if (single_precision_) round_to_single(x);
}

// The largest distance of a vertex between two poses.
double FrameSolver::change(std::span<const double> a, std::span<const double> b) const {
  double square = 0;
  for (Index v = 0; v < scene_->vertex_count(); ++v)
    square = std::max(square, (at(a, v) - at(b, v)).squaredNorm());
  return std::sqrt(square);
}

// Vertices that are not active and not yet at the target.
bool FrameSolver::is_late(std::span<const double> x) const {
  for (Index v = 0; v < scene_->vertex_count(); ++v) {
    if (is_active_[v] == 0 && at(x, v) != at(problem_->target, v)) return true;
  }
  return false;
}

CcdResult FrameSolver::ccd(const FeaturePair& pair, std::span<const double> from,
                           std::span<const double> to) const {
  const CcdSettings settings{.thickness = problem_->range.thickness};
  const FourPoints x0 = points_of(from, pair.v), x1 = points_of(to, pair.v);
  return pair.edges ? edge_edge_ccd(x0, x1, settings) : vertex_face_ccd(x0, x1, settings);
}

// How far a pair may go from y to z. At first y is the start, so that its time of impact tells; else neither
// way is that from y, and half is a guess where y to z is free.
double FrameSolver::share_of(const FeaturePair& pair, std::span<const double> z, double toi,
                             bool first) const {
  if (first) return kRescaling * toi;
  const CcdResult from_y = ccd(pair, y_, z);
  return from_y.answer == Answer::Separated ? 0.5 : std::min(kRescaling * from_y.toi, 0.5 + toi / 2);
}

// `is_after`: the collisions are on the step on to the next frame.
void FrameSolver::limit_shares(std::span<const double> z, bool is_after, bool first) {
  std::fill(limit_.begin(), limit_.end(), 1);
  double all = 1;
  for (const auto& [pair, toi] : collisions_) {
    ways_[is_after ? 1 : 0].emplace(pair, 0);
    const double share = share_of(pair, z, toi, first);
    const bool waits =
        std::ranges::all_of(pair.v, [&](Index v) { return scene_->is_movable(v) || at(z, v) == at(y_, v); });
    if (!waits) all = std::min(all, share);  // what may not move would run into it
    for (const Index v : pair.v) {
      if (waits && scene_->is_movable(v)) limit_[v] = std::min(limit_[v], share);
    }
  }
  all_share_ *= all;
  std::vector<Index> limited;
  for (Index v = 0; v < limit_.size(); ++v) {
    if (limit_[v] < 1) limited.push_back(v);
  }
  spread(limited, y_, 2 * falloff_, limit_);  // they grow back to 1, so that nothing is torn
  for (Index v = 0; v < limit_.size(); ++v) {
    if (limit_[v] == 1) continue;
    share_[v] *= limit_[v];
    if (share_[v] < kLeastShare) share_[v] = 0;
    is_active_[v] = 1;
  }
}

// Lowers values of what may move to those of others and their distance along the surface in x, in units.
// Values have changed at `from`.
void FrameSolver::spread(std::span<const Index> from, std::span<const double> x, double unit,
                         std::vector<double>& values) const {
  using Entry = std::pair<double, Index>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  for (const Index v : from) queue.emplace(values[v], v);
  while (!queue.empty()) {
    const auto [value, v] = queue.top();
    queue.pop();
    if (value > values[v]) continue;
    for (const Index u : scene_->neighbors()[v]) {
      const double next = value + (at(x, u) - at(x, v)).norm() / unit;
      if (scene_->is_movable(u) && next < values[u]) queue.emplace(values[u] = next, u);
    }
  }
}

void FrameSolver::place(std::span<const double> whole, std::vector<double>& z) const {
  for (Index v = 0; v < share_.size(); ++v) {
    const double share = share_[v] * all_share_;
    const Vec3 from = at(y_, v), to = at(whole, v);
    put(z, v, share == 1 ? to : from + share * (to - from));
  }
  round(z);
}

// Collisions of the pairs that collided before, and of those that may touch in a pose.
void FrameSolver::test_known(std::span<const double> from, std::span<const double> to, bool is_after) {
  const auto test = [&](const FeaturePair& pair) {
    const CcdResult answer = ccd(pair, from, to);
    if (answer.answer != Answer::Separated) collisions_.push_back({pair, answer.toi});
  };
  for (const auto& way : ways_[is_after ? 1 : 0]) test(way.first);
  for (const FeaturePair& pair : may_touch_) test(pair);
}

// Whether the ways to z and on from it are free; else limits shares. First asks the pairs that are known;
// all, where these do not tell, or to prove it.
Result<bool> FrameSolver::check_ways(std::span<const double> z, bool first, bool proves) {
  const bool knows = pairs_->knows_touching(z);
  may_touch_.clear();
  if (knows) pairs_->may_touch(z, may_touch_);
  for (const bool is_after : {false, true}) {
    const auto other = is_after ? problem_->after : problem_->before;
    if (other.empty()) continue;
    const auto from = is_after ? z : other, to = is_after ? other : z;
    collisions_.clear();
    if (knows) test_known(from, to, is_after);
    if (collisions_.empty() && (proves || !knows)) {
      const StepResult* step = FOLDPROOF_TRY(prover_->check(from, to));
      for (const auto& c : step->vertex_face) collisions_.push_back({scene_->pair_of(c), c.toi});
      for (const auto& c : step->edge_edge) collisions_.push_back({scene_->pair_of(c), c.toi});
    }
    if (collisions_.empty()) continue;
    limit_shares(z, is_after, first && !is_after);
    return false;
  }
  is_proven_ = proves || !knows;
  return true;
}

// Moves z back towards y until the ways are free, as far as it is known, or proven: what collides, and in the
// end all. Returns whether they were before.
Result<bool> FrameSolver::approach(std::vector<double>& z, bool proves) {
  whole_ = z;
  std::fill(share_.begin(), share_.end(), 1);
  all_share_ = 1;
  const bool first = std::equal(y_.begin(), y_.end(), problem_->before.begin(), problem_->before.end());
  for (int trial = 1; all_share_ >= kLeastShare; ++trial) {
    if (FOLDPROOF_TRY(check_ways(z, first, proves))) return trial == 1;
    if (trial >= kMaxTrials) all_share_ /= 2;
    place(whole_, z);
  }
  z = y_;
  is_proven_ = false;
  return false;
}

// Makes y a pose the ways of which are proven, nearer to the last one where they are not free. Returns
// whether they were.
Result<bool> FrameSolver::prove() {
  bool was_free = true;
  if (!is_proven_) {
    next_.swap(y_);
    y_ = proven_;
    was_free = FOLDPROOF_TRY(approach(next_, true));
    y_.swap(next_);
    is_proven_ = true;
    if (!was_free) FOLDPROOF_TRY(find_pairs(y_, pairs_of_y_));
  }
  proven_ = y_;
  return was_free;
}

// Pairs that are near in x, and those that collided on the ways before, at the times when they did.
Result<void> FrameSolver::find_pairs(std::span<const double> x, Pairs& out) {
  FOLDPROOF_TRY(pairs_->find(x, late_ ? std::span<const std::uint8_t>() : is_active_, out.near));
  out.in_pose = out.near.size();
  add_way_pairs(x, out);
  return {};
}

// A pair where it is closest on the way, unless that is at one of its ends, and the share of it.
std::optional<std::pair<FourPoints, double>> FrameSolver::on_way(const FeaturePair& pair, bool is_after,
                                                                 std::span<const double> x) const {
  const FourPoints here = points_of(x, pair.v);
  const FourPoints from = is_after ? here : points_of(problem_->before, pair.v);
  const FourPoints to = is_after ? points_of(problem_->after, pair.v) : here;
  const double time =
      time_when_closest(pair.edges, from, to, problem_->range.range + problem_->range.thickness);
  const double share = is_after ? 1 - time : time;
  if (!(share >= kTimeStep && share <= 1 - kTimeStep)) return std::nullopt;
  FourPoints p;
  for (std::size_t k = 0; k < 4; ++k) p[k] = from[k] + time * (to[k] - from[k]);
  return std::pair(p, share);
}

void FrameSolver::add_way_pairs(std::span<const double> x, Pairs& out) {
  out.near.resize(out.in_pose, NearPair{});
  for (const bool is_after : {false, true}) {
    for (auto& [pair, range] : ways_[is_after ? 1 : 0]) {
      const auto place = on_way(pair, is_after, x);
      if (!place) continue;
      if (range == 0) range = problem_->range.of(pair);
      if (const auto near = near_pair(pair, place->first, range, problem_->range.thickness, place->second))
        out.near.push_back(*near);
    }
  }
}

// Forgets pairs that are far from each other on their way now.
void FrameSolver::forget_far_ways(std::span<const double> x) {
  for (const bool is_after : {false, true})
    std::erase_if(ways_[is_after ? 1 : 0], [&](const auto& way) { return !on_way(way.first, is_after, x); });
}

std::array<std::vector<FeaturePair>, 2> FrameSolver::ways() const {
  std::array<std::vector<FeaturePair>, 2> out;
  for (const std::size_t i : {0, 1}) {
    for (const auto& way : ways_[i]) out[i].push_back(way.first);
  }
  return out;
}

void FrameSolver::set_ways(std::span<const FeaturePair> before, std::span<const FeaturePair> after) {
  ways_ = {};
  for (const FeaturePair& pair : before) ways_[0][pair] = 0;
  for (const FeaturePair& pair : after) ways_[1][pair] = 0;
}

// Vertices whose correction is not negligible.
void FrameSolver::start_active() {
  is_active_.assign(scene_->vertex_count(), 0);
  along_.assign(scene_->vertex_count(), kReach);
  for (Index v = 0; v < is_active_.size(); ++v) {
    if (!scene_->is_movable(v)) continue;
    const double correction = (at(next_, v) - at(problem_->target, v)).norm();
    if (correction > kNegligible * problem_->range.range) {
      is_active_[v] = 1;
    } else {
      put(next_, v, at(problem_->target, v));
    }
  }
}

// Makes active what is near a pair, along the surface.
void FrameSolver::grow_active(std::span<const NearPair> pairs) {
  std::vector<Index> from;
  for (const NearPair& pair : pairs) {
    for (const Index v : pair.vertices) {
      if (std::exchange(along_[v], 0) > 0) from.push_back(v);
    }
  }
  spread(from, problem_->target, falloff_, along_);
  std::vector<Index> active;
  for (Index v = 0; v < is_active_.size(); ++v) {
    if (along_[v] < kReach && scene_->is_movable(v)) is_active_[v] = 1;
    if (is_active_[v] != 0) active.push_back(v);
  }
  if (active.size() != surface_->active().size() ||
      !std::equal(active.begin(), active.end(), surface_->active().begin()))
    surface_->set_active(std::move(active));
}

// Active vertices that no pair holds, nor others along the surface, go to the target at once: it is where
// their energy is least, and the linear solver hardly sees a piece that is merely shifted.
void FrameSolver::release() {
  std::vector<std::uint8_t> held(is_active_.size(), 0);
  std::vector<Index> stack;
  for (const Index v : surface_->active()) {
    if (along_[v] == 0) stack.push_back(v);
  }
  while (!stack.empty()) {
    const Index v = stack.back();
    stack.pop_back();
    if (std::exchange(held[v], 1) != 0) continue;
    for (const Index u : scene_->neighbors()[v]) {
      if (is_active_[u] != 0 && held[u] == 0) stack.push_back(u);
    }
  }
  for (const Index v : surface_->active()) {
    if (held[v] == 0) put(next_, v, at(problem_->target, v));
  }
}

Result<void> FrameSolver::begin(const FrameProblem& problem, std::span<const double> guess) {
  problem_ = &problem;
  limit_.assign(scene_->vertex_count(), 1);
  share_.assign(scene_->vertex_count(), 1);
  y_.assign(problem.begin.begin(), problem.begin.end());
  next_.assign(guess.begin(), guess.end());
  surface_->set_active({});
  pairs_->start(problem.range);
  start_active();
  round(next_);
  FOLDPROOF_TRY(approach(next_, true));
  y_.swap(next_);
  proven_ = y_;
  is_proven_ = true;
  late_ = true;
  forget_far_ways(y_);
  FOLDPROOF_TRY(find_pairs(y_, pairs_of_y_));
  late_ = is_late(y_);
  return {};
}

// Goes from y towards next, less far while that raises the energy. Returns whether it came to its end.
Result<bool> FrameSolver::descend(double stiffness) {
  const double range = problem_->range.range;
  const double wanted = change(y_, next_);
  const Tolerances tolerances = tolerances_of(*problem_);
  for (int halving = 0;; ++halving) {
    FOLDPROOF_TRY(approach(next_, false));
    FOLDPROOF_TRY(find_pairs(next_, pairs_of_next_));
    const bool next_late = is_late(next_);
    if (late_ || next_late) {
      late_ = next_late;
      return false;
    }
    add_way_pairs(y_, pairs_of_y_);
    const double before = surface_->energy(y_, problem_->target, pairs_of_y_.near, stiffness);
    const double after = surface_->energy(next_, problem_->target, pairs_of_next_.near, stiffness);
    if (after > before && halving < kMaxMeritHalvings) {
      for (std::size_t i = 0; i < next_.size(); ++i) next_[i] = y_[i] + (next_[i] - y_[i]) / 2;
      round(next_);
      continue;
    }
    const bool limited = all_share_ < 1 || std::ranges::any_of(share_, [](double s) { return s < 1; });
    return !limited &&
           (wanted < tolerances.move * range || before - after < tolerances.energy * std::abs(after));
  }
}

// One iteration of Newton's method.
Result<void> FrameSolver::iterate(double stiffness, FrameOutcome& outcome) {
  const FrameProblem& problem = *problem_;
  grow_active(pairs_of_y_.near);
  if (surface_->active().empty() && !late_) {
    outcome.settled = true;
    return {};
  }
  surface_->fit_rotations(y_, problem.target);
  next_.resize(y_.size());
  const LinearTolerance tolerance{tolerances_of(problem).linear * problem.range.range,
                                  kForcing * problem.accuracy};
  surface_->minimize(y_, problem.target, pairs_of_y_.near, stiffness, tolerance, next_);
  for (const Index v : surface_->active())
    put(next_, v, at(y_, v) + kOverrelaxation * (at(next_, v) - at(y_, v)));
  release();
  round(next_);
  outcome.wanted = change(y_, next_);
  outcome.settled = FOLDPROOF_TRY(descend(stiffness));
  y_.swap(next_);
  std::swap(pairs_of_y_, pairs_of_next_);
  if (is_proven_) proven_ = y_;
  return {};
}

Result<FrameOutcome> FrameSolver::solve(const FrameProblem& problem, std::vector<double>& x) {
  FOLDPROOF_TRY(begin(problem, x));
  double stiffness = kStiffness * problem.range.range * edge_;
  const double stiffest = kMaxStiffening * stiffness;
  const int most = problem.accuracy < 1 ? kMostForAccuracy : problem.iterations;
  FrameOutcome outcome;
  for (bool ends = false; !ends;) {
    if (interrupted_ && interrupted_())
      return fail(ErrorCode::Interrupted, "repair", "was interrupted", "run it again");
    FOLDPROOF_TRY(iterate(stiffness, outcome));
    ends = ++outcome.iterations >= most ||
           (problem.hopeless > 0 && outcome.iterations > kHopelessAfter && outcome.wanted > problem.hopeless);
    if (ends || outcome.settled) {
      outcome.settled &= FOLDPROOF_TRY(prove());
      ends |= outcome.settled;
    }
    const bool tight =
        std::ranges::any_of(pairs_of_y_.near, [](const NearPair& p) { return p.gap < kTight * p.range; });
    const bool stopped = std::ranges::any_of(share_, [](double s) { return s < 0.5; });
    if (tight && stopped && stiffness < stiffest) stiffness *= 2;
  }
  outcome.arrived = true;
  for (Index v = 0; v < scene_->vertex_count(); ++v)
    outcome.arrived &= scene_->is_movable(v) || at(y_, v) == at(problem.target, v);
  outcome.late = !outcome.settled && outcome.wanted > problem.range.range;
  x = y_;
  return outcome;
}

}  // namespace foldproof
