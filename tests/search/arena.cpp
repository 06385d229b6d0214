#include "search/arena.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <set>

#include "foldproof/eigen.h"
#include "oracle/families.h"
#include "oracle/judge.h"

namespace foldproof::search {

using testing::log_uniform;
using testing::random_direction;
using testing::uniform;

namespace {

class ChartCertificate : public Certificate {
 public:
  ChartCertificate(const Patch& patch, const UvMap& uv_map, Honesty honesty)
      : chart_(numbered(patch), uv_map) {
    if (honesty == Honesty::Planted) chart_.triangles.erase(chart_.triangles.begin());
    pairs_ = testing::all_pairs(patch);
  }
  std::span<const FeaturePair> pairs() const override { return pairs_; }
  bool holds(std::span<const MovingVertex> vertices, double gap) override {
    return chart_holds(chart_.view(), vertices, gap, scratch_);
  }

 private:
  static Patch numbered(Patch patch) {
    for (std::size_t v = 0; v < patch.vertices.size(); ++v) patch.vertices[v] = static_cast<Index>(v);
    return patch;
  }
  testing::Chart chart_;
  ChartScratch scratch_;
  std::vector<FeaturePair> pairs_;
};

class PlaneCertificate : public Certificate {
 public:
  PlaneCertificate(const Patch& a, const Patch& b, Honesty honesty) {
    const auto first_b = static_cast<std::uint16_t>(a.vertices.size());
    Patch both = a;
    for (auto t : b.triangles) {
      for (auto& v : t) v = static_cast<std::uint16_t>(v + first_b);
      both.triangles.push_back(t);
    }
    // Only pairs across.
    for (const FeaturePair& pair : testing::all_pairs(both)) {
      const bool vertex_face = pair.kind == oracle::Kind::VertexFace;
      const auto other = pair.vertices[vertex_face ? 1 : 2];
      if ((pair.vertices[0] < first_b) != (other < first_b)) pairs_.push_back(pair);
    }
    for (Index v = 0; v < a.vertices.size() + b.vertices.size(); ++v) (v < first_b ? a_ : b_).push_back(v);
    if (honesty == Honesty::Planted) b_.pop_back();
  }
  std::span<const FeaturePair> pairs() const override { return pairs_; }
  bool holds(std::span<const MovingVertex> vertices, double gap) override {
    return plane_separates(vertices, a_, vertices, b_, gap);
  }

