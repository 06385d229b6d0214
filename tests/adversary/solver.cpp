#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <set>

#include "adversary/run.h"
#include "oracle/brute_force.h"
#include "solver/soups.h"

namespace foldproof::adversary {
namespace {

using oracle::FeaturePair;
using oracle::Soup;

Pose joined(const Poses& poses) {
  Pose all;
  for (const Pose& pose : poses) all.insert(all.end(), pose.begin(), pose.end());
  return all;
}

double largest_side(std::span<const double> x0, std::span<const double> x1) {
  double side = 0;
  for (int axis = 0; axis < 3; ++axis) {
    double low = x0[axis], high = low;
    for (const auto x : {x0, x1}) {
      for (std::size_t i = axis; i < x.size(); i += 3) {
        low = std::min(low, x[i]);
        high = std::max(high, x[i]);
      }
    }
    side = std::max(side, high - low);
  }
  return side;
}

Pose corners(const FourPoints& points) {
  Pose all;
  for (const Vec3& p : points) all.insert(all.end(), p.data(), p.data() + 3);
  return all;
}

// More than the tolerance that a solver's query chooses for the pair itself, unless the settings say more.
double largest_tolerance(const Features& pair, double distance) {
  const Pose x0 = corners(pair.x0), x1 = corners(pair.x1);
  return 0x1p-29 * largest_side(x0, x0) + 0x1p-43 * largest_side(x0, x1) + 0x1p-40 * distance + 0x1p-1050;
}

}  // namespace

struct SolverCheck::Impl {
  Soup soup;
  std::vector<FeaturePair> pairs;
  std::vector<std::vector<Index>> elements;
  std::optional<ContactChecker> checker;
  double least_tolerance = 0;  // of its settings
  Candidates found;

  Features moving(const FeaturePair& pair, const Pose& x0, const Pose& x1) const {
    return {pair.kind(), pair.at(x0), pair.at(x1)};
  }

  // A pair that comes within the distance; asks for few that are near.
  const FeaturePair* contact(const Pose& x0, const Pose& x1, double distance, int most, Tally& tally) const {
    for (const FeaturePair& pair : pairs) {
      const Features moving_pair = moving(pair, x0, x1);
      if (surely_beyond(moving_pair, distance)) continue;
      if (--most < 0) return nullptr;
      ++tally.asked;
      if (comes_within(moving_pair, distance)) return &pair;
    }
    return nullptr;
  }
  // `times` the tolerance counts too.
  bool all_beyond(const Pose& x0, const Pose& x1, double distance, double times = 0) const {
    return std::all_of(pairs.begin(), pairs.end(), [&](const FeaturePair& pair) {
      const Features of = moving(pair, x0, x1);
      const double tolerance = std::max(largest_tolerance(of, distance), 2 * least_tolerance);
      return surely_beyond(of, distance + times * tolerance);
    });
  }

