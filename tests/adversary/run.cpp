#include "adversary/run.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "base/parallel.h"
#include "oracle/brute_force.h"
#include "oracle/one_target.h"

namespace foldproof::adversary {

std::vector<std::int64_t> targets() {
  std::vector<std::int64_t> all;
  const std::int64_t supported = (hwy::SupportedTargets() & HWY_TARGETS) | HWY_STATIC_TARGET;
  for (std::int64_t target = 1; target > 0 && target <= supported; target <<= 1) {
    if ((supported & target) != 0) all.push_back(target);
  }
  return all;
}

namespace {

std::vector<std::span<const double>> spans(const Poses& poses) { return {poses.begin(), poses.end()}; }

template <class Collision>
std::string difference(const std::vector<Collision>& a, const std::vector<Collision>& b) {
  for (std::size_t k = 0; k < std::max(a.size(), b.size()); ++k) {
    const auto text = [&](const std::vector<Collision>& list) {
      if (k >= list.size()) return std::string("nothing");
      const auto key = oracle::key(list[k]);
      return fmt::format("{} {} {} {} {} {} at {:a} ({})", key[0], key[1], key[2], key[3], key[4], key[5],
                         list[k].toi, int(list[k].answer));
    };
    if (k >= a.size() || k >= b.size() || !oracle::same_collision(a[k], b[k]))
      return fmt::format("{} and {} pairs; the first that differ: {} / {}", a.size(), b.size(), text(a),
                         text(b));
  }
  return {};
}

std::string difference(const StepResult& a, const StepResult& b) {
  std::string text = difference(a.vertex_face, b.vertex_face);
  if (text.empty()) text = difference(a.edge_edge, b.edge_edge);
  if (text.empty() && a.earliest_toi != b.earliest_toi)
    text = fmt::format("earliest times {:a} and {:a}", a.earliest_toi, b.earliest_toi);
  if (text.empty() && (a.vertex_face_count != b.vertex_face_count || a.edge_edge_count != b.edge_edge_count))
    text = fmt::format("{} and {} pairs are counted", a.count(), b.count());
  if (text.empty() && a.tolerance != b.tolerance)
    text = fmt::format("tolerances {:a} and {:a}", a.tolerance, b.tolerance);
  return text;
}

// What is left of a complete answer when only the earliest is wanted.
StepResult earliest_of(const StepResult& all) {
  StepResult one = all;
  const auto keep = [&](auto& list) {
    const auto at =
        std::find_if(list.begin(), list.end(), [&](const auto& c) { return c.toi == all.earliest_toi; });
    if (at == list.end()) {
      list.clear();
      return false;
    }
    const auto first = *at;
    list.assign(1, first);
    return true;
  };
  if (keep(one.vertex_face)) {
    one.edge_edge.clear();
  } else {
    keep(one.edge_edge);
  }
  one.vertex_face_count = one.vertex_face.size();
  one.edge_edge_count = one.edge_edge.size();
  return one;
}

// Without the pairs on which the narrow phase gave up.
StepResult decided(StepResult all) {
  all.earliest_toi = 1;
  const auto keep = [&](auto& list) {
    std::erase_if(list, [](const auto& c) { return c.answer == Answer::Undecided; });
    for (const auto& c : list) all.earliest_toi = std::min(all.earliest_toi, c.toi);
    return list.size();
  };
  all.vertex_face_count = keep(all.vertex_face);
  all.edge_edge_count = keep(all.edge_edge);
  return all;
}

bool complete(const StepResult& result) {
  return result.vertex_face.size() + result.edge_edge.size() == result.count();
}

// The same when no more than so many are listed.
StepResult listed(const StepResult& all, std::uint64_t most) {
  StepResult some = all;
  some.vertex_face.resize(std::min<std::size_t>(some.vertex_face.size(), most));
  some.edge_edge.resize(std::min<std::size_t>(some.edge_edge.size(), most));
  return some;
}

using Objects = std::vector<foldproof::Object>;

class Player {
 public:
  Player(const Case& c, Tally& tally) : case_(c), tally_(tally), rng_(c.seed) {}

