#include "report/motion_contacts.h"

#include <algorithm>
#include <chrono>

#include "base/try.h"

namespace foldproof::internal {
namespace {

using Clock = std::chrono::steady_clock;

double milliseconds_since(Clock::time_point begin) {
  return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

}  // namespace

Result<std::unique_ptr<MotionContacts>> MotionContacts::make(Motions motions, const CheckSettings& settings,
                                                             const std::vector<Object>& objects,
                                                             std::shared_ptr<const PairFilter> filter) {
  if (!settings.contacts || settings.paper_miss_rate || settings.step.earliest_only) return nullptr;
  std::vector<const Topology*> topologies;
  topologies.reserve(motions.size());
  for (const auto& motion : motions) topologies.push_back(&motion->topology());
  Parts parts;
  parts.reserve(motions.size());
  for (Index i = 0; i < motions.size(); ++i) parts.emplace_back(parts_of(i, motions, settings).of_triangle);
  auto finder = FOLDPROOF_TRY(ContactFinder::make(std::move(topologies), std::move(parts), filter));
  return std::unique_ptr<MotionContacts>(
      new MotionContacts(settings, objects, std::move(filter), std::move(finder)));
}

double MotionContacts::end_of(const StepIndex& index) const {
  if (index.substep + 1 == settings_.substeps) return index.next_frame;
  return index.frame + (index.substep + 1.0) / settings_.substeps * (index.next_frame - index.frame);
}

void MotionContacts::collect() {
  for (Contact& contact : finder_.take_ended()) ended_.push_back(std::move(contact));
}

void MotionContacts::pose(const CheckedStep& pose) {
  const auto begin = Clock::now();
  const double time = pose.index.frame;
  if (std::exchange(started_, true)) {
    finder_.step(last_time_, time, pose.x0, pose.x0, StepResult(), pose.pose);
  } else {
    finder_.start(time, pose.x0, *pose.pose);
  }
  unknown_frames_ += !finder_.is_known();
  last_time_ = time;
  collect();
  milliseconds_ += milliseconds_since(begin);
}

Result<void> MotionContacts::step(const CheckedStep& step) {
  const auto begin = Clock::now();
  const bool asks = started_ && (!step.step->lists_all() || !finder_.is_known());
  if (asks) {
    if (!static_checker_) static_checker_.emplace(objects_, filter_);
    FOLDPROOF_TRY(static_checker_->check_static(step.x1, settings_.step, crossings_));
  }
  if (step.index.number == 0) last_time_ = step.index.frame;
  const double end = end_of(step.index);
  finder_.step(last_time_, end, step.x0, step.x1, *step.step, asks ? &crossings_ : nullptr);
  unknown_frames_ += !started_ && step.index.number == 0;  // the first frame, with steps_only
  unknown_frames_ += !finder_.is_known() && end != last_time_;
  last_time_ = end;
  collect();
  milliseconds_ += milliseconds_since(begin);
  return {};
}

void MotionContacts::finish(CheckTotals& totals) {
  for (Contact& contact : finder_.finish()) ended_.push_back(std::move(contact));
  std::sort(ended_.begin(), ended_.end(), is_worse);
  totals.contacts = std::move(ended_);
  totals.contacts_found = true;
  totals.contact_unknown_frames = unknown_frames_;
  totals.contact_milliseconds = milliseconds_;
}

}  // namespace foldproof::internal
