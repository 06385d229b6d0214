#include <atomic>

#include "query/checker.h"

namespace foldproof {

StepChecker::StepChecker(std::vector<std::shared_ptr<const Hierarchy>> objects,
                         std::vector<std::shared_ptr<const ChartLibrary>> charts,
                         std::vector<std::shared_ptr<const Learned>> learned)
    : impl_(new Impl{Scene(std::move(objects), std::move(charts), std::move(learned)), {}}) {}
StepChecker::~StepChecker() = default;
StepChecker::StepChecker(StepChecker&&) noexcept = default;
StepChecker& StepChecker::operator=(StepChecker&&) noexcept = default;

Result<void> check_step(Scene& scene, std::vector<Chunk>& chunks, Positions x0, Positions x1,
                        const StepSettings& settings, const PairChoice* choice, StepResult& out) {
  Stopwatch total, watch;
  clear(out);
  if (auto ok = check_settings(settings); !ok) return ok;
  if (auto ok = scene.update(x0, x1, settings); !ok) return ok;
  out.milliseconds.update = watch.lap();

  out.tolerance = tolerance_for(settings, scene.largest_side());
  scene.traverse(settings, settings.thickness + out.tolerance, out.work);
  out.milliseconds.traverse = watch.lap();

  std::atomic<double> earliest{1};
  NarrowStep step{scene.trees(), scene.tasks(), x0, x1, {}, settings.earliest_only ? &earliest : nullptr,
                  choice};
  step.ccd.thickness = settings.thickness;
  step.ccd.tolerance = out.tolerance;
  in_rounds(scene.leaf_pairs(), chunks,
            [&](std::size_t count) { test_round(step, std::span(chunks).first(count), watch, out); });
  finish(settings, out);
  out.milliseconds.narrow += watch.lap();
  out.milliseconds.total = total.lap();
  if (settings.explain) scene.explain(settings, settings.thickness + out.tolerance, out.explanation);
  return {};
}

Result<void> StepChecker::check(Positions x0, Positions x1, const StepSettings& settings, StepResult& out) {
  return check_step(impl_->scene, impl_->chunks, x0, x1, settings, nullptr, out);
}

}  // namespace foldproof
