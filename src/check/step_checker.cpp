#include <map>

#include "check/answer.h"
#include "check/step.h"

namespace foldproof {
namespace {

// Replaces hierarchies by those without copies, and says what these stand for. What was trained belongs to
// the hierarchy that it was trained with, which stays then. Thousands of objects may share one.
std::vector<std::shared_ptr<const DistinctTriangles>> distinct_in(std::vector<Object>& objects) {
  std::map<const Hierarchy*, std::shared_ptr<const DistinctTriangles>> of;
  std::vector<std::shared_ptr<const DistinctTriangles>> all;
  bool any = false;
  for (Object& object : objects) {
    const bool trained = object.charts() || object.predictor();
    auto& distinct = of[trained ? nullptr : object.hierarchy().get()];
    if (!distinct)
      distinct = trained ? std::make_shared<const DistinctTriangles>()
                         : std::make_shared<const DistinctTriangles>(object.hierarchy());
    all.push_back(distinct);
    if (!distinct->has_copies()) continue;
    object = distinct->hierarchy();
    any = true;
  }
  if (!any) all.clear();
  return all;
}

}  // namespace

Object::Object(std::shared_ptr<const Hierarchy> hierarchy) : hierarchy_(std::move(hierarchy)) {}
Object::Object(Hierarchy hierarchy) : Object(std::make_shared<const Hierarchy>(std::move(hierarchy))) {}
Object::Object(std::shared_ptr<const ChartLibrary> charts, std::shared_ptr<const NodePredictor> predictor)
    : hierarchy_(charts->slots()->hierarchy()),
      charts_(std::move(charts)),
      predictor_(std::move(predictor)) {}

StepChecker::StepChecker(std::vector<Object> objects)
    : impl_(new Impl{distinct_in(objects), Pipeline(objects), {}}) {}
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