  std::string run() {
    const bool several = std::any_of(case_.steps.begin(), case_.steps.end(),
                                     [](const Step& step) { return (step.checks & kThreads) != 0; });
    const ThreadLimit limit(several ? 4 : 1);
    own_ = hierarchies(0);
    main_.emplace(own_);
    std::string complaint;
    for (std::size_t k = 0; k < case_.steps.size() && complaint.empty(); ++k) {
      complaint = play(case_.steps[k]);
      if (!complaint.empty()) complaint = fmt::format("step {}: {}", k, complaint);
    }
    return complaint;
  }

 private:
  Objects hierarchies(Index leaf_triangles) const {
    Objects all;
    for (std::size_t k = 0; k < case_.objects.size(); ++k) {
      const Object& o = case_.objects[k];
      HierarchySettings settings;
      settings.leaf_triangles = leaf_triangles != 0 ? leaf_triangles : o.leaf_triangles;
      all.push_back(std::make_shared<const Hierarchy>(
          Hierarchy::build(Topology::make(o.vertex_count, o.triangles).value(), case_.steps[0].x0[k],
                           settings)
              .value()));
    }
    return all;
  }

  // An undecided pair may be left out where something proves its leaves apart (docs/soundness.md, C1): then
  // what is decided must be the same, and the whole is held against the truth.
  std::string differs(const Step& step, const StepResult& result, const StepResult& expected) {
    std::string wrong = difference(result, expected);
    if (wrong.empty() || (result.work.undecided == 0 && expected.work.undecided == 0)) return wrong;
    if (step.settings.earliest_only || !complete(result) || !complete(expected)) return {};
    wrong = difference(decided(result), decided(expected));
    return wrong.empty() ? check_step(case_, step, result, rng_, tally_) : wrong;
  }

  std::string check(StepChecker& checker, const Step& step, const StepSettings& settings,
                    StepResult& out) const {
    const auto x0 = spans(step.x0), x1 = spans(step.x1);
    const auto done = checker.check(x0, x1, settings, out);
    return done ? "" : "refused: " + done.error().line();
  }

  // Half of the cases are explained: then certificates are always used, else where they pay, and only then
  // searches look ahead.
  StepSettings maybe_explained(StepSettings settings) const {
    settings.explain = case_.seed % 2 == 0;
    return settings;
  }

  // The answer that all others are compared with is held against the truth.
  std::string play(const Step& step) {
    ++tally_.steps;
    StepSettings plain = step.settings;
    plain.certificates = plain.look_ahead = plain.earliest_only = false;
    const auto all_targets = targets();
    {
      now_asking("a step for itself");
      const testing::OneTarget only(all_targets[rng_() % all_targets.size()]);
      StepChecker fresh(own_);
      if (std::string wrong = check(fresh, step, plain, full_); !wrong.empty()) return wrong;
    }
    expected_ = step.settings.earliest_only ? earliest_of(full_) : full_;
    tally_.hit_steps += !full_.clean();
    tally_.collisions += full_.vertex_face.size() + full_.edge_edge.size();
    tally_.undecided += full_.work.undecided;
    if (std::string wrong = play_main(step); !wrong.empty()) return wrong;
    now_asking("exact arithmetic");
    if (std::string wrong = check_step(case_, step, full_, rng_, tally_); !wrong.empty()) return wrong;
    return play_checks(step);
  }

  std::string play_main(const Step& step) {
    if ((step.checks & kFailure) != 0) {
      if (std::string wrong = fail_once(step); !wrong.empty()) return wrong;
    }
    now_asking("the long-lived checker");
    StepResult result;
    std::string wrong = check(*main_, step, maybe_explained(step.settings), result);
    if (wrong.empty()) wrong = differs(step, result, expected_);
    tally_.served += result.search_steps == 0;
    return wrong.empty()
               ? ""
               : fmt::format("the long-lived checker (searched {}) differs from one without certificates: {}",
                             result.search_steps, wrong);
  }

