#include <fmt/format.h>

#include <filesystem>
#include <system_error>
#include <tuple>
#include <utility>

#include "base/try.h"
#include "io/numbered.h"
#include "report/joined.h"

namespace foldproof {
namespace {

/// Where a step's mesh is written.
struct Target {
  std::string path;
  std::optional<io::NumberPattern> pattern;  ///< None: one mesh.

  std::string name(std::uint64_t number) const { return pattern ? pattern->name(number) : path; }
};

class PlyReport : public ReportWriter {
 public:
  PlyReport(Target target, Motions motions, JoinedMesh joined, Index substeps)
      : target_(std::move(target)), motions_(motions), joined_(std::move(joined)), substeps_(substeps) {}

  PlyReport(const PlyReport&) = delete;
  PlyReport& operator=(const PlyReport&) = delete;
  /// A report appears whole or not at all.
  ~PlyReport() override {
    std::error_code ignored;
    for (const std::string& path : unfinished_) std::filesystem::remove(path, ignored);
  }

  Result<void> start(const CheckedStep& pose) override {
    now_.update(joined_, motions_, pose);
    begun_ = true;
    return {};
  }

  Result<void> step(const CheckedStep& step) override {
    // Without an answer for the first frame, nothing is known of it.
    if (!std::exchange(begun_, true)) now_.inside.assign(joined_.topology.triangles().size(), 0);
    if (step.pose) now_.update(joined_, motions_, step);
    FOLDPROOF_TRY(add(step));
    if (step.pose) return {};
    now_.update(joined_, motions_, step);  // the frame of the next step, or the last one
    if (step.index.frame == step.index.next_frame) return {};
    last_number_ = std::uint64_t{step.index.next_frame} * substeps_;
    joined_.pose(step, 1, end_);
    return {};
  }

  Result<void> finish(const CheckTotals&) override {
    if (last_number_ && (target_.pattern ? now_.count > 0 : is_worse({now_.deepest, now_.count, 0}))) {
      std::swap(positions_, end_);
      kept_ = now_;
      meets_.assign(meets_.size(), 0);
      if (target_.pattern) FOLDPROOF_TRY(write(*last_number_));
    }
    if (!target_.pattern) FOLDPROOF_TRY(write(0));
    unfinished_.clear();
    return {};
  }

 private:
  /// How bad a frame is: the depth, how many faces are inside, how many pairs collide before the next.
  using Badness = std::tuple<double, std::uint64_t, std::uint64_t>;
  bool is_worse(const Badness& other) const { return positions_.empty() || other > worst_; }

  std::uint64_t number_of(const CheckedStep& step) const {
    return std::uint64_t{step.index.frame} * substeps_ + step.index.substep;
  }

  /// The frame at the step's begin, whose marks are those of now_.
  Result<void> add(const CheckedStep& step) {
    const std::uint64_t collisions = step.pose ? 0 : step.collisions.sum();
    const Badness badness{now_.deepest, now_.count, collisions};
    if (target_.pattern ? now_.count == 0 && collisions == 0 : !is_worse(badness)) return {};
    worst_ = badness;
    kept_ = now_;
    joined_.pose(step, now_.count == 0 && collisions > 0 ? step.earliest_toi : 0, positions_);
    mark_meeting(joined_, motions_, step, meets_);
    return target_.pattern ? write(number_of(step)) : Result<void>();
  }

  Result<void> write(std::uint64_t number) {
    std::vector<std::uint8_t> marks = kept_.inside;
    for (std::size_t i = 0; i < marks.size(); ++i)
      marks[i] = static_cast<std::uint8_t>(marks[i] | meets_[i] << 1);
    const std::array<FaceProperty, 3> properties{
        {{"mark", marks}, {"contact", kept_.number}, {"contact_depth", kept_.depth}}};
    const std::size_t count = kept_.number.empty() ? 1 : 3;
    FOLDPROOF_TRY(write_ply_properties(target_.name(number), joined_.topology, positions_,
                                       std::span(properties).first(count)));
    unfinished_.push_back(target_.name(number));
    return {};
  }

  Target target_;
  std::vector<std::string> unfinished_;  // written, before the whole report is
  Motions motions_;
  JoinedMesh joined_;
  Index substeps_;
  bool begun_ = false;
  InsideMarks now_;  // of the frame at which the next step starts
  // Of the frame that is written.
  InsideMarks kept_;
  Badness worst_;
  std::vector<double> positions_;
  std::vector<std::uint8_t> meets_;
  std::optional<std::uint64_t> last_number_;  // of the last frame, if there is motion; its pose is end_
  std::vector<double> end_;
};

}  // namespace

Result<std::unique_ptr<ReportWriter>> ply_report(const std::string& path, Motions motions,
                                                 const CheckSettings& settings) {
  Target target{path, io::number_pattern(path)};
  if (!target.pattern && path.find('%') != std::string::npos) {
    return fail(ErrorCode::InvalidArgument, "--ply",
                fmt::format("'{}' has a '%' that is not one %d or %04d in its name", path),
                "use one %d or %04d where the frame number goes, or no '%'");
  }
  // The mesh is written at the end of a check that may be long; make sure now that it can be written.
  FOLDPROOF_TRY(FileWriter::open(target.name(0)));
  auto joined = FOLDPROOF_TRY(join(motions, "--ply"));
  return std::make_unique<PlyReport>(std::move(target), motions, std::move(joined), settings.substeps);
}

}  // namespace foldproof
