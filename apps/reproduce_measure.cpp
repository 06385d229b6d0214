// Every mode over the same steps, held against plain hierarchies.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <tuple>

#include "foldproof/reduced.h"
#include "reproduce.h"
#include "terminal.h"

namespace foldproof::reproduce {
namespace {

bool before(const VertexFaceCollision& a, const VertexFaceCollision& b) {
  return std::tie(a.vertex_object, a.vertex, a.face_object, a.face) <
         std::tie(b.vertex_object, b.vertex, b.face_object, b.face);
}
bool before(const EdgeEdgeCollision& a, const EdgeEdgeCollision& b) {
  return std::tie(a.object_a, a.a, a.object_b, a.b) < std::tie(b.object_a, b.a, b.object_b, b.b);
}

/// How many of `wanted` are not among `given`; both are sorted by ids.
template <class Collision>
std::uint64_t missing(const std::vector<Collision>& wanted, const std::vector<Collision>& given) {
  std::uint64_t count = 0;
  auto next = given.begin();
  for (const Collision& collision : wanted) {
    while (next != given.end() && before(*next, collision)) ++next;
    count += next == given.end() || before(collision, *next);
  }
  return count;
}

/// A mode's name, and how it answers step k.
struct Way {
  std::string name;
  std::function<Result<void>(Index, StepResult&)> answer;
  bool statistical = false;
};

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Takes modes one after the other; the first tells what is right.
class Comparison {
 public:
  Comparison(Index steps, const Hooks& hooks) : steps_(steps), hooks_(hooks) {}

  Result<ModeRow> run(const Way& way) {
    ModeRow mode{.name = way.name, .statistical = way.statistical};
    const bool first = truth_.empty();
    std::vector<double> milliseconds;
    for (Index step = 0; step < steps_; ++step) {
      if (hooks_.cancelled()) return fail("interrupted", "measuring was not finished", "start again");
      if (auto done = way.answer(step, answer_); !done) return tl::unexpected(done.error());
      if (first) truth_.push_back({answer_.vertex_face, answer_.edge_edge});
      const Truth& truth = truth_[step];
      mode.collisions += answer_.count();
      mode.misses +=
          missing(truth.vertex_face, answer_.vertex_face) + missing(truth.edge_edge, answer_.edge_edge);
      mode.extra +=
          missing(answer_.vertex_face, truth.vertex_face) + missing(answer_.edge_edge, truth.edge_edge);
      if (step > 0 || steps_ == 1) {  // buffers grow in the first one
        milliseconds.push_back(answer_.milliseconds.total);
        mode.leaf_pairs += static_cast<double>(answer_.work.leaf_pairs);
      }
      mode.empty_steps += answer_.work.leaf_pairs == 0;
      hooks_.progress((step + 1.0) / steps_, way.name);
    }
    mode.leaf_pairs /= static_cast<double>(milliseconds.size());
    mode.milliseconds = median(std::move(milliseconds));
    if (first) plain_leaf_pairs_ = mode.leaf_pairs;
    mode.removed = plain_leaf_pairs_ > 0 ? 1 - mode.leaf_pairs / plain_leaf_pairs_ : 0;
    return mode;
  }

  Result<std::vector<ModeRow>> run(std::span<const Way> ways) {
    std::vector<ModeRow> modes;
    for (const Way& way : ways) {
      auto mode = run(way);
      if (!mode) return tl::unexpected(mode.error());
      modes.push_back(std::move(*mode));
    }
    return modes;
  }

