#include "foldproof/repair.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "base/plain_arithmetic.h"
#include "base/try.h"
#include "repair/passes.h"

namespace foldproof {
namespace {

constexpr double kFalloffOfSize = 0.05, kFalloffInEdges = 4;
constexpr double kClearanceInEdges = 0.15;
constexpr int kApproachSteps = 16;  // from a pose that is not a frame to the frame
constexpr const char* kThickness = "thickness";
constexpr double kSingleSteps = 64;  // single precision must hold the clearance in so many steps

/// Where a repair begins.
struct Start {
  Index frame = 0;
  std::vector<double> x;         // a pose in which nothing crosses
  bool is_frame = false;         // it is the frame itself
  bool keeps_thickness = false;  // and nothing is closer than the thickness: its gaps are as they should be
  std::shared_ptr<const PairFilter> exempt = nullptr;  // what may touch; null: nothing
};

class Repair {
 public:
  Repair(const RepairInput& input, const RepairSettings& settings, const RepairScene& scene)
      : input_(input),
        settings_(settings),
        scene_(scene),
        frames_(input, scene, settings.single_precision),
        prover_(std::make_unique<Prover>(scene, scene.filter(), settings.thickness)),
        analysis_(scene, *prover_, settings.thickness) {}

  Result<RepairReport> run(const std::function<Result<void>(double, std::span<const double>)>& write);

 private:
  using Write = std::function<Result<void>(double, std::span<const double>)>;

  Result<void> analyze();
  Result<std::optional<Start>> find_start();
  Result<std::optional<Start>> given_start();
  Result<std::optional<Start>> free_frame();
  Result<std::optional<Start>> known_pose();
  Result<std::optional<Start>> untangled_start();
  Result<std::optional<Start>> exempt_start();
  Index calmest_frame() const;
  std::shared_ptr<const PairFilter> filter_with(const std::shared_ptr<const PairFilter>& exempt) const {
    return exempt == nullptr ? scene_.filter() : ignore_all({scene_.filter(), exempt});
  }
  Result<void> prepare(const Start& start);
  Result<void> check_precision(std::span<const double> x) const;
  struct OwnGap;
  Result<void> measure_own_gaps(std::span<const double> x, Index frame, bool only_edges, OwnGap& least);
  Result<void> check_own_gaps(std::span<const double> x, Index frame, bool only_edges);
  Result<std::string> what_touches(std::span<const double> x);
  Result<bool> approach_frame(const Start& start);
  void set_thickness(double thickness);
  Result<bool> widen(Index frame);
  Result<void> write_all(std::span<const SolvedFrame> frames, const Write& write, bool writes,
                         RepairReport& report);
  bool is_interrupted() const { return settings_.interrupted && settings_.interrupted(); }
  void progress(double share) const {
    if (settings_.progress) settings_.progress(std::min(1.0, share));
  }
  const RepairInput& input_;
  const RepairSettings& settings_;
  const RepairScene& scene_;
  Frames frames_;
  std::unique_ptr<Prover> prover_;
  Analysis analysis_;
  std::optional<ElasticSurface> surface_;
  std::optional<NearPairs> pairs_;
  std::optional<Prover> step_prover_;
  std::optional<FrameSolver> solver_;
  std::optional<Passes> passes_;
  SceneSize size_;
  double falloff_ = 0, range_ = 0;
  std::vector<double> rest_;  // empty: its gaps are not known
  std::vector<double> x_;
  double done_ = 0;  // frames of passes
};

// Three digits that are less, by more than a checker's tolerance.
double below(double length) {
  const double unit = std::pow(10, std::floor(std::log10(length)) - 2);
  return (std::ceil((1 - 1e-6) * length / unit) - 1) * unit;
}

Result<void> interrupted() {
  return fail(ErrorCode::Interrupted, "repair", "was interrupted; nothing was written", "run it again");
}

// The smallest gap of features at the two ends of an edge of which something may move.
struct Repair::OwnGap {
  double gap;
  std::array<Index, 2> ends{};
  Index frame = 0;
};

// `only_edges`: features at both ends of an edge are at most its length apart; those that are closer are left
// out.
Result<void> Repair::measure_own_gaps(std::span<const double> x, Index frame, bool only_edges,
                                      OwnGap& least) {
  for (const auto& [a, b] : scene_.edges()) {
    const double length = (at(x, a) - at(x, b)).norm();
    const bool ends = scene_.neighbors()[a].size() < 2 || scene_.neighbors()[b].size() < 2;
    if (ends || length >= least.gap || !(scene_.is_movable(a) || scene_.is_movable(b))) continue;
    least = {length, {a, b}, frame};
  }
  if (only_edges) return {};
  std::vector<FeaturePair> near;
  FOLDPROOF_TRY(prover_->find_near(x, x, least.gap, near));
  for (const FeaturePair& pair : near) {
    const std::size_t n = pair.edges ? 2 : 1;
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t k = n; k < 4; ++k) {
        const auto around = scene_.neighbors()[pair.v[i]];
        if (std::ranges::find(around, pair.v[k]) == around.end()) continue;
        const double gap = pair.distance(points_of(x, pair.v));
        if (gap < least.gap) least = {gap, {pair.v[i], pair.v[k]}, frame};
      }
    }
  }
  return {};
}