  std::string steps(const Pose& x0, const Pose& x1, double distance, Tally& tally);
  std::string candidates(const Pose& x0, const Pose& x1, double inflation, Tally& tally);
  std::string close_pairs(const Pose& x, double distance, Tally& tally);
  std::string candidates_going_on(Pose x0, Pose x1, double inflation, std::mt19937_64& rng, Tally& tally);
  std::string intersections(const Pose& x, Tally& tally);
  std::string min_distance(const Pose& x, double bound, Tally& tally);
};

SolverCheck::~SolverCheck() = default;

SolverCheck::SolverCheck(const Case& c, std::mt19937_64& rng) : impl_(new Impl) {
  Soup& soup = impl_->soup;
  soup.x0 = joined(c.steps[0].x0);
  Index first = 0;
  // Some triangles become edges without a face, and some leave points alone: few, or every other one.
  const std::uint64_t one_in = rng() % 2 == 0 ? 8 : 2;
  for (const Object& o : c.objects) {
    for (const Triangle& t : o.triangles) {
      const bool proper = t[0] != t[1] && t[1] != t[2] && t[0] != t[2];
      if (proper && rng() % one_in != 0) {
        soup.faces.push_back({first + t[0], first + t[1], first + t[2]});
      } else if (t[0] != t[1] && rng() % 3 != 0) {
        const Index from = first + t[0], to = first + t[1];
        soup.edges.push_back({std::min(from, to), std::max(from, to)});
      }
    }
    first += o.vertex_count;
  }
  std::sort(soup.edges.begin(), soup.edges.end());
  soup.edges.erase(std::unique(soup.edges.begin(), soup.edges.end()), soup.edges.end());
  const CollisionMesh mesh = oracle::mesh_of(soup, {}, c.objects[0].leaf_triangles);
  impl_->pairs = oracle::all_pairs(soup, mesh.edges(), oracle::all_may);
  for (const Triangle& t : mesh.faces()) impl_->elements.push_back({t.begin(), t.end()});
  for (const Index e : mesh.codim_edges())
    impl_->elements.push_back({mesh.edges()[e].begin(), mesh.edges()[e].end()});
  for (const Index v : mesh.codim_points()) impl_->elements.push_back({v});
  impl_->checker.emplace(std::make_shared<const CollisionMesh>(mesh));
}

std::string SolverCheck::Impl::steps(const Pose& x0, const Pose& x1, double distance, Tally& tally) {
  now_asking("is_step_collision_free");
  const auto free = checker->is_step_collision_free(x0, x1, distance);
  if (free.is_error()) return "is_step_collision_free is refused: " + free.error().line();
  const std::uint64_t undecided = checker->work().undecided;
  tally.undecided += undecided;
  constexpr int kMost = 8;
  const FeaturePair* pair = contact(x0, x1, distance, kMost, tally);
  if (free.is_yes() && pair != nullptr)
    return "is_step_collision_free says so, but this pair comes into contact:\n" +
           describe(moving(*pair, x0, x1));
  if (free.is_no() && pair == nullptr && undecided == 0 && all_beyond(x0, x1, distance, 1))
    return "is_step_collision_free says no, but all pairs stay beyond the distance and the tolerance";

  now_asking("collision_free_step_size");
  const auto size = checker->collision_free_step_size(x0, x1, distance);
  if (!size) return "collision_free_step_size is refused: " + size.error().line();
  const double share = size->share;
  if (!(share >= 0 && share <= 1)) return fmt::format("the step size {} is not in [0,1]", share);
  const bool contact_or_undecided =
      size->limit == StepSize::Limit::Contact || size->limit == StepSize::Limit::Undecided;
  if ((share == 1) != free.is_yes() || (share == 1) != (size->limit == StepSize::Limit::None) ||
      (share > 0 && share < 1 && !contact_or_undecided) ||
      (share == 0 && size->limit == StepSize::Limit::Contact))
    return fmt::format("the step size is {:a}, its limit {}, but collision-free is {}", share,
                       kStepLimitNames[static_cast<std::size_t>(size->limit)], free.is_yes());
  if (share == 0 && undecided == 0 && checker->work().undecided == 0) {
    return all_beyond(x0, x0, 0, 2) && distance == 0 && !contact(x0, x1, 0, kMost, tally)
               ? "the step size is 0 where nothing is near"
               : "";
  }
  if (share == 0) return {};
  Pose reached(x0.size());
  step_towards(x0, x1, share, reached);
  pair = contact(x0, reached, distance, kMost, tally);
  if (pair == nullptr) return {};
  return fmt::format("the step size is {:a}, and on the way there this pair comes into contact:\n{}", share,
                     describe(moving(*pair, x0, reached)));
}

std::string SolverCheck::Impl::candidates(const Pose& x0, const Pose& x1, double inflation, Tally& tally) {
  now_asking("candidates");
  if (const auto done = checker->candidates(x0, x1, inflation, found); !done)
    return "candidates are refused: " + done.error().line();
  const auto keys = oracle::keys_of(found);
  if (keys.size() != found.size()) return "a candidate is listed twice";
  int most = inflation == 0 ? 8 : 3;
  std::size_t known = 0;
  for (const FeaturePair& pair : pairs) {
    const bool listed = keys.contains(pair.key());
    known += listed;
    const Features both = moving(pair, x0, x1);
    if (listed != oracle::boxes_within(pair, x0, x1, inflation))
      return fmt::format("{} the candidates, against what its boxes say with {:a}:\n{}",
                         listed ? "among" : "not among", inflation, describe(both));
    if (listed || surely_beyond(both, inflation) || --most < 0) continue;
    ++tally.asked;
    if (comes_within(both, inflation))
      return fmt::format("not among the candidates, but within {:a}:\n{}", inflation, describe(both));
  }
  return known == keys.size() ? "" : "a candidate is no pair that counts";
}

// A pair that is not listed by any of its features is farther away, and what is listed is near.
std::string SolverCheck::Impl::close_pairs(const Pose& x, double distance, Tally& tally) {
  now_asking("close_pairs");
  std::vector<ClosePair> close;
  if (const auto done = checker->close_pairs(x, distance, close); !done)
    return "close_pairs are refused: " + done.error().line();
  const double side = largest_side(x, x), needle_room = std::max(0x1p-26 * side, 0x1p-1060);
  std::set<std::set<Index>> listed;
  for (const ClosePair& pair : close) {
    listed.emplace(pair.vertices.begin(), pair.vertices.end());
    const double unproven = std::min(1.0, 0x1p-36 * side / pair.distance) * side;  // soundness.md, V5
    if (pair.distance > distance + std::max(needle_room, unproven))
      return fmt::format("a close pair is {:a} apart instead of {:a}", pair.distance, distance);
  }
  int most = 8;
  for (const FeaturePair& pair : pairs) {
    bool is_listed = false;
    for (unsigned some = 1; some < 16 && !is_listed; ++some) {
      std::set<Index> vertices;
      for (unsigned k = 0; k < 4; ++k) {
        if ((some >> k & 1) != 0) vertices.insert(pair.vertices[k]);
      }
      is_listed = listed.contains(vertices);
    }
    const Features both = moving(pair, x, x);
    if (is_listed || surely_beyond(both, distance) || --most < 0) continue;
    ++tally.asked;
    if (comes_within(both, distance))
      return fmt::format("not among the close pairs, but within {:a}:\n{}", distance, describe(both));
  }
  return {};
}

// And again for positions that are little different: lists of candidates may hold there, or not quite.
std::string SolverCheck::Impl::candidates_going_on(Pose x0, Pose x1, double inflation, std::mt19937_64& rng,
                                                   Tally& tally) {
  const bool pose = rng() % 3 == 0;
  const double side = largest_side(x0, x1);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int call = 0; call < 4; ++call) {
    const Pose& end = pose ? x0 : x1;
    if (auto wrong = candidates(x0, end, inflation, tally); !wrong.empty()) return wrong;
    const double size = side * std::ldexp(1.0, -static_cast<int>(rng() % 30));
    const std::size_t from = rng() % x0.size();
    const std::size_t count = rng() % 2 == 0 ? x0.size() : 1 + rng() % x0.size();
    const double all = rng() % 3 == 0 ? unit(rng) * side * std::ldexp(1.0, static_cast<int>(rng() % 54)) : 0;
    for (std::size_t i = 0; i < x0.size(); ++i) {
      const bool moves = i >= from && i < from + count;
      for (Pose* x : {&x0, &x1}) {
        const double moved = (*x)[i] + all + (moves ? unit(rng) * size : 0);
        if (std::abs(moved) < 0x1p1000) (*x)[i] = moved;
      }
    }
  }
  return {};
}

