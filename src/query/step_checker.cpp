#include <atomic>

#include "base/plain_arithmetic.h"
#include "query/checker.h"

namespace foldproof {

StepChecker::StepChecker(std::vector<std::shared_ptr<const Hierarchy>> objects,
                         std::vector<std::shared_ptr<const ChartLibrary>> charts,
                         std::vector<std::shared_ptr<const Learned>> learned)
    : impl_(new Impl{Scene(std::move(objects), std::move(charts), std::move(learned)), {}, {}}) {}
StepChecker::~StepChecker() = default;
StepChecker::StepChecker(StepChecker&&) noexcept = default;
StepChecker& StepChecker::operator=(StepChecker&&) noexcept = default;

Result<void> check_step(Scene& scene, std::vector<Chunk>& chunks, Forecast* forecast, Positions x0,
                        Positions x1, const StepSettings& settings, const PairChoice* choice,
                        StepResult& out) {
  const PlainArithmetic plain;
  Stopwatch total, watch;
  clear(out);
  if (auto ok = check_settings(settings); !ok) return ok;
  double side = 0;
  const bool served = forecast != nullptr && forecast->serves(scene, x0, x1, settings, side);
  if (!served) {
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
  NarrowStep step{scene.trees(), scene.tasks(), x0, x1, {}, settings.earliest_only ? &earliest : nullptr,
                  choice};
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
  if (settings.explain) scene.explain(settings, distance, out.explanation);
  return {};
}

Result<void> StepChecker::check(Positions x0, Positions x1, const StepSettings& settings, StepResult& out) {
  return check_step(impl_->scene, impl_->chunks, &impl_->forecast, x0, x1, settings, nullptr, out);
}

}  // namespace foldproof