 private:
  std::vector<Index> a_, b_;
  std::vector<FeaturePair> pairs_;
};

}  // namespace

std::unique_ptr<Certificate> chart_certificate(const Patch& patch, const UvMap& uv_map, Honesty honesty) {
  return std::make_unique<ChartCertificate>(patch, uv_map, honesty);
}
std::unique_ptr<Certificate> plane_certificate(const Patch& a, const Patch& b, Honesty honesty) {
  return std::make_unique<PlaneCertificate>(a, b, honesty);
}

void Tally::add(const Tally& other) {
  attacks += other.attacks;
  tries += other.tries;
  accepted += other.accepted;
  asked += other.asked;
  least_ratio = std::min(least_ratio, other.least_ratio);
}

Attack::Attack(Certificate& certificate, const Ground& ground, std::vector<Vec3> x, Rng& rng)
    : certificate_(certificate), ground_(ground), rng_(rng), target_(choose_target(x)) {
  Vec3 low = x[0], high = x[0];
  for (const Vec3& p : x) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  size_ = (high - low).maxCoeff();
  now_.x[0] = x;
  now_.x[1] = std::move(x);
  refit(now_);
}

// Half of the time two features that nearly touch in the mesh: a fold between them is the first thing to go
// wrong.
FeaturePair Attack::choose_target(std::span<const Vec3> x) const {
  const auto pairs = certificate_.pairs();
  FeaturePair best = pairs[rng_() % pairs.size()];
  if (rng_() % 2) return best;
  for (int k = 0; k < 30; ++k) {
    const FeaturePair& other = pairs[rng_() % pairs.size()];
    if (testing::rough_distance(other, x, x) < testing::rough_distance(best, x, x)) best = other;
  }
  return best;
}

// As KineticBvh::refit does it.
void Attack::refit(State& state) const {
  state.vertices.resize(state.x[0].size());
  for (std::size_t v = 0; v < state.vertices.size(); ++v) {
    for (int end = 0; end < 2; ++end) {
      for (int axis = 0; axis < 3; ++axis) {
        state.vertices[v].x[4 * end + axis] =
            static_cast<float>((state.x[end][v][axis] - ground_.frame.center[axis]) * ground_.frame.scale);
      }
      state.vertices[v].x[4 * end + 3] = 0;
    }
  }
  state.distance = distance(state);
}

double Attack::distance(const State& state) const {
  return testing::rough_distance(target_, state.x[0], state.x[1]);
}

// Frames hold everything in [-1, 1].
bool Attack::in_frame(const State& state) const {
  return std::all_of(state.vertices.begin(), state.vertices.end(), [](const MovingVertex& v) {
    return std::all_of(v.x, v.x + 8, [](float c) { return std::abs(c) <= 1; });
  });
}

// A few vertices, at one end or both, by any order of magnitude.
void Attack::move_vertices(State& state) {
  const std::size_t first = rng_() % state.x[0].size(), count = 1 + rng_() % 3;
  const double way = size_ * log_uniform(rng_, 1e-9, 0.5);
  const std::size_t ends = rng_() % 3;
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t v = (first + k * (1 + rng_() % 7)) % state.x[0].size();
    const Vec3 shift = way * random_direction(rng_);
    for (std::size_t end = 0; end < 2; ++end) {
      if (ends == 2 || ends == end) state.x[end][v] += shift;
    }
  }
}

// The pair's features towards each other.
void Attack::move_target(State& state) {
  const bool vertex_face = target_.kind == oracle::Kind::VertexFace;
  const std::size_t end = rng_() % 2;
  FourPoints p = testing::points_of(target_, state.x[end]);
  const Closest closest = vertex_face ? vertex_face_closest(p) : edge_edge_closest(p);
  const Vec3 way = closest.difference * log_uniform(rng_, 1e-4, 2);
  const std::size_t own = vertex_face ? 1 : 2, which = rng_() % 3;
  for (std::size_t k = 0; k < 4; ++k) {
    const bool first = k < own;
    if (which == 2 || (which == 0) == first) state.x[end][target_.vertices[k]] += first ? Vec3(-way) : way;
  }
}

// One end turned, stretched along an axis, sheared or moved as a whole.
void Attack::move_all(State& state) {
  const std::size_t end = rng_() % 2;
  const double how_much = log_uniform(rng_, 1e-6, 3);
  const Eigen::Vector3d axis = to_eigen(random_direction(rng_));
  Eigen::Matrix3d map = Eigen::Matrix3d::Identity();
  switch (rng_() % 4) {
    case 0:
      map = Eigen::AngleAxisd(how_much, axis).toRotationMatrix();
      break;
    case 1:
      map += (std::exp(uniform(rng_, -1, 0.3) * std::min(how_much, 1.0)) - 1) * axis * axis.transpose();
      break;
    case 2:
      map += std::min(how_much, 1.0) * to_eigen(random_direction(rng_)) * axis.transpose();
      break;
    default:
      break;
  }
  const Vec3 middle = state.x[end][rng_() % state.x[end].size()];
  const Vec3 shift = rng_() % 4 ? Vec3::Zero() : size_ * std::min(how_much, 1.0) * random_direction(rng_);
  for (Vec3& p : state.x[end]) p = middle + to_vec3(map * to_eigen(p - middle)) + shift;
}