std::string SolverCheck::Impl::intersections(const Pose& x, Tally& tally) {
  now_asking("has_intersections");
  const auto answer = checker->has_intersections(x);
  if (answer.is_error()) return "has_intersections is refused: " + answer.error().line();
  for (std::size_t i = 0; i < elements.size(); ++i) {
    for (std::size_t k = i + 1; k < elements.size(); ++k) {
      const auto &a = elements[i], &b = elements[k];
      const bool shared = std::any_of(a.begin(), a.end(),
                                      [&](Index v) { return std::find(b.begin(), b.end(), v) != b.end(); });
      if (shared && a.size() < 3 && b.size() < 3) continue;
      bool cross = false;
      if (shared) {
        const Triangle s = {a[0], a[1], a.size() > 2 ? a[2] : a[1]},
                       t = {b[0], b[1], b.size() > 2 ? b[2] : b[1]};
        cross = triangles_cross(s, t, x, tally);
      } else {
        std::vector<Vec3> p, q;
        for (const Index v : a) p.push_back(point(x, v));
        for (const Index v : b) q.push_back(point(x, v));
        cross = triangles_meet(p, q, tally);
      }
      if (cross)
        return answer.is_yes() ? ""
                               : fmt::format("has_intersections says no, but elements {} and {} meet", i, k);
    }
  }
  return answer.is_yes() ? "has_intersections says so, but no two elements meet" : "";
}