 private:
  struct Truth {
    std::vector<VertexFaceCollision> vertex_face;
    std::vector<EdgeEdgeCollision> edge_edge;
  };
  Index steps_;
  const Hooks& hooks_;
  std::vector<Truth> truth_;
  double plain_leaf_pairs_ = 0;
  StepResult answer_;
};

using Frames = std::vector<std::vector<double>>;

Result<void> check(StepChecker& checker, const Frames& frames, Index step, const StepSettings& settings,
                   StepResult& out) {
  return checker.check(frames[step], frames[step + 1], settings, out);
}

Way full_way(std::string name, StepChecker checker, const Frames& frames, const StepSettings& settings) {
  const auto owned = std::make_shared<StepChecker>(std::move(checker));
  return {std::move(name), [owned, &frames, settings](Index step, StepResult& out) {
            return check(*owned, frames, step, settings, out);
          }};
}

/// The modes that take any motion.
Result<std::vector<ModeRow>> measure_full(const Frames& frames, const Model& model, const Hooks& hooks,
                                          WorstStep& worst) {
  const auto& hierarchy = model.hierarchy();
  Way plain = full_way("plain hierarchies", StepChecker({hierarchy}), frames, {.certificates = false});
  const auto answer = plain.answer;
  plain.answer = [&](Index step, StepResult& out) -> Result<void> {
    if (auto done = answer(step, out); !done) return done;
    const auto count = [](const StepResult& r) { return r.count(); };
    if (count(out) > count(worst.answer)) {
      worst.frame = step;
      worst.answer = out;
    }
    return {};
  };
  std::vector<Way> ways{
      // What certificates remove is counted step by step.
      plain, full_way("certificates, no model", StepChecker({hierarchy}), frames, {.ahead = false}),
      full_way("certificates, model", StepChecker({model.object()}), frames, {.ahead = false})};
  if (model.learned && model.learned->certificates) {
    for (const double rate : {0.01, 0.1, 1.0}) {
      ways.push_back(full_way(fmt::format("paper, miss rate {:.0f} %", 100 * rate),
                              StepChecker({model.object()}), frames,
                              {.mode = Mode::Paper, .miss_rate = rate}));
      ways.back().statistical = true;
    }
  }
  return Comparison(static_cast<Index>(frames.size() - 1), hooks).run(ways);
}

/// The motion in the subspace: the nearest shapes that p can tell.
struct ReducedFilm {
  std::vector<Eigen::VectorXd> p;
  Frames frames;
};

ReducedFilm reduce(const Frames& frames, const Pca& pca, const ReducedMotion& motion) {
  ReducedFilm film;
  for (const auto& frame : frames) {
    film.p.push_back(pca.project(
        Eigen::Map<const Eigen::VectorXd>(frame.data(), static_cast<Eigen::Index>(frame.size()))));
    film.frames.emplace_back(frame.size());
    place_vertices(motion, {.p = {film.p.back().data(), static_cast<std::size_t>(film.p.back().size())}},
                   film.frames.back());
  }
  return film;
}

/// Centres of balls: the mean, and the middle of every group of training poses.
std::vector<ReducedCentre> centres_of(const Learned& learned) {
  const Eigen::VectorXd mean = Eigen::VectorXd::Zero(learned.pca.modes());
  std::vector<ReducedCentre> centres{{.p = {mean.begin(), mean.end()}}};
  const Eigen::MatrixXd& groups = learned.clusters.centres;
  for (Eigen::Index k = 0; groups.cols() > 1 && k < groups.cols(); ++k)
    centres.push_back({.p = {groups.col(k).begin(), groups.col(k).end()}});
  return centres;
}

Result<std::vector<ModeRow>> measure_reduced(const Frames& frames, const Model& model, const Hooks& hooks) {
  auto made = ReducedMotion::make(model.hierarchy(), model.learned->pca);
  if (!made) return tl::unexpected(made.error());
  const auto motion = std::make_shared<const ReducedMotion>(std::move(*made));
  ReducedHooks building;
  building.progress = [&](double part) { hooks.progress(part, "balls of p"); };
  building.cancel = hooks.cancel;
  auto shape = ReducedShape::build(motion, centres_of(*model.learned), {}, building);
  if (!shape) return tl::unexpected(shape.error());
  const ReducedFilm film = reduce(frames, model.learned->pca, *motion);

  ReducedChecker reduced({{std::make_shared<const ReducedShape>(std::move(*shape)), model.charts}});
  const auto answer_reduced = [&](Index step, StepResult& out) {
    const auto pose = [&](Index k) {
      return ReducedPose{.p = {film.p[k].data(), static_cast<std::size_t>(film.p[k].size())}};
    };
    const ReducedPose from[] = {pose(step)}, to[] = {pose(step + 1)};
    return reduced.check(from, to, {}, out);
  };
  // The tolerance of a reduced answer is chosen without looking at vertices; the same for all, so that
  // answers compare.
  StepResult answer;
  std::vector<double> tolerances;
  for (Index step = 0; step + 1 < frames.size(); ++step) {
    if (auto done = answer_reduced(step, answer); !done) return tl::unexpected(done.error());
    tolerances.push_back(answer.tolerance);
  }
  const auto full = [&](const char* name, StepChecker checker, bool certificates) -> Way {
    const auto owned = std::make_shared<StepChecker>(std::move(checker));
    return {name, [&film, &tolerances, owned, certificates](Index step, StepResult& out) {
              return check(*owned, film.frames, step,
                           {.tolerance = tolerances[step], .certificates = certificates, .ahead = false},
                           out);
            }};
  };
  const std::vector<Way> ways{full("plain hierarchies", StepChecker({model.hierarchy()}), false),
                              full("certificates, model", StepChecker({model.object()}), true),
                              {"reduced", answer_reduced}};
  return Comparison(static_cast<Index>(frames.size() - 1), hooks).run(ways);
}

/// A looser test than boxes around vertices may leave more.
std::string removed_text(double share) {
  return share >= 0 ? fmt::format("{:.1f} %", 100 * share)
                    : fmt::format("none, {:.2g} times as many", 1 - share);
}

std::string rows_of(const std::vector<ModeRow>& modes) {
  std::string text =
      "| mode | ms per step | leaf pairs per step | removed | steps without any | collisions | missed | "
      "extra |\n"
      "|---|---|---|---|---|---|---|---|\n";
  for (const ModeRow& mode : modes) {
    text += fmt::format("| {}{} | {:.3g} | {} | {} | {} | {} | {} | {} |\n", mode.name,
                        mode.statistical ? " (statistical)" : "", mode.milliseconds,
                        grouped(static_cast<std::uint64_t>(std::llround(mode.leaf_pairs))),
                        removed_text(mode.removed), mode.empty_steps, grouped(mode.collisions),
                        grouped(mode.misses), grouped(mode.extra));
  }
  return text;
}

}  // namespace

Result<std::vector<std::vector<double>>> read_frames(Motion& motion) {
  std::vector<std::vector<double>> frames(motion.frame_count());
  for (Index k = 0; k < motion.frame_count(); ++k) {
    frames[k].resize(std::size_t{motion.topology().vertex_count()} * 3);
    if (const auto done = motion.read_frame(k, frames[k]); !done) return tl::unexpected(done.error());
  }
  return frames;
}

Result<Measured> measure(Subject& subject, const Model& model, const Hooks& hooks) {
  const auto frames = read_frames(*subject.motion);
  if (!frames) return tl::unexpected(frames.error());
  Measured measured;
  measured.steps = static_cast<Index>(frames->size() - 1);
  auto modes = measure_full(*frames, model, hooks, measured.worst);
  if (!modes) return tl::unexpected(modes.error());
  measured.modes = std::move(*modes);
  if (!model.learned || model.learned->pca.modes() == 0) return measured;
  auto reduced = measure_reduced(*frames, model, hooks);
  if (!reduced) return tl::unexpected(reduced.error());
  measured.reduced = std::move(*reduced);
  measured.reduced_modes = model.learned->pca.modes();
  return measured;
}

std::string table_of(const Measured& measured) {
  std::string text =
      fmt::format("{}, as they are:\n\n{}", counted(measured.steps, "step"), rows_of(measured.modes));
  if (measured.reduced.empty()) return text;
  return text + fmt::format("\nThe same motion in the subspace, told by {} per frame:\n\n{}",
                            counted(measured.reduced_modes, "number"), rows_of(measured.reduced));
}

}  // namespace foldproof::reproduce
