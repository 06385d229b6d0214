/// Pictures for the HTML report: crossings of the first frame, the worst steps, and all steps together.
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

/// Collects the poses and marks that the pictures need while steps are checked.
class Snapshots {
 public:
  /// Error: the objects are too large together for one picture.
  static Result<Snapshots> open(Motions motions, Index substeps);

  /// Adds the crossings of the first frame, before all steps, if they are tested.
  void start(const CheckedStep& pose);
  void add(const CheckedStep& step);
  /// Pictures of the first frame if something crosses in it, of the worst steps, and of all steps together.
  /// Cost: about half a second per picture of 70,000 triangles.
  Result<std::vector<Snapshot>> draw(const CheckTotals& totals) const;

 private:
  struct StoredStep {
    StepIndex index;
    CollisionCounts collisions;
    double toi = 0;
    std::vector<double> positions;
    std::vector<std::uint8_t> marks;  ///< Per triangle: kCollides, kCrossesAtStart.
  };
  Snapshots(Motions motions, Index substeps, JoinedMesh joined)
      : motions_(motions), substeps_(substeps), joined_(std::move(joined)) {}
  bool starts_crossing() const { return start_ && start_->collisions.sum() > 0; }
  Result<std::string> draw(const StoredStep& stored) const;
  std::string caption(const StoredStep& stored) const;
  std::string caption_of_start() const;
  std::string caption_of_all(bool stopped) const;

  Motions motions_;
  Index substeps_;
  JoinedMesh joined_;
  std::vector<StoredStep> worst_;  // by collisions, descending; equal ones in order
  StoredStep all_;                 // the first pose, with the marks and counts of all steps
  std::optional<StoredStep> start_;
  std::uint64_t steps_ = 0;
  std::vector<std::uint8_t> marks_;
};

}  // namespace foldproof