// A thickness that next neighbors of the mesh do not keep would never be free. Only where it is refused, all
// frames are looked at, for the one number that helps.
Result<void> Repair::check_own_gaps(std::span<const double> x, Index frame, bool only_edges) {
  if (settings_.thickness == 0) return {};
  OwnGap least{std::nextafter(settings_.thickness, std::numeric_limits<double>::infinity())};
  FOLDPROOF_TRY(measure_own_gaps(x, frame, only_edges, least));
  if (least.gap > settings_.thickness) return {};
  for (Index k = 0; k < frames_.count(); ++k) {
    if (is_interrupted()) return interrupted();
    FOLDPROOF_TRY(measure_own_gaps(FOLDPROOF_TRY(frames_.read(k)), k, false, least));
  }
  const Index object = scene_.object_of_vertex(least.ends[0]), first = scene_.begin(object).vertices;
  return fail(ErrorCode::InvalidArgument, kThickness,
              fmt::format("{:.3g} is more than the gaps of {} itself: in frame {} features at the edge of "
                          "vertices {} and {} are {:.3g} apart",
                          settings_.thickness, scene_.name(object), input_.first_frame + least.frame,
                          least.ends[0] - first, least.ends[1] - first, least.gap),
              fmt::format("give at most {:.3g}", below(least.gap)));
}

Result<void> Repair::analyze() {
  for (Index k = 0; k < frames_.count(); ++k) {
    if (is_interrupted()) return interrupted();
    FOLDPROOF_TRY(analysis_.add(k, FOLDPROOF_TRY(frames_.read(k))));
    progress(0.1 * (k + 1) / frames_.count());
  }
  return {};
}

Result<std::optional<Start>> Repair::given_start() {
  if (settings_.start.empty()) return std::nullopt;
  Start start{settings_.start_frame, settings_.start, false, true};
  if (start.x.size() != scene_.size())
    return fail(ErrorCode::InvalidArgument, "start",
                fmt::format("has {} vertices, the objects {}", start.x.size() / 3, scene_.vertex_count()),
                "give a pose of all objects");
  if (start.frame >= frames_.count())
    return fail(ErrorCode::InvalidArgument, "start_frame",
                fmt::format("is {}, but the motion has {} frames", start.frame, frames_.count()),
                "name one of them, counting from 0");
  if (settings_.single_precision) round_to_single(start.x);
  if (!FOLDPROOF_TRY(prover_->is_free(start.x)))
    return fail(ErrorCode::InvalidArgument, "start", FOLDPROOF_TRY(what_touches(start.x)),
                "give a pose that is free");
  return start;
}

