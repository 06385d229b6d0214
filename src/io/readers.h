/// What the readers of the single formats share.
#pragma once

#include <memory>
#include <string_view>
#include <vector>

#include "foldproof/io.h"

namespace foldproof::io {

/// One mesh as a file gives it. Polygons become fans around their first vertex: (0,1,2), (0,2,3), ... The
/// choice looks at ids alone, so it is the same in every frame.
struct MeshData {
  std::vector<double> positions;  ///< vertex_count x 3.
  std::vector<Triangle> triangles;
  std::vector<Index> faces;  ///< The file's face of each triangle; empty while every face is a triangle.

  Index vertex_count() const { return static_cast<Index>(positions.size() / 3); }
  /// At least three vertices.
  void add_polygon(std::span<const Index> polygon);
  /// The file's face that triangle `i` came from.
  Index face_of(Index i) const { return faces.empty() ? i : faces[i]; }
};

/// Ids must fit an Index, edges (three per triangle) included.
inline constexpr std::uint64_t kMaxVertices = kNoIndex - 1;
inline constexpr std::uint64_t kMaxTriangles = kNoIndex / 3 - 1;

/// Parses the bytes of a mesh file; `path` is for errors. On success every index is in range and every
/// coordinate is finite; the mesh may be empty.
Result<MeshData> parse_obj(const std::string& path, std::string_view bytes);
Result<MeshData> parse_off(const std::string& path, std::string_view bytes);
Result<MeshData> parse_ply(const std::string& path, std::string_view bytes);
/// Reads and parses a mesh file, by its extension. On success there are vertices and triangles besides, few
/// enough to be numbered.
Result<MeshData> read_mesh(const std::string& path);

/// Error at the first coordinate that is not finite: "<where>, vertex 7".
Result<void> check_finite(const std::string& where, std::span<const double> positions);
/// Error when a caller asks for a frame that is not there or gives a buffer of the wrong size.
Result<void> check_request(const Motion& motion, Index frame, std::span<const double> out);

/// frame9 before frame10: runs of digits compare as numbers, everything else byte by byte.
bool natural_less(const std::string& a, const std::string& b);
/// Mesh files as frames, in the order given; one file is a motion of one frame.
Result<std::unique_ptr<Motion>> open_sequence(std::string name, std::vector<std::string> paths);
/// A mesh and its point cache.
Result<std::unique_ptr<Motion>> open_pc2(const std::string& mesh_path, const std::string& cache_path);
Result<std::unique_ptr<Motion>> open_mdd(const std::string& mesh_path, const std::string& cache_path);

/// NumPy archive with `faces` and `vertices`.
Result<std::unique_ptr<Motion>> open_npz(const std::string& path);
/// glTF or GLB, sampled at `fps`.
Result<std::unique_ptr<Motion>> open_gltf(const std::string& path, double fps);

/// The same motion with vertices merged that stand at exactly the same place in its first frame; of those the
/// first is kept, and the order of the rest stays.
Result<std::unique_ptr<Motion>> weld(std::unique_ptr<Motion> motion);

}  // namespace foldproof::io
