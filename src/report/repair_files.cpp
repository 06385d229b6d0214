#include "report/repair_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "base/grouped.h"
#include "base/try.h"
#include "io/gltf_repair.h"
#include "io/write_times.h"
#include "report/repair_report.h"
#include "system/file.h"

namespace foldproof {
namespace {

namespace fs = std::filesystem;

// A file per frame.
bool is_pattern(const std::string& path) { return path.find('%') != std::string::npos; }

bool has_point_cache(const std::string& path, std::size_t frames) {
  return extension_of(path) == ".obj" && frames > 1 && !is_pattern(path);
}

bool is_gltf(const std::string& path) { return extension_of(path) == ".glb"; }

Result<void> require_fits(const RepairOutputs& outputs, const std::string& path, const Motion& motion,
                          std::size_t frames) {
  const Topology& topology = motion.topology();
  if (extension_of(path) == ".npz" && topology.face_count() < topology.triangles().size())
    return fail(ErrorCode::UnsupportedFormat, path,
                "is NPZ, which holds faces alone, and there are lines or points", "name it .obj");
  if (outputs.in_betweens > 0 && extension_of(path) != ".npz" && !has_point_cache(path, frames))
    return fail(ErrorCode::UnsupportedFormat, path,
                "holds no times, which frames that --in-betweens adds need",
                frames == 1        ? "leave out --in-betweens: there is one frame"
                : is_pattern(path) ? "name it .npz, or .obj without %, which gets an MDD"
                                   : "name it .npz, or .obj, which gets an MDD");
  if (extension_of(path) == ".ply" && frames > 1 && !is_pattern(path))
    return fail(ErrorCode::UnsupportedFormat, path, "is PLY, which holds one frame",
                "name it .npz or .obj, or put %04d into the name for a file per frame");
  if (!is_gltf(path)) return {};
  if (motion.frame_count() == 1 && frames > 1)
    return fail(ErrorCode::UnsupportedFormat, path,
                fmt::format("is GLB, and {} stands still, so it has no animation to change", motion.name()),
                "name it .npz");
  return io::require_gltf_can_be_repaired(path, motion.name());
}

// Frames of a motion from one on, with what is known of another.
class ShownFrames final : public Motion {
 public:
  ShownFrames(std::unique_ptr<Motion> frames, Index first, Index count, const Motion& like)
      : frames_(std::move(frames)), first_(first), count_(count), like_(like) {}
  const std::string& name() const override { return like_.name(); }
  const Topology& topology() const override { return like_.topology(); }
  const MotionInfo& info() const override { return like_.info(); }
  Index frame_count() const override { return count_; }
  Result<void> read_frame(Index k, std::span<double> out) override {
    return frames_->read_frame(first_ + k, out);
  }