  // Numbers that are none, in the middle of a motion that may be served.
  std::string fail_once(const Step& step) {
    Step bad = step;
    Poses& x = rng_() % 2 == 0 ? bad.x0 : bad.x1;
    Pose& pose = x[rng_() % x.size()];
    const Triangle& t = case_.objects[static_cast<std::size_t>(&pose - x.data())].triangles[0];
    pose[3 * t[rng_() % 3] + rng_() % 3] = std::numeric_limits<double>::quiet_NaN();
    StepResult result;
    return check(*main_, bad, step.settings, result).empty() ? "a coordinate that is no number is accepted"
                                                             : "";
  }

  std::string play_checks(const Step& step) {
    constexpr std::uint64_t kMost = 20'000;  // pairs in an answer: what takes long is not asked over and over
    if (full_.count() > kMost) return {};
    using Play = std::string (Player::*)(const Step&);
    constexpr std::array<std::pair<unsigned, Play>, 7> kPlays = {{{kTargets, &Player::play_targets},
                                                                  {kOrder, &Player::play_order},
                                                                  {kThreads, &Player::play_threads},
                                                                  {kLeaves, &Player::play_leaves},
                                                                  {kPose, &Player::play_pose},
                                                                  {kSolver, &Player::play_solver},
                                                                  {kSearches, &Player::play_searches}}};
    for (const auto& [bit, what] : kPlays) {
      if ((step.checks & bit) == 0) continue;
      if (std::string wrong = (this->*what)(step); !wrong.empty()) return wrong;
    }
    return {};
  }

  // Twice, as charts are drawn from the second step on.
  std::string play_targets(const Step& step) {
    now_asking("instruction sets");
    for (const std::int64_t target : targets()) {
      const testing::OneTarget only(target);
      StepChecker fresh(own_);
      for (int round = 0; round < 2; ++round) {
        StepResult result;
        StepSettings settings = step.settings;
        settings.certificates = round > 0 || rng_() % 2 == 0;
        settings.explain = true;
        std::string wrong = check(fresh, step, settings, result);
        if (wrong.empty()) wrong = differs(step, result, expected_);
        if (!wrong.empty()) return fmt::format("with {}: {}", hwy::TargetName(target), wrong);
      }
    }
    return {};
  }

  std::string play_order(const Step& step) {
    now_asking("objects the other way round");
    const auto last = static_cast<Index>(case_.objects.size() - 1);
    StepChecker fresh(Objects(own_.rbegin(), own_.rend()));
    Step turned = step;
    for (Poses* x : {&turned.x0, &turned.x1}) std::reverse(x->begin(), x->end());
    StepSettings settings = step.settings;
    settings.earliest_only = false;
    settings.certificates = rng_() % 2 == 0;
    settings = maybe_explained(settings);
    StepResult result;
    if (std::string wrong = check(fresh, turned, settings, result); !wrong.empty()) return wrong;
    for (auto& c : result.vertex_face) {
      c.vertex_object = last - c.vertex_object;
      c.face_object = last - c.face_object;
    }
    std::sort(result.vertex_face.begin(), result.vertex_face.end(),
              [](const auto& a, const auto& b) { return oracle::key(a) < oracle::key(b); });
    if (std::string wrong = difference(result.vertex_face, full_.vertex_face);
        !wrong.empty() && result.work.undecided == 0 && full_.work.undecided == 0)
      return "with objects the other way round: " + wrong;
    // Of two edges the narrow phase may say otherwise when they change places: asked for itself.
    Case other;
    other.objects.assign(case_.objects.rbegin(), case_.objects.rend());
    result.vertex_face = {};
    StepResult complete;
    if (std::string wrong = check(fresh, turned, settings, complete); !wrong.empty()) return wrong;
    const std::string wrong = check_step(other, turned, complete, rng_, tally_);
    return wrong.empty() ? "" : "with objects the other way round: " + wrong;
  }

