#include "base/try.h"
#include "foldproof/contacts.h"

namespace foldproof {
namespace {

// Positions of all objects at one time, kept.
class KeptPositions {
 public:
  void keep(Positions x) {
    objects_.resize(x.size());
    spans_.clear();
    for (std::size_t i = 0; i < x.size(); ++i) {
      objects_[i].assign(x[i].begin(), x[i].end());
      spans_.emplace_back(objects_[i]);
    }
  }
  Positions positions() const { return spans_; }

 private:
  std::vector<std::vector<double>> objects_;
  std::vector<std::span<const double>> spans_;
};

}  // namespace

Result<void> find_contacts(const std::vector<Object>& objects,
                           const std::function<Result<std::optional<MotionFrame>>()>& next,
                           const std::function<void(Contact)>& ended, const StepSettings& settings,
                           Parts parts, std::shared_ptr<const PairFilter> filter) {
  if (settings.declared_free != nullptr || settings.earliest_only) {
    return fail(ErrorCode::InvalidArgument, "settings", "do not ask for all collisions",
                "leave declared_free and earliest_only out to find contacts");
  }
  std::vector<const Topology*> topologies;
  topologies.reserve(objects.size());
  for (const Object& object : objects) topologies.push_back(&object.hierarchy()->topology());
  auto finder = FOLDPROOF_TRY(ContactFinder::make(std::move(topologies), std::move(parts), filter));
  const auto first = FOLDPROOF_TRY(next());
  if (!first) return {};
  StepChecker checker(objects, std::move(filter));
  StaticResult crossings;
  FOLDPROOF_TRY(checker.check_static(first->x, settings, crossings));
  finder.start(first->time, first->x, crossings);
  KeptPositions last;
  last.keep(first->x);
  double last_time = first->time;
  StepResult step;
  while (true) {
    const auto frame = FOLDPROOF_TRY(next());
    if (!frame) break;
    FOLDPROOF_TRY(checker.check(last.positions(), frame->x, settings, step));
    const bool asks = !step.lists_all() || !finder.is_known();
    if (asks) FOLDPROOF_TRY(checker.check_static(frame->x, settings, crossings));
    finder.step(last_time, frame->time, last.positions(), frame->x, step, asks ? &crossings : nullptr);
    for (Contact& contact : finder.take_ended()) ended(std::move(contact));
    last.keep(frame->x);
    last_time = frame->time;
  }
  for (Contact& contact : finder.finish()) ended(std::move(contact));
  return {};
}

}  // namespace foldproof
