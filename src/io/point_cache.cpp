// Point caches, PC2 and MDD, that move a mesh. One pread per frame; the header's counts are checked against
// the size of the file before anything is allocated.
#include <fmt/format.h>

#include "base/try.h"
#include "io/bytes.h"
#include "io/readers.h"

namespace foldproof::io {
namespace {

/// How the frames are stored in the file.
struct Layout {
  std::uint64_t vertices = 0;
  std::uint64_t frames = 0;
  std::uint64_t data = 0;  ///< Offset of the first frame, bytes.
  std::endian order = std::endian::little;
};

class PointCache final : public Motion {
 public:
  PointCache(std::string name, InputFile file, Layout layout, Topology topology, MotionInfo info)
      : name_(std::move(name)),
        topology_(std::move(topology)),
        info_(std::move(info)),
        file_(std::move(file)),
        layout_(layout) {}

  const std::string& name() const override { return name_; }
  const Topology& topology() const override { return topology_; }
  const MotionInfo& info() const override { return info_; }
  Index frame_count() const override { return static_cast<Index>(layout_.frames); }

  Result<void> read_frame(Index k, std::span<double> out) override {
    FOLDPROOF_TRY(check_request(*this, k, out));
    buffer_.resize(out.size() * sizeof(float));
    FOLDPROOF_TRY(file_.read_at(layout_.data + k * std::uint64_t{buffer_.size()}, buffer_));
    for (std::size_t i = 0; i < out.size(); ++i) {
      out[i] = static_cast<double>(load<float>(buffer_.data() + i * sizeof(float), layout_.order));
    }
    return check_finite(fmt::format("{}, frame {}", file_.path(), k), out);
  }

 private:
  std::string name_;
  Topology topology_;
  MotionInfo info_;
  InputFile file_;
  Layout layout_;
  std::vector<char> buffer_;
};

Result<void> check_layout(const InputFile& file, const Layout& layout, Index mesh_vertices,
                          const std::string& mesh_path) {
  if (layout.frames == 0)
    return fail(ErrorCode::InvalidFile, file.path(), "holds no frames", "export the point cache again");
  if (layout.vertices != mesh_vertices) {
    return fail(
        ErrorCode::InvalidArgument, file.path(),
        fmt::format("moves {} points, but {} has {} vertices", layout.vertices, mesh_path, mesh_vertices),
        "name the mesh that this point cache was made from");
  }
  const std::uint64_t stride = layout.vertices * 3 * sizeof(float);
  const std::uint64_t bytes = file.size() - std::min(file.size(), layout.data);
  if (bytes % stride != 0 || bytes / stride != layout.frames) {
    return fail(ErrorCode::InvalidFile, file.path(),
                fmt::format("header announces {} frames of {} bytes, but {} bytes follow it", layout.frames,
                            stride, bytes),
                "copy or export the point cache again");
  }
  return {};
}

Result<Layout> read_pc2_header(const InputFile& file) {
  constexpr std::size_t kSize = 32;
  std::array<char, kSize> header;
  if (file.size() < kSize)
    return fail(ErrorCode::InvalidFile, file.path(), "is too short for a PC2 header",
                "export the cache again");
  FOLDPROOF_TRY(file.read_at(0, header));
  if (std::string_view(header.data(), 12) != std::string_view("POINTCACHE2\0", 12)) {
    return fail(ErrorCode::InvalidFile, at_byte(file.path(), 0), "does not start with POINTCACHE2",
                "export the cache as PC2 again");
  }
  const auto integer = [&](std::size_t at) {
    return load<std::int32_t>(header.data() + at, std::endian::little);
  };
  if (integer(12) != 1) {
    return fail(ErrorCode::UnsupportedFormat, at_byte(file.path(), 12),
                fmt::format("PC2 version {} is not known", integer(12)), "export the cache as PC2 version 1");
  }
  if (integer(16) < 0)
    return fail(ErrorCode::InvalidFile, at_byte(file.path(), 16), "the number of points is negative",
                "export the cache again");
  if (integer(28) < 0)
    return fail(ErrorCode::InvalidFile, at_byte(file.path(), 28), "the number of frames is negative",
                "export the cache again");
  return Layout{static_cast<std::uint64_t>(integer(16)), static_cast<std::uint64_t>(integer(28)), kSize,
                std::endian::little};
}

Result<Layout> read_mdd_header(const InputFile& file) {
  constexpr std::size_t kSize = 8;
  std::array<char, kSize> header;
  if (file.size() < kSize)
    return fail(ErrorCode::InvalidFile, file.path(), "is too short for an MDD header",
                "export the cache again");
  FOLDPROOF_TRY(file.read_at(0, header));
  const auto integer = [&](std::size_t at) {
    return load<std::int32_t>(header.data() + at, std::endian::big);
  };
  if (integer(0) < 0)
    return fail(ErrorCode::InvalidFile, at_byte(file.path(), 0), "the number of frames is negative",
                "export the cache again");
  if (integer(4) < 0)
    return fail(ErrorCode::InvalidFile, at_byte(file.path(), 4), "the number of points is negative",
                "export the cache again");
  const auto frames = static_cast<std::uint64_t>(integer(0));
  // A table of times, one per frame, precedes the points.
  return Layout{static_cast<std::uint64_t>(integer(4)), frames, kSize + frames * sizeof(float),
                std::endian::big};
}

Result<std::unique_ptr<Motion>> open_cache(const std::string& mesh_path, const std::string& cache_path,
                                           const ReadProgress& progress,
                                           Result<Layout> (*read_header)(const InputFile&)) {
  auto file = FOLDPROOF_TRY(InputFile::open(cache_path));
  const auto layout = FOLDPROOF_TRY(read_header(file));
  auto mesh = FOLDPROOF_TRY(read_mesh(mesh_path, progress));
  FOLDPROOF_TRY(check_layout(file, layout, mesh.vertex_count(), mesh_path));
  MotionInfo info = mesh.info();
  auto topology = FOLDPROOF_TRY(
      make_topology(mesh.vertex_count(), std::move(mesh.triangles), mesh.lines, mesh.points, info.parts));
  return std::make_unique<PointCache>(mesh_path, std::move(file), layout, std::move(topology),
                                      std::move(info));
}

}  // namespace

Result<std::unique_ptr<Motion>> open_pc2(const std::string& mesh_path, const std::string& cache_path,
                                         const ReadProgress& progress) {
  return open_cache(mesh_path, cache_path, progress, read_pc2_header);
}

Result<std::unique_ptr<Motion>> open_mdd(const std::string& mesh_path, const std::string& cache_path,
                                         const ReadProgress& progress) {
  return open_cache(mesh_path, cache_path, progress, read_mdd_header);
}

}  // namespace foldproof::io
