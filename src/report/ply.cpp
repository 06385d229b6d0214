#include <fmt/format.h>

#include <charconv>

#include "base/try.h"
#include "report/joined.h"

namespace foldproof {
namespace {

/// A path with at most one "%d" or "%04d" in it.
struct Pattern {
  std::string before, after;
  bool numbered = false;
  int width = 0;

  std::string name(std::uint64_t number) const {
    return numbered ? fmt::format("{}{:0{}}{}", before, number, width, after) : before;
  }
};

Result<Pattern> parse_pattern(const std::string& path) {
  const std::size_t percent = path.find('%');
  if (percent == std::string::npos) return Pattern{.before = path, .after = {}};
  const std::size_t d = path.find_first_not_of("0123456789", percent + 1);
  int width = 0;
  const bool has_width = d != std::string::npos && d > percent + 1;
  if (has_width) std::from_chars(path.data() + percent + 1, path.data() + d, width);
  if (d == std::string::npos || path[d] != 'd' || width > 20 || (has_width && path[percent + 1] != '0') ||
      path.find('%', d) != std::string::npos) {
    return fail(ErrorCode::InvalidArgument, "--ply",
                fmt::format("'{}' has a '%' that is not one %d or %04d", path),
                "use one %d or %04d where the frame number goes, or no '%'");
  }
  return Pattern{
      .before = path.substr(0, percent), .after = path.substr(d + 1), .numbered = true, .width = width};
}

class PlyReport : public ReportWriter {
 public:
  PlyReport(Pattern pattern, Motions motions, JoinedMesh joined, Index substeps)
      : pattern_(std::move(pattern)), motions_(motions), joined_(std::move(joined)), substeps_(substeps) {}

  /// The first frame is also what is written when no step collides.
  Result<void> start(const CheckedStep& pose) override {
    mark_faces(motions_, pose, crosses_);
    contacts_.update(joined_, pose);
    kept_contacts_ = contacts_;
    joined_.pose(pose, 0, positions_);
    mark({});
    if (!pattern_.numbered || pose.collisions.sum() == 0) return {};
    return write(std::uint64_t{pose.index.frame} * substeps_);
  }

  Result<void> step(const CheckedStep& step) override {
    if (step.pose) contacts_.update(joined_, step);
    FOLDPROOF_TRY(add(step));
    if (!step.pose && !contacts_.number.empty())
      contacts_.update(joined_, step);  // of the next step's first pose
    return {};
  }

  Result<void> finish(const CheckTotals&) override { return pattern_.numbered ? Result<void>{} : write(0); }

 private:
  Result<void> add(const CheckedStep& step) {
    const std::uint64_t collisions = step.collisions.sum();
    if (pattern_.numbered) {
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
    mark_faces(motions_, step, collides);
    mark(collides);
  }

  /// Marks each face: bit 0 if it collides, bit 1 if it crosses in the first frame.
  void mark(std::span<const std::uint8_t> collides) {
    marks_.assign(joined_.topology.triangles().size(), 0);
    for (std::size_t i = 0; i < collides.size(); ++i) marks_[i] = collides[i];
    for (std::size_t i = 0; i < crosses_.size(); ++i)
      marks_[i] = static_cast<std::uint8_t>(marks_[i] | crosses_[i] << 1);
  }

  Result<void> write(std::uint64_t number) const {
    const std::array<FaceProperty, 3> properties{
        {{"mark", marks_}, {"contact", kept_contacts_.number}, {"contact_depth", kept_contacts_.depth}}};
    const std::size_t count = kept_contacts_.number.empty() ? 1 : 3;
    return write_ply_properties(pattern_.name(number), joined_.topology, positions_,
                                std::span(properties).first(count));
  }

  Pattern pattern_;
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
  auto pattern = FOLDPROOF_TRY(parse_pattern(path));
  // The mesh is written at the end of a check that may be long; make sure now that it can be written.
  FOLDPROOF_TRY(FileWriter::open(pattern.name(0)));
  auto joined = FOLDPROOF_TRY(join(motions, "--ply"));
  return std::make_unique<PlyReport>(std::move(pattern), motions, std::move(joined), settings.substeps);
}

}  // namespace foldproof
