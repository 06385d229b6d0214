#include <fmt/format.h>

#include <charconv>

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
    return fail("--ply", fmt::format("'{}' has a '%' that is not one %d or %04d", path),
                "use one %d or %04d where the frame number goes, or no '%'");
  }
  return Pattern{
      .before = path.substr(0, percent), .after = path.substr(d + 1), .numbered = true, .width = width};
}

class PlyReport : public ReportWriter {
 public:
  PlyReport(Pattern pattern, Motions motions, Joined joined, Index substeps)
      : pattern_(std::move(pattern)), motions_(motions), joined_(std::move(joined)), substeps_(substeps) {}

  /// Shown for itself where no step collides.
  Result<void> start(const CheckedStep& pose) override {
    mark_faces(motions_, pose, crosses_);
    joined_.pose(pose, 0, positions_);
    mark({});
    if (!pattern_.numbered || pose.collisions.sum() == 0) return {};
    return write(std::uint64_t{pose.place.frame} * substeps_);
  }

  Result<void> step(const CheckedStep& step) override {
    const std::uint64_t collisions = step.collisions.sum();
    if (pattern_.numbered) {
      if (collisions == 0) return {};
      keep(step);
      return write(std::uint64_t{step.place.frame} * substeps_ + step.place.substep);
    }
    if (positions_.empty() || collisions > most_collisions_) {
      keep(step);
      most_collisions_ = collisions;
    }
    return {};
  }

  Result<void> finish(const CheckTotals&) override { return pattern_.numbered ? Result<void>{} : write(0); }

 private:
  void keep(const CheckedStep& step) {
    joined_.pose(step, step.collisions.sum() > 0 ? step.earliest_toi : 0, positions_);
    std::vector<std::uint8_t> collides;
    mark_faces(motions_, step, collides);
    mark(collides);
  }

  /// Of each face, whether it collides, and whether it crosses in the first frame.
  void mark(std::span<const std::uint8_t> collides) {
    marks_.assign(joined_.topology.triangles().size(), 0);
    for (std::size_t i = 0; i < collides.size(); ++i) marks_[i] = collides[i];
    for (std::size_t i = 0; i < crosses_.size(); ++i)
      marks_[i] = static_cast<std::uint8_t>(marks_[i] | crosses_[i] << 1);
  }

  Result<void> write(std::uint64_t number) const {
    return write_ply(pattern_.name(number), joined_.topology, positions_, marks_);
  }

  Pattern pattern_;
  Motions motions_;
  Joined joined_;
  Index substeps_;
  std::uint64_t most_collisions_ = 0;
  std::vector<double> positions_;
  std::vector<std::uint8_t> marks_, crosses_;
};

}  // namespace

Result<std::unique_ptr<ReportWriter>> ply_report(const std::string& path, Motions motions,
                                                 const CheckSettings& settings) {
  auto pattern = parse_pattern(path);
  if (!pattern) return tl::unexpected(pattern.error());
  // The mesh is written at the end of a check that may be long: see now that it can be.
  if (const auto probe = FileWriter::open(pattern->name(0)); !probe) return tl::unexpected(probe.error());
  auto joined = join(motions, "--ply");
  if (!joined) return tl::unexpected(joined.error());
  return std::make_unique<PlyReport>(std::move(*pattern), motions, std::move(*joined), settings.substeps);
}

}  // namespace foldproof
