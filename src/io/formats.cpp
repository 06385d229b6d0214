#include "io/formats.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

namespace foldproof::io {
namespace {

Result<std::unique_ptr<Motion>> open_scene(const std::string& path, const ReadOptions& options,
                                           const ReadProgress& progress) {
  return open_gltf(path, options, progress);
}
Result<std::unique_ptr<Motion>> open_collection(const std::string& path, const ReadOptions&,
                                                const ReadProgress& progress) {
  return open_pvd(path, progress);
}

constexpr FileFormat kFormats[] = {
    {.extension = ".obj", .kind = FileKind::Mesh, .parse_mesh = parse_obj},
    {.extension = ".off", .kind = FileKind::Mesh, .parse_mesh = parse_off},
    {.extension = ".ply", .kind = FileKind::Mesh, .parse_mesh = parse_ply},
    {.extension = ".stl", .kind = FileKind::Mesh, .parse_mesh = parse_stl},
    {.extension = ".vtp", .kind = FileKind::Mesh, .parse_mesh = parse_vtp},
    {.extension = ".vtu", .kind = FileKind::Mesh, .parse_mesh = parse_vtu},
    {.extension = ".vtk", .kind = FileKind::Mesh, .parse_mesh = parse_vtk},
    {.extension = ".msh", .kind = FileKind::Mesh, .parse_mesh = parse_msh},
    {.extension = ".pc2", .kind = FileKind::PointCache, .open_cache = open_pc2},
    {.extension = ".mdd", .kind = FileKind::PointCache, .open_cache = open_mdd},
    {.extension = ".npz", .kind = FileKind::Animation, .open_animation = open_npz},
    {.extension = ".pvd", .kind = FileKind::Animation, .open_animation = open_collection},
    {.extension = ".npy", .kind = FileKind::Array},
    {.extension = ".gltf", .kind = FileKind::Animation, .open_animation = open_scene},
    {.extension = ".glb", .kind = FileKind::Animation, .open_animation = open_scene},
};

}  // namespace

const FileFormat* format_of(const std::string& path) {
  const std::string extension = extension_of(path);
  const auto found =
      std::ranges::find_if(kFormats, [&](const FileFormat& format) { return extension == format.extension; });
  return found == std::end(kFormats) ? nullptr : found;
}

std::string any_of(std::span<const std::string> extensions) {
  const std::string& last = extensions.back();
  if (extensions.size() == 1) return last;
  return fmt::format("{} or {}", fmt::join(extensions.first(extensions.size() - 1), ", "), last);
}

std::string extensions_of(FileKind kind) {
  std::vector<std::string> found;
  for (const FileFormat& format : kFormats) {
    if (format.kind == kind) found.emplace_back(format.extension);
  }
  return any_of(found);
}

bool is_kind(const std::string& path, FileKind kind) {
  const FileFormat* format = format_of(path);
  return format != nullptr && format->kind == kind;
}

}  // namespace foldproof::io
