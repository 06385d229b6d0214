#include <fmt/format.h>

#include <filesystem>
#include <system_error>

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

  /// The first frame is also what is written when no step collides.
  Result<void> start(const CheckedStep& pose) override {
    mark_faces(joined_, motions_, pose, crosses_);
    contacts_.update(joined_, pose);
    kept_contacts_ = contacts_;
    joined_.pose(pose, 0, positions_);
    mark({});
    if (!target_.pattern || pose.collisions.sum() == 0) return {};
    return write(std::uint64_t{pose.index.frame} * substeps_);
  }

  Result<void> step(const CheckedStep& step) override {
    if (step.pose) contacts_.update(joined_, step);
    FOLDPROOF_TRY(add(step));
    if (!step.pose && !contacts_.number.empty())
      contacts_.update(joined_, step);  // of the next step's first pose
    return {};
  }

  Result<void> finish(const CheckTotals&) override {
    if (!target_.pattern) FOLDPROOF_TRY(write(0));
    unfinished_.clear();
    return {};
  }

 private:
  Result<void> add(const CheckedStep& step) {
    const std::uint64_t collisions = step.collisions.sum();
    if (target_.pattern) {
      if (collisions == 0) return {};
      keep(step);
      return write(std::uint64_t{step.index.frame} * substeps_ + step.index.substep);
    }
    if (positions_.empty() || collisions > max_collisions_) {
      keep(step);
      max_collisions_ = collisions;
    }
    return {};
  }

  void keep(const CheckedStep& step) {
    kept_contacts_ = contacts_;
    joined_.pose(step, step.collisions.sum() > 0 ? step.earliest_toi : 0, positions_);
    std::vector<std::uint8_t> collides;
    mark_faces(joined_, motions_, step, collides);
    mark(collides);
  }

  /// Marks each face: bit 0 if it collides, bit 1 if it crosses in the first frame.
  void mark(std::span<const std::uint8_t> collides) {
    marks_.assign(joined_.topology.triangles().size(), 0);
    for (std::size_t i = 0; i < collides.size(); ++i) marks_[i] = collides[i];
    for (std::size_t i = 0; i < crosses_.size(); ++i)
      marks_[i] = static_cast<std::uint8_t>(marks_[i] | crosses_[i] << 1);
  }

  Result<void> write(std::uint64_t number) {
    const std::array<FaceProperty, 3> properties{
        {{"mark", marks_}, {"contact", kept_contacts_.number}, {"contact_depth", kept_contacts_.depth}}};
    const std::size_t count = kept_contacts_.number.empty() ? 1 : 3;
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
  std::uint64_t max_collisions_ = 0;
  std::vector<double> positions_;
  std::vector<std::uint8_t> marks_, crosses_;
  ContactMarks contacts_;       // of the frame at which the next step starts
  ContactMarks kept_contacts_;  // of the pose that is written
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
