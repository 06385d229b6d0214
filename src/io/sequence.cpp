// Mesh files as the frames of a motion.
#include <fmt/format.h>

#include <filesystem>
#include <optional>
#include <utility>

#include "base/try.h"
#include "io/readers.h"
#include "system/file.h"

namespace foldproof::io {
namespace {

class MeshSequence final : public Motion {
 public:
  MeshSequence(std::string name, std::vector<std::string> paths, MotionInfo info)
      : name_(std::move(name)), paths_(std::move(paths)), info_(std::move(info)) {}

  Result<void> open(const ReadProgress& progress) {
    for (const std::string& path : paths_) modified_.push_back(time_of(path));
    auto first = FOLDPROOF_TRY(read(0, progress));
    info_.parts = std::move(first.parts);
    info_.notes.insert(info_.notes.end(), first.notes.begin(), first.notes.end());
    info_.unchecked = std::move(first.unchecked);
    topology_ = FOLDPROOF_TRY(make_topology(first.vertex_count(), std::move(first.triangles), first.lines,
                                            first.points, info_.parts));
    first_ = std::move(first.positions);
    lines_ = std::move(first.lines);
    points_ = std::move(first.points);
    return {};
  }

  const std::string& name() const override { return name_; }
  const Topology& topology() const override { return topology_; }
  const MotionInfo& info() const override { return info_; }
  Index frame_count() const override { return static_cast<Index>(paths_.size()); }

  Result<void> read_frame(Index k, std::span<double> out) override {
    FOLDPROOF_TRY(check_request(*this, k, out));
    if (k == 0) {
      std::copy(first_.begin(), first_.end(), out.begin());
      return {};
    }
    const auto mesh = FOLDPROOF_TRY(read(k));
    FOLDPROOF_TRY(check_same(k, mesh));
    std::copy(mesh.positions.begin(), mesh.positions.end(), out.begin());
    return {};
  }

 private:
  std::string with_frame(std::string where, Index k) const {
    return paths_.size() > 1 ? fmt::format("{} (frame {})", where, k) : where;
  }

  static std::filesystem::path current_directory() {
    std::error_code unknown;
    return std::filesystem::current_path(unknown);
  }

  static std::optional<std::int64_t> time_of(const std::filesystem::path& path) {
    const auto status = system::status_of(path);
    return status ? std::optional(status->modified) : std::nullopt;
  }

  Result<MeshData> read(Index k, const ReadProgress& progress = {}) const {
    // Paths are relative to where the program was when it opened the motion.
    const std::string path =
        current_directory() == directory_ ? paths_[k] : (directory_ / paths_[k]).generic_string();
    auto mesh = read_mesh(path, progress);
    if (!mesh) {
      mesh.error().where = with_frame(std::move(mesh.error().where), k);
    } else if (time_of(path) != modified_[k]) {
      return fail(ErrorCode::InvalidFile, with_frame(path, k),
                  "has been written to since the motion was opened", "open it again");
    }
    return mesh;
  }

  Result<void> check_same(Index k, const MeshData& mesh) const {
    const auto different = [&](std::string problem) {
      return fail(ErrorCode::InvalidFile, with_frame(paths_[k], k), std::move(problem),
                  extension_of(paths_[k]) == ".stl"
                      ? "export OBJ or PLY: STL does not number vertices, so those at one place are one"
                      : "give frames of one mesh, with the same faces in the same order, or separate meshes "
                        "(--separate)");
    };
    if (mesh.vertex_count() != topology_.vertex_count()) {
      return different(fmt::format("has {} vertices, but the first frame has {}", mesh.vertex_count(),
                                   topology_.vertex_count()));
    }
    const auto expected = topology_.faces();
    const std::span<const Triangle> found = mesh.triangles;
    for (Index i = 0; i < std::min(found.size(), expected.size()); ++i) {
      if (found[i] == expected[i]) continue;
      return different(
          fmt::format("face {} differs from the first frame's: triangle ({} {} {}) instead of ({} {} {}), "
                      "counting from 0",
                      mesh.face_of(i), found[i][0], found[i][1], found[i][2], expected[i][0], expected[i][1],
                      expected[i][2]));
    }
    if (found.size() != expected.size()) {
      return different(
          fmt::format("has {} triangles, but the first frame has {}", found.size(), expected.size()));
    }
    if (mesh.unchecked != info_.unchecked)
      return different("has other things than the first frame that are not checked");
    if (mesh.lines != lines_ || mesh.points != points_)
      return different("has other lines or points than the first frame");
    return {};
  }

  std::string name_;
  std::vector<std::string> paths_;
  std::vector<std::optional<std::int64_t>> modified_;      // when the motion was opened
  std::filesystem::path directory_ = current_directory();  // the same
  Topology topology_;
  MotionInfo info_;
  std::vector<double> first_;  // positions of frame 0, which open() reads
  std::vector<Edge> lines_;    // of frame 0, as the file has them
  std::vector<Index> points_;
};

}  // namespace

Result<std::unique_ptr<Motion>> open_sequence(std::string name, std::vector<std::string> paths,
                                              const ReadProgress& progress, MotionInfo info) {
  auto motion = std::make_unique<MeshSequence>(std::move(name), std::move(paths), std::move(info));
  FOLDPROOF_TRY(motion->open(progress));
  return motion;
}

}  // namespace foldproof::io