// To a coarse grid, so that features touch, lie in one plane or lose their area exactly.
void Attack::snap(State& state) {
  const double cell = std::exp2(std::floor(std::log2(size_ * log_uniform(rng_, 1e-7, 0.2))));
  const std::size_t end = rng_() % 2, only = rng_() % state.x[end].size();
  const bool all = rng_() % 4 == 0;
  for (std::size_t v = 0; v < state.x[end].size(); ++v) {
    if (all || v == only) state.x[end][v] = oracle::nearest_multiple(state.x[end][v], cell);
  }
}

void Attack::move(State& state) {
  switch (rng_() % 16) {
    case 0:
    case 1:
      return move_all(state);
    case 2:
      return snap(state);
    case 3:
    case 4:
    case 5:
    case 6:
    case 7:
      return move_target(state);
    default:
      return move_vertices(state);
  }
}

// With no gap asked for, still more than single precision can tell apart.
double Attack::promised_distance() const { return std::max(ground_.gap, 0x1p-24 / ground_.frame.scale); }

// The narrow phase, which is held against the oracle elsewhere, spares the exact answer where it proves the
// pair apart.
std::string Attack::verdict(const State& state, const FeaturePair& pair, Tally& tally) const {
  const FourPoints from = testing::points_of(pair, state.x[0]), to = testing::points_of(pair, state.x[1]);
  CcdSettings settings;
  settings.thickness = ground_.gap;
  if (oracle::narrow_phase(pair.kind, from, to, settings).answer == Answer::Separated) return {};
  ++tally.asked;
  if (!testing::comes_within(pair, state.x[0], state.x[1], ground_.gap)) return {};
  std::string text = "a certificate holds, but this pair comes within the gap:\n";
  text += oracle::describe(pair.kind, from, to, settings);
  text += fmt::format("\nvertices of the pair {} {} {} {}; all vertices, both ends:\n", pair.vertices[0],
                      pair.vertices[1], pair.vertices[2], pair.vertices[3]);
  for (std::size_t v = 0; v < state.x[0].size(); ++v) {
    const Vec3 &p = state.x[0][v], &q = state.x[1][v];
    text += fmt::format("{:a} {:a} {:a}  {:a} {:a} {:a}\n", p[0], p[1], p[2], q[0], q[1], q[2]);
  }
  return text;
}

std::string Attack::look_at_all(const State& state, Tally& tally) const {
  for (const FeaturePair& pair : certificate_.pairs()) {
    if (std::string complaint = verdict(state, pair, tally); !complaint.empty()) return complaint;
  }
  return {};
}

std::string Attack::run(int tries, Tally& tally) {
  const double gap = ground_.gap * ground_.frame.scale * (1 + 0x1p-50);  // as the query asks
  ++tally.attacks;
  if (!in_frame(now_) || !certificate_.holds(now_.vertices, gap)) return {};
  const double start = now_.distance;
  std::uint64_t accepted = 0;
  State next;
  for (int k = 0; k < tries; ++k) {
    next = now_;
    move(next);
    refit(next);
    ++tally.tries;
    const double heat = 0.05 * start * std::pow(1e-6, double(k) / tries);
    if (next.distance > now_.distance + heat * uniform(rng_, 0, 1)) continue;
    if (!in_frame(next) || !certificate_.holds(next.vertices, gap)) continue;
    std::swap(now_, next);
    ++accepted;
    tally.least_ratio = std::min(tally.least_ratio, now_.distance / promised_distance());
    std::string complaint;
    // The pair is looked at wherever doubles leave a doubt, and all pairs from time to time.
    if (now_.distance < 1.001 * promised_distance()) complaint = verdict(now_, target_, tally);
    if (complaint.empty() && accepted % 512 == 0) complaint = look_at_all(now_, tally);
    if (!complaint.empty()) return complaint;
  }
  tally.accepted += accepted;
  return look_at_all(now_, tally);
}

}  // namespace foldproof::search
