#include <map>

#include "check/answer.h"
#include "check/step.h"

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
                     Pipeline(std::move(objects), std::move(charts), std::move(learned)),
                     {}}) {}
StepChecker::~StepChecker() = default;
StepChecker::StepChecker(StepChecker&&) noexcept = default;
StepChecker& StepChecker::operator=(StepChecker&&) noexcept = default;

Result<void> StepChecker::check(Positions x0, Positions x1, const StepSettings& settings, StepResult& out) {
  return check_step({impl_->pipeline, &impl_->look_ahead, nullptr, impl_->distinct}, x0, x1, settings, out);
}

Result<void> StepChecker::check_static(Positions x, const StepSettings& settings, StaticResult& out) {
  impl_->look_ahead.forget();
  return check_pose({impl_->pipeline, nullptr, nullptr, impl_->distinct}, x, settings, out);
}

}  // namespace foldproof
