#include <map>

#include "check/step.h"

namespace foldproof {
namespace {

using Distinct = std::shared_ptr<const DistinctTriangles>;

// Of an object that has copies: only those that the filter treats alike are one.
Distinct distinct_in(Index object, const std::shared_ptr<const Hierarchy>& hierarchy,
                     const PairFilter& filter) {
  std::vector<Index> kinds(hierarchy->topology().triangles().size());
  for (Index t = 0; t < kinds.size(); ++t) kinds[t] = filter.kind(object, t);
  return std::make_shared<const DistinctTriangles>(hierarchy, kinds);
}

// Replaces hierarchies by those of their distinct triangles. Trained objects keep theirs, to which the charts
// belong. Empty when no triangle has copies. Objects that share a hierarchy share its distinct triangles.
std::vector<Distinct> remove_copies(std::vector<Object>& objects, const PairFilter* filter) {
  std::map<const Hierarchy*, Distinct> distinct_of;
  std::vector<Distinct> all;
  bool any_copies = false;
  for (Object& object : objects) {
    const bool trained = object.charts() != nullptr;
    auto& distinct = distinct_of[trained ? nullptr : object.hierarchy().get()];
    if (!distinct)
      distinct = trained ? std::make_shared<const DistinctTriangles>()
                         : std::make_shared<const DistinctTriangles>(object.hierarchy());
    const auto number = static_cast<Index>(all.size());
    const bool by_kind = filter != nullptr && distinct->has_copies();
    all.push_back(by_kind ? distinct_in(number, object.hierarchy(), *filter) : distinct);
    if (!all.back()->has_copies()) continue;
    const bool layered = object.is_layered();
    object = all.back()->hierarchy();
    object.set_layered(layered);
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
Object::Object(std::shared_ptr<const ChartLibrary> charts)
    : hierarchy_(charts->slots()->hierarchy()), charts_(std::move(charts)) {}

struct StepChecker::Impl {
  struct Memory {
    Memory(const std::vector<Object>& objects, const Filter& filter) : pipeline(objects, filter) {}
    Pipeline pipeline;
    LookAhead look_ahead;
  };

  Impl(std::vector<Object> given, std::shared_ptr<const PairFilter> pairs)
      : filter(std::move(pairs)), distinct(remove_copies(given, filter.get())), objects(std::move(given)) {}
  template <class Run>
  Result<void> run(Run run) {
    return run_on(
        memory, [&] { return make_memory(); }, run);
  }
  std::unique_ptr<Memory> make_memory() const {
    return std::make_unique<Memory>(objects, Filter{filter.get(), distinct});
  }

  std::shared_ptr<const PairFilter> filter;
  std::vector<Distinct> distinct;
  std::vector<Object> objects;  // without copies
  std::unique_ptr<Memory> memory = make_memory();
};

StepChecker::StepChecker(std::vector<Object> objects, std::shared_ptr<const PairFilter> filter)
    : impl_(new Impl(std::move(objects), std::move(filter))) {}
StepChecker::~StepChecker() = default;
StepChecker::StepChecker(StepChecker&&) noexcept = default;
StepChecker& StepChecker::operator=(StepChecker&&) noexcept = default;

Result<void> StepChecker::check(Positions x0, Positions x1, const StepSettings& settings, StepResult& out) {
  out.complete = false;
  return impl_->run([&](Impl::Memory& memory) {
    return check_step({memory.pipeline, &memory.look_ahead}, x0, x1, settings, out);
  });
}

Result<void> StepChecker::check_static(Positions x, const StepSettings& settings, StaticResult& out) {
  out.complete = false;
  return impl_->run([&](Impl::Memory& memory) {
    memory.look_ahead.invalidate();
    return check_pose({memory.pipeline, nullptr, impl_->objects}, x, settings, out);
  });
}

}  // namespace foldproof
