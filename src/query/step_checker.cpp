#include <atomic>
#include <map>

#include "base/plain_arithmetic.h"
#include "query/checker.h"

namespace foldproof {
namespace {

// Replaces hierarchies by those without copies, and says what these stand for. What was trained belongs to
// the hierarchy that it was trained with, which stays then. Thousands of objects may share one.
std::vector<std::shared_ptr<const DistinctTriangles>> distinct_in(
    std::vector<std::shared_ptr<const Hierarchy>>& objects,
    const std::vector<std::shared_ptr<const ChartLibrary>>& charts,
    const std::vector<std::shared_ptr<const Learned>>& learned) {
  std::map<const Hierarchy*, std::shared_ptr<const DistinctTriangles>> of;
  std::vector<std::shared_ptr<const DistinctTriangles>> all;
  bool any = false;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const bool trained = (i < charts.size() && charts[i]) || (i < learned.size() && learned[i]);
    auto& distinct = of[trained ? nullptr : objects[i].get()];
    if (!distinct)
      distinct = trained ? std::make_shared<const DistinctTriangles>()
                         : std::make_shared<const DistinctTriangles>(objects[i]);
    all.push_back(distinct);
    if (!distinct->has_copies()) continue;
    objects[i] = distinct->hierarchy();
    any = true;
  }
  if (!any) all.clear();
  return all;
}

}  // namespace

StepChecker::StepChecker(std::vector<std::shared_ptr<const Hierarchy>> objects,
                         std::vector<std::shared_ptr<const ChartLibrary>> charts,
                         std::vector<std::shared_ptr<const Learned>> learned)
    : impl_(new Impl{distinct_in(objects, charts, learned),
                     Scene(std::move(objects), std::move(charts), std::move(learned)),
                     {},
                     {}}) {}
StepChecker::~StepChecker() = default;
StepChecker::StepChecker(StepChecker&&) noexcept = default;
StepChecker& StepChecker::operator=(StepChecker&&) noexcept = default;

Result<void> check_step(const Question& question, Positions x0, Positions x1, const StepSettings& settings,
                        StepResult& out) {
  const PlainArithmetic plain;
  Scene& scene = question.scene;
  std::vector<Chunk>& chunks = question.chunks;
  Forecast* const forecast = question.forecast;
  Stopwatch total, watch;
  clear(out);
  if (auto ok = check_settings(settings); !ok) return ok;
  double side = 0;
  const bool served = forecast != nullptr && forecast->serves(scene, x0, x1, settings, side);
  if (served) {
    if (auto ok = scene.check_unused(x0, x1); !ok) return ok;
  } else {
    const Index ahead = forecast != nullptr ? forecast->steps_ahead() : 1;
    if (auto ok = scene.update(x0, x1, settings, ahead); !ok) return ok;
    side = scene.largest_side();
  }
  out.milliseconds.update = watch.lap();

  out.searched = served ? 0 : scene.ahead();
  out.tolerance = tolerance_for(settings, side);
  const double distance = settings.thickness + out.tolerance;
  if (!served) {
    scene.traverse(settings, forecast != nullptr ? forecast->begin(scene, settings, distance) : distance,
                   out.work);
  }
  std::atomic<double> earliest{1};
  NarrowStep step{scene.trees(),
                  scene.tasks(),
                  x0,
                  x1,
                  {},
                  settings.earliest_only ? &earliest : nullptr,
                  settings.max_listed,
                  question.choice,
                  question.distinct};
  step.ccd.thickness = settings.thickness;
  step.ccd.tolerance = out.tolerance;
  if (out.searched > 1) forecast->gather(step, scene.leaf_pairs(), chunks);
  out.milliseconds.traverse = watch.lap();

  if (out.searched == 1) {
    in_rounds(scene.leaf_pairs(), chunks,
              [&](std::size_t count) { test_round(step, std::span(chunks).first(count), watch, out); });
  } else {
    forecast->test(step, chunks, out);
  }
  if (!served && forecast != nullptr) forecast->note_search(out.work);
  finish(settings, out);
  out.milliseconds.narrow += watch.lap();
  out.milliseconds.total = total.lap();
  if (settings.explain) {
    scene.explain(settings, distance, out.explanation);
    spread(question.distinct, out.explanation);
  }
  return {};
}

Result<void> StepChecker::check(Positions x0, Positions x1, const StepSettings& settings, StepResult& out) {
  return check_step({impl_->scene, impl_->chunks, &impl_->forecast, nullptr, impl_->distinct}, x0, x1,
                    settings, out);
}

}  // namespace foldproof
