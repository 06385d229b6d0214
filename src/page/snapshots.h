/// Pictures for the mailed report: what crosses at the start, the worst steps, and all of them together.
#pragma once

#include "page/page.h"
#include "picture/picture.h"
#include "report/joined.h"

namespace foldproof {

struct Snapshot {
  std::optional<std::uint64_t> step;  ///< None for the first frame, and for all steps together.
  std::string caption;
  std::string png;
};

/// Looks at steps as they come and keeps what pictures of the worst need: a few poses.
class Snapshots {
 public:
  /// Error: the objects are too large together for one picture.
  static Result<Snapshots> open(Motions motions, Index substeps);

  /// What crosses in the first frame, before all steps, where that is asked.
  void start(const CheckedStep& pose);
  void look(const CheckedStep& step);
  /// What crosses in the first frame, the worst steps, then all of them together. Cost: about half a second a
  /// picture of 70,000 triangles.
  Result<std::vector<Snapshot>> draw(const CheckTotals& totals) const;

 private:
  struct Kept {
    StepPlace place;
    CollisionCounts collisions;
    double toi = 0;
    std::vector<double> positions;
    std::vector<std::uint8_t> marks;  ///< Per triangle, kCollides when it does.
  };
  Snapshots(Motions motions, Index substeps, Joined joined)
      : motions_(motions), substeps_(substeps), joined_(std::move(joined)) {}
  bool starts_crossing() const { return start_ && start_->collisions.sum() > 0; }
  Result<std::string> draw(const Kept& kept) const;
  std::string caption(const Kept& kept) const;
  std::string caption_of_start() const;
  std::string caption_of_all(bool stopped) const;

  Motions motions_;
  Index substeps_;
  Joined joined_;
  std::vector<Kept> worst_;  // most collisions first, of equals the first
  Kept all_;                 // the first pose; the sum of all steps
  std::optional<Kept> start_;
  std::uint64_t steps_ = 0;
  std::vector<std::uint8_t> marks_;
};

}  // namespace foldproof