 private:
  std::unique_ptr<Motion> frames_;
  Index first_, count_;
  const Motion& like_;
};

// A file that has its name only when it was read again.
struct GltfFile {
  std::string path, unchecked;
  Index object;
  explicit GltfFile(std::string name, Index number)
      : path(std::move(name)),
        unchecked((fs::path(path).parent_path() / ("unchecked-" + fs::path(path).filename().generic_string()))
                      .generic_string()),
        object(number) {}
  GltfFile(GltfFile&&) = default;
  ~GltfFile() {
    std::error_code ignored;
    if (!unchecked.empty()) fs::remove(unchecked, ignored);
  }
};

// Whether the files show what was repaired, and nothing touches in them.
Result<void> read_again(std::span<const GltfFile> files, const RepairOutputs& outputs, Motions motions,
                        const RepairRequest& request, const RepairedMotions& done) {
  const auto first = static_cast<Index>(done.report.frames.front().time);
  const auto count = static_cast<Index>(done.report.frames.size());
  std::vector<std::unique_ptr<Motion>> shown;
  for (Index i = 0; i < motions.size(); ++i) {
    const auto file = std::ranges::find(files, i, &GltfFile::object);
    auto motion = done.motion(i);
    Index begin = 0;
    if (file != files.end()) {
      auto read = FOLDPROOF_TRY(open_motions({&file->unchecked, 1}, outputs.read));
      if (read.size() != 1 || read[0]->topology() != motions[i]->topology())
        return fail(ErrorCode::UnsupportedFormat, file->path, "would show other triangles than its source",
                    "write .npz");
      motion = std::move(read[0]);
      begin = first;
    }
    shown.push_back(std::make_unique<ShownFrames>(std::move(motion), begin, count, *motions[i]));
  }
  // Where something touches, it was listed; that nothing else does is known before rounding only.
  const bool named = request.only.empty() && request.fixed_vertices.empty();
  if (!done.report.free || (!done.report.among_fixed.empty() && !named)) return {};
  CheckSettings settings = request.check;
  for (const std::string& a : request.fixed) {
    for (const std::string& b : request.fixed) settings.ignore.push_back({a, b});
  }
  settings.frames = {};
  settings.models.clear();
  const CheckTotals totals = FOLDPROOF_TRY(run_check(shown, settings, {}));
  if (done.report.left.empty() ? totals.clean() : std::ranges::none_of(totals.contacts, done.chosen))
    return {};
  return fail(ErrorCode::UnsupportedFormat, files[0].path,
              "holds single precision, which is too coarse here: something touches again",
              "write .npz, or keep more apart (--thickness)");
}

Result<void> write_with_times(const std::string& path, Motion& motion, std::span<const double> times,
                              double fps) {
  if (extension_of(path) == ".npz") return io::write_npz(path, motion, times);
  std::vector<double> seconds;
  seconds.reserve(times.size());
  for (const double time : times) seconds.push_back(time / fps);
  return io::write_obj_mdd(path, fs::path(path).replace_extension(".mdd").generic_string(), motion, seconds);
}

}  // namespace

std::string how_often_given(std::size_t count) {
  return count == 1 ? "once" : fmt::format("{} times", count);
}

bool is_single_precision(const std::string& path, std::size_t frames) {
  return has_point_cache(path, frames);
}

Result<void> require_outputs_fit(const RepairOutputs& outputs, Motions motions,
                                 std::span<const Index> movable, std::size_t frames) {
  if (outputs.paths.size() != movable.size()) {
    return fail(ErrorCode::InvalidArgument, "-o",
                fmt::format("is given {}, but {} may move", how_often_given(outputs.paths.size()),
                            counted(movable.size(), "object")),
                "give it once for each of these, in order");
  }
  for (std::size_t i = 0; i < movable.size(); ++i)
    FOLDPROOF_TRY(require_fits(outputs, outputs.paths[i], *motions[movable[i]], frames));
  return {};
}

Result<void> write_outputs(const RepairOutputs& outputs, Motions motions, const RepairRequest& request,
                           const RepairedMotions& done) {
  std::vector<double> times;
  for (const RepairedFrame& frame : done.report.frames) times.push_back(frame.time);
  const CheckVerdict verdict = repair_verdict(motions, request, done.report);
  std::vector<GltfFile> files;
  for (std::size_t i = 0; i < done.movable.size(); ++i) {
    const std::string& path = outputs.paths[i];
    if (!is_gltf(path)) continue;
    const Index object = done.movable[i];
    files.emplace_back(path, object);
    FOLDPROOF_TRY(io::write_gltf_repair(files.back().unchecked, motions[object]->name(), outputs.read,
                                        *done.motion(object), static_cast<Index>(times.front()),
                                        {verdict.sentence.text(), verdict.kind == CheckVerdictKind::Free}));
  }
  if (!files.empty()) FOLDPROOF_TRY(read_again(files, outputs, motions, request, done));
  for (GltfFile& file : files) {
    if (const std::error_code code = system::rename(file.unchecked, file.path))
      return fail(ErrorCode::FileAccess, file.path, "cannot be written: " + code.message(),
                  "name another file");
  }
  for (std::size_t i = 0; i < done.movable.size(); ++i) {
    const std::string& path = outputs.paths[i];
    const auto motion = done.motion(done.movable[i]);
    if (is_gltf(path)) continue;
    FOLDPROOF_TRY(outputs.in_betweens > 0 ? write_with_times(path, *motion, times, outputs.read.fps)
                                          : write_motion(path, *motion));
  }
  return {};
}

}  // namespace foldproof