  std::string play_threads(const Step& step) {
    now_asking("one thread");
    if (!single_) single_.emplace(own_);
    const ThreadLimit one(1);
    StepResult result;
    std::string wrong = check(*single_, step, step.settings, result);
    if (wrong.empty()) wrong = differs(step, result, expected_);
    return wrong.empty() ? "" : "with one thread: " + wrong;
  }

  std::string play_leaves(const Step& step) {
    now_asking("other leaves");
    constexpr std::array<Index, 5> kSizes = {1, 3, 8, 16, 64};
    StepChecker fresh(hierarchies(kSizes[rng_() % kSizes.size()]));
    StepSettings settings = step.settings;
    settings.certificates = rng_() % 2 == 0;
    if (!settings.earliest_only && rng_() % 4 == 0) settings.max_listed = rng_() % 8;
    settings = maybe_explained(settings);
    StepResult result;
    std::string wrong = check(fresh, step, settings, result);
    if (wrong.empty()) wrong = differs(step, result, listed(expected_, settings.max_listed));
    return wrong.empty() ? "" : "with other leaves: " + wrong;
  }

  std::string play_pose(const Step& step) {
    now_asking("a pose");
    const Poses& x = rng_() % 2 == 0 ? step.x0 : step.x1;
    StaticResult result, other;
    const auto at = spans(x);
    if (const auto done = main_->check_static(at, step.settings, result); !done)
      return "the pose is refused: " + done.error().line();
    ++tally_.poses;
    tally_.hit_poses += !result.clean();
    if (std::string wrong = check_pose(case_, x, step.settings, result, tally_); !wrong.empty())
      return "pose: " + wrong;
    StepSettings plain = step.settings;
    plain.certificates = rng_() % 2 == 0;
    plain = maybe_explained(plain);
    for (const std::int64_t target : targets()) {
      const testing::OneTarget only(target);
      StepChecker fresh(own_);
      if (!fresh.check_static(at, plain, other) || !oracle::same_crossings(result, other)) {
        return fmt::format("the crossings of a pose differ with {}: {} and {}", hwy::TargetName(target),
                           result.crossings.size(), other.crossings.size());
      }
    }
    return {};
  }

  std::string play_solver(const Step& step) {
    if (!solver_) solver_.emplace(case_, rng_);
    std::string wrong = solver_->check(step, rng_, tally_);
    return wrong.empty() ? "" : "solver: " + wrong;
  }

  // They live as long as the case and see only some of its steps.
  std::string play_searches(const Step& step) {
    now_asking("other searches");
    for (int which = 0; which < 2; ++which) {
      std::optional<StepChecker>& checker = which == 0 ? without_ahead_ : without_certificates_;
      if (!checker) checker.emplace(own_);
      StepSettings settings = step.settings;
      (which == 0 ? settings.look_ahead : settings.certificates) = false;
      settings = maybe_explained(settings);
      StepResult result;
      std::string wrong = check(*checker, step, settings, result);
      if (wrong.empty()) wrong = differs(step, result, expected_);
      if (!wrong.empty())
        return fmt::format("without {}: {}", which == 0 ? "looking ahead" : "certificates", wrong);
    }
    return {};
  }

  const Case& case_;
  Tally& tally_;
  std::mt19937_64 rng_;
  Objects own_;
  std::optional<StepChecker> main_, single_, without_ahead_, without_certificates_;
  std::optional<SolverCheck> solver_;
  StepResult full_, expected_;
};

}  // namespace

std::string run_case(const Case& c, Tally& tally) {
  ++tally.cases;
  std::string wrong = Player(c, tally).run();
  if (wrong.empty() && c.seed % 64 == 0) wrong = check_reduced(c, tally);
  return wrong;
}

}  // namespace foldproof::adversary