std::string SolverCheck::Impl::min_distance(const Pose& x, double bound, Tally& tally) {
  now_asking("minimum_distance");
  const auto answer = checker->minimum_distance(x, bound);
  if (!answer) return "minimum_distance is refused: " + answer.error().line();
  // As its header promises: it may be larger beside needles.
  const double side = largest_side(x, x), room = std::max(0x1p-46 * side, 0x1p-1060),
               needle_room = std::max(0x1p-26 * side, 0x1p-1060);
  const bool none = *answer == std::numeric_limits<double>::infinity();
  // Nothing is nearer than the answer, and something is as near.
  const double below = (none ? bound : *answer) - needle_room;
  if (below >= 0) {
    if (const FeaturePair* pair = contact(x, x, below, 8, tally); pair != nullptr)
      return fmt::format("the least distance is said to be {:a} (bound {:a}), but this pair is nearer:\n{}",
                         *answer, bound, describe(moving(*pair, x, x)));
  }
  if (!none && all_beyond(x, x, *answer + room))
    return fmt::format("the least distance is said to be {:a} (bound {:a}), but all pairs are farther apart",
                       *answer, bound);
  return {};
}

std::string SolverCheck::check(const Step& step, std::mt19937_64& rng, Tally& tally) {
  const Pose x0 = joined(step.x0), x1 = joined(step.x1);
  const double distance = step.settings.thickness, side = largest_side(x0, x1);
  ContactSettings& settings = impl_->checker->settings();
  settings.certificates = rng() % 4 != 0;
  settings.tolerance = impl_->least_tolerance = rng() % 4 == 0 ? side * 0x1p-32 : 0;
  settings.conservative_rescaling = rng() % 4 == 0 ? 1 : 0.8;
  if (impl_->pairs.empty()) return {};
  ++tally.solver_calls;
  switch (rng() % 5) {
    case 0:
      return impl_->candidates_going_on(x0, x1, distance, rng, tally);
    case 1:
      return impl_->intersections(x0, tally);
    case 2:
      return impl_->close_pairs(
          x0, rng() % 2 == 0 ? distance : side * std::ldexp(1.0, -static_cast<int>(rng() % 40)), tally);
    case 3: {
      const double bounds[] = {0,        side,
                               distance, side * 1e-6,
                               4 * side, 0x1p-1074 * static_cast<double>(1 + rng() % 1000),
                               1e-300,   std::numeric_limits<double>::infinity()};
      return impl_->min_distance(x0, bounds[rng() % std::size(bounds)], tally);
    }
    default:
      return impl_->steps(x0, x1, distance, tally);
  }
}

}  // namespace foldproof::adversary
