/// The contacts of a motion, from the answers of its check.
#pragma once

#include "report/report.h"

namespace foldproof::inline internal {

/// One check's contacts. Times are frames, with fractions between them.
class MotionContacts {
 public:
  /// Keeps references to all arguments. `filter`: the checkers'. Null when the settings leave contacts out,
  /// or the answers are not complete: the mode paper, earliest_only.
  static Result<std::unique_ptr<MotionContacts>> make(Motions motions, const CheckSettings& settings,
                                                      const std::vector<Object>& objects,
                                                      std::shared_ptr<const PairFilter> filter);

  /// The first frame of a motion, or the next one of poses.
  void pose(const CheckedStep& pose);
  /// A step. Where its answer is cut, or what crossed before is not known, a static query finds what crosses
  /// at its end.
  Result<void> step(const CheckedStep& step);
  const ContactFinder& finder() const { return finder_; }
  /// Writes the contacts and what is known about them into `totals`. The motion is over.
  void finish(CheckTotals& totals);

 private:
  MotionContacts(const CheckSettings& settings, const std::vector<Object>& objects,
                 std::shared_ptr<const PairFilter> filter, ContactFinder finder)
      : settings_(settings), objects_(objects), filter_(std::move(filter)), finder_(std::move(finder)) {}
  void collect();
  double end_of(const StepIndex& index) const;

  const CheckSettings& settings_;
  const std::vector<Object>& objects_;
  std::shared_ptr<const PairFilter> filter_;
  ContactFinder finder_;
  std::optional<StepChecker> static_checker_;
  StaticResult crossings_;
  std::vector<Contact> ended_;
  bool started_ = false;
  double last_time_ = 0;
  std::uint64_t unknown_frames_ = 0;
  double milliseconds_ = 0;
};

}  // namespace foldproof::inline internal