Result<std::string> Repair::what_touches(std::span<const double> x) {
  const StaticResult* pose = FOLDPROOF_TRY(prover_->check_pose(x));
  if (pose->clean()) return "comes closer to itself than the thickness";
  const TriangleCrossing& c = pose->crossings[0];
  return fmt::format("touches itself: {} pairs of triangles cross, such as {} of {} and {} of {}",
                     pose->crossing_count, c.triangle_a, scene_.name(c.object_a), c.triangle_b,
                     scene_.name(c.object_b));
}

Result<std::optional<Start>> Repair::known_pose() {
  if (!settings_.poses) return std::nullopt;
  for (std::vector<double>& x : FOLDPROOF_TRY(settings_.poses())) {
    if (x.size() != scene_.size())
      return fail(ErrorCode::InvalidArgument, "poses", "have another size than the objects",
                  "give poses of all objects");
    if (settings_.single_precision) round_to_single(x);
    if (FOLDPROOF_TRY(prover_->is_free(x))) return Start{calmest_frame(), std::move(x), false, true};
  }
  return std::nullopt;
}

Result<std::optional<Start>> Repair::untangled_start() {
  const Index frame = calmest_frame();
  auto pose = FOLDPROOF_TRY(untangle(scene_, *prover_, FOLDPROOF_TRY(frames_.read(frame))));
  if (pose && settings_.single_precision) {
    round_to_single(*pose);
    if (!FOLDPROOF_TRY(prover_->check_pose(*pose))->clean()) pose.reset();
  }
  if (!pose) return std::nullopt;
  return Start{frame, std::move(*pose)};
}

// What crosses in the frame with the fewest crossings is exempt, for as long as these contacts last.
Result<std::optional<Start>> Repair::exempt_start() {
  Start start{calmest_frame(), {}, true, settings_.thickness == 0};
  start.exempt =
      FOLDPROOF_TRY(ignore_sewn(scene_.objects(), analysis_.seams(analysis_.crossing_contacts(start.frame))));
  start.x = FOLDPROOF_TRY(frames_.read(start.frame));
  Prover exempting(scene_, filter_with(start.exempt), 0);
  if (!FOLDPROOF_TRY(exempting.check_pose(start.x))->clean()) return std::nullopt;
  return start;
}

Index Repair::calmest_frame() const {
  Index calmest = 0;
  for (Index k = 1; k < frames_.count(); ++k) {
    if (analysis_.crossings(k) < analysis_.crossings(calmest)) calmest = k;
  }
  return calmest;
}

// A frame that is free, a pose that is given, known or untangled and from which the frame can be approached,
// or what crosses is exempt. x_ is then a free pose at the frame.
Result<std::optional<Start>> Repair::find_start() {
  for (const auto find : {&Repair::given_start, &Repair::free_frame, &Repair::known_pose,
                          &Repair::untangled_start, &Repair::exempt_start}) {
    auto start = FOLDPROOF_TRY((this->*find)());
    if (!start) continue;
    FOLDPROOF_TRY(prepare(*start));
    x_ = start->x;
    set_thickness(start->keeps_thickness ? settings_.thickness : 0);
    if (!start->is_frame && !FOLDPROOF_TRY(approach_frame(*start))) continue;
    if (start->keeps_thickness || FOLDPROOF_TRY(widen(start->frame))) return start;
  }
  return std::nullopt;
}

// The first free frame; or the first in which nothing crosses, though something is closer than the thickness.
Result<std::optional<Start>> Repair::free_frame() {
  std::optional<Index> best;
  for (Index k = 0; k < frames_.count() && !best; ++k) {
    if (analysis_.is_free(k)) best = k;
  }
  for (Index k = 0; k < frames_.count() && !best; ++k) {
    if (analysis_.crossings(k) == 0) best = k;
  }
  if (!best) return std::nullopt;
  return Start{*best, FOLDPROOF_TRY(frames_.read(*best)), true, analysis_.is_free(*best)};
}

