#include <map>

#include "check/step.h"

namespace foldproof {
namespace {

// Replaces hierarchies by those of their distinct triangles. Trained objects keep theirs, to which the charts
// belong. Empty when no triangle has copies. Objects that share a hierarchy share its distinct triangles.
std::vector<std::shared_ptr<const DistinctTriangles>> remove_copies(std::vector<Object>& objects) {
  std::map<const Hierarchy*, std::shared_ptr<const DistinctTriangles>> distinct_of;
  std::vector<std::shared_ptr<const DistinctTriangles>> all;
  bool any_copies = false;
  for (Object& object : objects) {
    const bool trained = object.charts() || object.predictor();
    auto& distinct = distinct_of[trained ? nullptr : object.hierarchy().get()];
    if (!distinct)
      distinct = trained ? std::make_shared<const DistinctTriangles>()
                         : std::make_shared<const DistinctTriangles>(object.hierarchy());
    all.push_back(distinct);
    if (!distinct->has_copies()) continue;
    object = distinct->hierarchy();
    any_copies = true;
  }
  if (!any_copies) all.clear();
  return all;
}

}  // namespace

Work& Work::operator+=(const Work& more) {
  refits += more.refits;
  node_tests += more.node_tests;
  certificate_tests += more.certificate_tests;
  certificate_passes += more.certificate_passes;
  leaf_pairs += more.leaf_pairs;
  candidates_vf += more.candidates_vf;
  candidates_ee += more.candidates_ee;
  undecided += more.undecided;
  return *this;
}

StageTimes& StageTimes::operator+=(const StageTimes& more) {
  total += more.total;
  update += more.update;
  traverse += more.traverse;
  narrow += more.narrow;
  return *this;
}

Object::Object(std::shared_ptr<const Hierarchy> hierarchy) : hierarchy_(std::move(hierarchy)) {}
Object::Object(Hierarchy hierarchy) : Object(std::make_shared<const Hierarchy>(std::move(hierarchy))) {}
Object::Object(std::shared_ptr<const ChartLibrary> charts, std::shared_ptr<const NodePredictor> predictor)
    : hierarchy_(charts->slots()->hierarchy()),
      charts_(std::move(charts)),
      predictor_(std::move(predictor)) {}

struct StepChecker::Impl {
  struct Memory {
    explicit Memory(const std::vector<Object>& objects) : pipeline(objects) {}
    Pipeline pipeline;
    LookAhead look_ahead;
  };

  explicit Impl(std::vector<Object> given) : distinct(remove_copies(given)), objects(std::move(given)) {}
  template <class Run>
  Result<void> run(Run run) {
    return run_on(
        memory, [&] { return std::make_unique<Memory>(objects); }, run);
  }

  std::vector<std::shared_ptr<const DistinctTriangles>> distinct;
  std::vector<Object> objects;  // without copies
  std::unique_ptr<Memory> memory = std::make_unique<Memory>(objects);
};

StepChecker::StepChecker(std::vector<Object> objects) : impl_(new Impl(std::move(objects))) {}
StepChecker::~StepChecker() = default;
StepChecker::StepChecker(StepChecker&&) noexcept = default;
StepChecker& StepChecker::operator=(StepChecker&&) noexcept = default;

Result<void> StepChecker::check(Positions x0, Positions x1, const StepSettings& settings, StepResult& out) {
  out.complete = false;
  return impl_->run([&](Impl::Memory& memory) {
    return check_step({memory.pipeline, &memory.look_ahead, nullptr, impl_->distinct}, x0, x1, settings, out);
  });
}

Result<void> StepChecker::check_static(Positions x, const StepSettings& settings, StaticResult& out) {
  out.complete = false;
  return impl_->run([&](Impl::Memory& memory) {
    memory.look_ahead.invalidate();
    return check_pose({memory.pipeline, nullptr, nullptr, impl_->distinct}, x, settings, out);
  });
}

}  // namespace foldproof
