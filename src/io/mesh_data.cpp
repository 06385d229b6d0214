#include <fmt/format.h>

#include <cmath>
#include <numeric>

#include "base/try.h"
#include "io/bytes.h"
#include "io/formats.h"

namespace foldproof::io {
namespace {

// Error: the mesh is empty, or too large for 32-bit ids.
Result<void> check_mesh(const std::string& path, const MeshData& mesh) {
  if (mesh.positions.size() / 3 > kMaxVertices ||
      mesh.triangles.size() + mesh.lines.size() + mesh.points.size() > kMaxTriangles) {
    return fail(ErrorCode::LimitExceeded, path,
                fmt::format("has more than {} vertices or {} triangles", kMaxVertices, kMaxTriangles),
                "split the mesh");
  }
  if (mesh.positions.empty())
    return fail(ErrorCode::InvalidFile, path, "has no vertices", "export the mesh again");
  if (mesh.triangles.empty() && mesh.lines.empty() && mesh.points.empty())
    return fail(ErrorCode::InvalidFile, path, "has no faces", "export the mesh with its faces");
  return {};
}

}  // namespace

void MeshData::add_polyline(std::span<const Index> polyline) {
  if (polyline.size() == 1) points.push_back(polyline[0]);
  for (std::size_t k = 1; k < polyline.size(); ++k) {
    if (polyline[k] == polyline[k - 1]) {
      points.push_back(polyline[k]);
    } else {
      lines.push_back({polyline[k - 1], polyline[k]});
    }
  }
}

void MeshData::add_polygon(std::span<const Index> polygon) {
  if (polygon.size() > 3 && faces.empty()) {
    faces.resize(triangles.size());
    std::iota(faces.begin(), faces.end(), Index{0});
  }
  const bool mixed = polygon.size() > 3 || !faces.empty();
  const Index face = faces.empty() ? static_cast<Index>(triangles.size()) : faces.back() + 1;
  for (std::size_t k = 2; k < polygon.size(); ++k) {
    triangles.push_back({polygon[0], polygon[k - 1], polygon[k]});
    if (mixed) faces.push_back(face);
  }
}

Result<MeshData> read_mesh(const std::string& path, const ReadProgress& progress) {
  const FileFormat* format = format_of(path);
  if (format == nullptr || format->kind != FileKind::Mesh)
    return fail(ErrorCode::UnsupportedFormat, path, "is not a mesh format that is read here",
                fmt::format("give {}", extensions_of(FileKind::Mesh)));
  auto file = FOLDPROOF_TRY(read_file(path, progress));
  const std::string_view bytes(file.data(), file.size());
  auto mesh = format->parse_mesh(path, bytes);
  if (!mesh) return mesh;
  FOLDPROOF_TRY(check_mesh(path, *mesh));
  return mesh;
}

Result<void> check_finite(const std::string& where, std::span<const double> positions) {
  for (std::size_t i = 0; i < positions.size(); ++i) {
    if (!std::isfinite(positions[i])) {
      return fail(ErrorCode::NonFinite, fmt::format("{}, vertex {}", where, i / 3),
                  "a coordinate is not finite", "export the mesh without NaN or infinite coordinates");
    }
  }
  return {};
}

Result<void> check_request(const Motion& motion, Index frame, std::span<const double> out) {
  if (frame >= motion.frame_count()) {
    return fail(ErrorCode::InvalidArgument, fmt::format("{} (frame {})", motion.name(), frame),
                fmt::format("does not exist: there are {} frames, counting from 0", motion.frame_count()),
                "ask for an earlier frame");
  }
  const std::size_t needed = std::size_t{3} * motion.topology().vertex_count();
  if (out.size() != needed) {
    return fail(ErrorCode::InvalidArgument, motion.name(),
                fmt::format("a frame is {} numbers, but the buffer holds {}", needed, out.size()),
                "pass a buffer of vertex_count x 3");
  }
  return {};
}

}  // namespace foldproof::io