void Repair::set_thickness(double thickness) {
  passes_->set_thickness(thickness);
  step_prover_->set_thickness(thickness);
}

// Moves what is closer than the thickness apart, in solves that each keep what the last one reached.
Result<bool> Repair::widen(Index frame) {
  constexpr double kKept = 0.9, kLeastGain = 1.02;
  const auto target = FOLDPROOF_TRY(frames_.read(frame));
  std::vector<double> x;
  std::vector<FeaturePair> near;
  for (double kept = 0; kept < settings_.thickness;) {
    double smallest = 2 * settings_.thickness;
    near.clear();
    FOLDPROOF_TRY(step_prover_->find_near(x_, x_, smallest, near));
    for (const FeaturePair& pair : near) smallest = std::min(smallest, pair.distance(points_of(x_, pair.v)));
    const double next = std::min(settings_.thickness, kKept * smallest);
    if (!(next > kLeastGain * kept)) return false;
    set_thickness(kept = next);
    FOLDPROOF_TRY(passes_->follow(x_, {target, target, target, static_cast<double>(frame)}, 1, x));
    x_.swap(x);
  }
  return true;
}

Result<void> Repair::check_precision(std::span<const double> x) const {
  if (!settings_.single_precision) return {};
  double largest = 0;
  for (const double c : x) largest = std::max(largest, std::abs(c));
  const double step = largest * std::numeric_limits<float>::epsilon();
  if (step * kSingleSteps <= range_) return {};
  return fail(
      ErrorCode::InvalidArgument, "single precision",
      fmt::format("is {:.2g} mesh units coarse at coordinates of {:.3g}, but surfaces are kept {:.2g} apart",
                  step, largest, range_),
      "write a format with double precision, such as .npz, or move the motion to the origin");
}

Result<void> Repair::prepare(const Start& start) {
  size_ = scene_size(scene_, start.x);
  if (!(size_.edge > 0))
    return fail(ErrorCode::InvalidMesh, "repair", "what may move is a single point", "give a mesh");
  range_ = kClearanceInEdges * size_.edge;
  falloff_ = settings_.falloff > 0 ? settings_.falloff
                                   : std::max(kFalloffOfSize * size_.size, kFalloffInEdges * size_.edge);
  FOLDPROOF_TRY(check_precision(start.x));
  FOLDPROOF_TRY(check_own_gaps(start.x, start.frame, false));
  const auto filter = filter_with(start.exempt);
  rest_ = start.keeps_thickness ? start.x : std::vector<double>();
  surface_.emplace(scene_, start.x, falloff_);
  pairs_ = FOLDPROOF_TRY(NearPairs::make(scene_, start.x, filter));
  step_prover_.emplace(scene_, filter, settings_.thickness);
  solver_.emplace(scene_, *surface_, *pairs_, *step_prover_, size_.edge, falloff_,
                  settings_.single_precision);
  solver_->set_interrupted(settings_.interrupted);
  const RepairTools tools{&scene_, &frames_,   &analysis_,         &*solver_, settings_.thickness,
                          range_,  size_.edge, settings_.accuracy, rest_};
  passes_.emplace(tools, settings_.in_betweens, [this]() -> Result<void> {
    done_ += 1;
    progress(0.1 + 0.8 * done_ / (frames_.count() * (settings_.calm ? 2 : 1)));
    return is_interrupted() ? interrupted() : Result<void>();
  });
  return {};
}

// Brings x_ from a pose that is no frame to the frame where the repair begins; false where there is no way.
Result<bool> Repair::approach_frame(const Start& start) {
  const auto frame = FOLDPROOF_TRY(frames_.read(start.frame));
  std::vector<double> goal(start.x), last_goal, x;
  for (int step = 1; step <= kApproachSteps; ++step) {
    passes_->set_rough(step < kApproachSteps);
    last_goal = goal;
    for (std::size_t i = 0; i < goal.size(); ++i) {
      goal[i] =
          step == kApproachSteps ? frame[i] : start.x[i] + (frame[i] - start.x[i]) * step / kApproachSteps;
    }
    const auto outcome =
        FOLDPROOF_TRY(passes_->follow(x_, {last_goal, goal, frame, static_cast<double>(start.frame)}, 1, x));
    if (!outcome.arrived) return false;
    x_.swap(x);
  }
  return true;
}

Result<void> Repair::write_all(std::span<const SolvedFrame> frames, const Write& write, bool writes,
                               RepairReport& report) {
  Analysis proof(scene_, *prover_, settings_.thickness);
  std::vector<double> x, first, first_target;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (is_interrupted() && !report.interrupted) return interrupted();
    const SolvedFrame& solved = frames[i];
    x = FOLDPROOF_TRY(frames_.at_time(solved.time));
    if (i == 0) first_target = x;
    const bool loops = i > 0 && solved.time == frames_.count() - 1 && x == first_target;
    if (!solved.correction.vertices.empty()) {
      solved.correction.apply(x);
      scene_.move_copies(x);
      if (settings_.single_precision) round_to_single(x);
    }
    if (i == 0) first = x;
    report.open_loop = loops && x != first;
    FOLDPROOF_TRY(proof.add(solved.time, x));
    RepairedFrame out{solved.time, solved.correction.largest, solved.late || solved.held_back, solved.limit};
    if (proof.is_free(i) && proof.is_way_free(i)) {
      out.limit = RepairLimit::None;
    } else if (out.limit == RepairLimit::None) {
      const bool after_given_up = i > 0 && frames[i - 1].limit == RepairLimit::GivenUp;
      out.limit = after_given_up ? RepairLimit::GivenUp : RepairLimit::NoFreeStart;
    }
    report.frames.push_back(out);
    if (writes) FOLDPROOF_TRY(write(solved.time, x));
    progress(0.9 + 0.1 * static_cast<double>(i + 1) / static_cast<double>(frames.size()));
  }
  report.free = proof.all_free();
  auto contacts = FOLDPROOF_TRY(proof.finish());
  report.remaining = std::move(contacts.of_movable);
  report.among_fixed = std::move(contacts.among_fixed);
  report.written = writes;
  return {};
}

Result<RepairReport> Repair::run(const Write& write) {
  RepairReport report;
  if (settings_.thickness > 0)  // said before anything that takes long
    FOLDPROOF_TRY(check_own_gaps(FOLDPROOF_TRY(frames_.read(0)), 0, true));
  FOLDPROOF_TRY(analyze());
  report.before = FOLDPROOF_TRY(analysis_.finish()).of_movable;
  std::optional<Start> start;
  if (analysis_.all_free()) {
    report.unchanged = true;
  } else {
    start = FOLDPROOF_TRY(find_start());
  }
  if (!start) {
    std::vector<SolvedFrame> same(frames_.count());
    for (Index k = 0; k < frames_.count(); ++k) same[k].time = k;
    FOLDPROOF_TRY(write_all(same, write, report.unchanged, report));
    return report;
  }
  report.falloff = falloff_;
  report.clearance = range_;
  const bool relaxes = settings_.calm && frames_.count() > 1;
  auto done = passes_->follow_motion(start->frame, x_, relaxes);
  if (done && relaxes) done = passes_->relax();
  report.interrupted = !done && done.error().code == ErrorCode::Interrupted && settings_.keep;
  if (!done && !report.interrupted) return tl::unexpected(std::move(done.error()));
  const auto frames = passes_->frames();
  const bool changed =
      std::ranges::any_of(frames, [](const SolvedFrame& f) { return !f.correction.vertices.empty(); });
  FOLDPROOF_TRY(write_all(frames, write, changed || report.interrupted, report));
  return report;
}

Result<void> check_settings(const RepairInput& input, const RepairSettings& settings) {
  const auto refuse = [](const char* what, const char* problem) {
    return fail(ErrorCode::InvalidArgument, what, problem, "give a length of at least 0");
  };
  if (input.objects.empty() || input.frame_count == 0)
    return fail(ErrorCode::InvalidArgument, "repair", "there is nothing to repair",
                "give an object and a frame");
  if (!(settings.thickness >= 0) || !std::isfinite(settings.thickness))
    return refuse("thickness", "is not a length");
  if (!(settings.accuracy > 0 && settings.accuracy <= 1))
    return fail(ErrorCode::InvalidArgument, "accuracy", "is not above 0 and at most 1",
                "give 1, or less to be closer");
  if (!(settings.falloff >= 0) || !std::isfinite(settings.falloff))
    return refuse("falloff", "is not a length");
  return {};
}

// Contacts of all pairs, frame by frame.
struct AllContacts {
  Prover prover;
  Analysis analysis;
  AllContacts(const RepairScene& scene, const RepairSettings& settings, bool keeps_seams)
      : prover(scene, scene.filter(), settings.thickness),
        analysis(scene, prover, settings.thickness, keeps_seams) {}
  // Those that are chosen, and those that are not.
  Result<std::array<std::vector<Contact>, 2>> sorted(const RepairSettings& settings) {
    std::array<std::vector<Contact>, 2> out;
    for (Contact& contact : FOLDPROOF_TRY(analysis.finish()).of_movable)
      out[settings.chosen(contact) ? 0 : 1].push_back(std::move(contact));
    return out;
  }
};

// What touches in contacts that are not chosen is ignored; what is left of all contacts is found again.
Result<RepairReport> repair_chosen(
    const RepairInput& input, const RepairSettings& settings, const RepairScene& scene,
    const std::function<Result<void>(double, std::span<const double>)>& write) {
  const Frames frames(input, scene, settings.single_precision);
  AllContacts before(scene, settings, true), after(scene, settings, false);
  for (Index k = 0; k < frames.count(); ++k) {
    if (settings.interrupted && settings.interrupted()) return tl::unexpected(interrupted().error());
    FOLDPROOF_TRY(before.analysis.add(k, FOLDPROOF_TRY(frames.read(k))));
  }
  auto [chosen, others] = FOLDPROOF_TRY(before.sorted(settings));
  const auto numbers_of = [](const std::vector<Contact>& contacts) {
    std::set<Index> numbers;
    for (const Contact& contact : contacts) numbers.insert(contact.number);
    return numbers;
  };
  const auto seams = before.analysis.seams(numbers_of(others), numbers_of(chosen));
  RepairInput of_chosen = input;
  of_chosen.filter = FOLDPROOF_TRY(ignore_sewn(scene.objects(), seams));
  if (input.filter) of_chosen.filter = ignore_all({of_chosen.filter, input.filter});
  const RepairScene of_chosen_scene = FOLDPROOF_TRY(RepairScene::make(of_chosen));
  RepairReport report = FOLDPROOF_TRY(Repair(of_chosen, settings, of_chosen_scene)
                                          .run([&](double time, std::span<const double> x) -> Result<void> {
                                            FOLDPROOF_TRY(after.analysis.add(time, x));
                                            return write(time, x);
                                          }));
  report.before = std::move(chosen);
  report.left = std::move(others);
  if (!report.written) return report;
  auto [remaining, left] = FOLDPROOF_TRY(after.sorted(settings));
  report.remaining = std::move(remaining);
  report.left = std::move(left);
  report.free = report.free && report.remaining.empty();
  return report;
}

}  // namespace

Result<RepairReport> repair(const RepairInput& input, const RepairSettings& settings,
                            const std::function<Result<void>(double, std::span<const double>)>& write) {
  const PlainArithmetic plain;
  FOLDPROOF_TRY(check_settings(input, settings));
  const RepairScene scene = FOLDPROOF_TRY(RepairScene::make(input));
  if (settings.chosen) return repair_chosen(input, settings, scene, write);
  return Repair(input, settings, scene).run(write);
}

}  // namespace foldproof
