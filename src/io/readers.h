/// Shared by the readers of all formats.
#pragma once

#include <memory>
#include <string_view>
#include <vector>

#include "io/progress.h"

namespace foldproof::io {

/// A mesh as read from a file. Polygons become fans around their first vertex: (0,1,2), (0,2,3), ... This
/// depends on ids alone, so it is the same in every frame.
struct MeshData {
  std::vector<double> positions;  ///< vertex_count x 3.
  std::vector<Triangle> triangles;
  std::vector<Index> faces;  ///< The file's face of each triangle; empty if every face is a triangle.
  ObjectParts parts;         ///< Those that the file names.
  /// As the file has them, of two different vertices each; some may be edges of triangles, or copies.
  std::vector<Edge> lines;
  std::vector<Index> points;           ///< That the file names as such; some may be in triangles and lines.
  std::vector<std::string> notes;      ///< As MotionInfo has them.
  std::vector<std::string> unchecked;  ///< The same.

  /// What a motion says of it.
  MotionInfo info() const { return {.parts = parts, .notes = notes, .unchecked = unchecked}; }
  Index vertex_count() const { return static_cast<Index>(positions.size() / 3); }
  /// At least three vertices.
  void add_polygon(std::span<const Index> polygon);
  /// Its segments become lines; a single vertex, and a segment from a vertex to itself, becomes a point.
  void add_polyline(std::span<const Index> polyline);
  /// The file's face that triangle `i` came from.
  Index face_of(Index i) const { return faces.empty() ? i : faces[i]; }
};

/// Ids of vertices, triangles and edges (up to three per triangle) must fit an Index.
inline constexpr std::uint64_t kMaxVertices = kNoIndex - 1;
inline constexpr std::uint64_t kMaxTriangles = Topology::kMaxTriangles;

/// Parses the bytes of a mesh file; `path` is for errors. On success every index is in range and every
/// coordinate is finite; the mesh may be empty.
Result<MeshData> parse_obj(const std::string& path, std::string_view bytes);
Result<MeshData> parse_off(const std::string& path, std::string_view bytes);
Result<MeshData> parse_ply(const std::string& path, std::string_view bytes);
/// Corners at exactly the same place are one vertex.
Result<MeshData> parse_stl(const std::string& path, std::string_view bytes);
/// VTK's polygons, and cells: surfaces and the boundary of volumes.
Result<MeshData> parse_vtp(const std::string& path, std::string_view bytes);
Result<MeshData> parse_vtu(const std::string& path, std::string_view bytes);
/// VTK's legacy files, of polygons or cells.
Result<MeshData> parse_vtk(const std::string& path, std::string_view bytes);
/// Gmsh's surfaces and the boundary of its volumes.
Result<MeshData> parse_msh(const std::string& path, std::string_view bytes);
/// Reads and parses a mesh file, by its extension. On success it also has vertices and triangles, no more
/// than the maxima above.
Result<MeshData> read_mesh(const std::string& path, const ReadProgress& progress = {});

/// Error at the first coordinate that is not finite: "<where>, vertex 7".
Result<void> check_finite(const std::string& where, std::span<const double> positions);
/// Error: the frame does not exist, or the buffer has the wrong size.
Result<void> check_request(const Motion& motion, Index frame, std::span<const double> out);

/// Natural order, frame9 before frame10: runs of digits compare as numbers, the rest byte by byte.
bool natural_less(const std::string& a, const std::string& b);
/// Mesh files as the frames of a motion, in the given order. `info`: the motion's, to which it adds.
Result<std::unique_ptr<Motion>> open_sequence(std::string name, std::vector<std::string> paths,
                                              const ReadProgress& progress = {}, MotionInfo info = {});
/// The same of files that are frames by their names, in natural order, with notes on what their numbers leave
/// out. Error: notes_on_order's; they have different formats.
Result<std::unique_ptr<Motion>> open_numbered(std::string name, std::vector<std::string> files,
                                              const ReadProgress& progress);
/// Error, of the code Ambiguous: the frames, which are files in this order, look like bodies: every one is
/// far from the one before (docs/formats.md). Frames that cannot be read say nothing.
Result<void> require_frames(Motion& motion, std::span<const std::string> files);
/// A mesh and its point cache.
Result<std::unique_ptr<Motion>> open_pc2(const std::string& mesh_path, const std::string& cache_path,
                                         const ReadProgress& progress);
Result<std::unique_ptr<Motion>> open_mdd(const std::string& mesh_path, const std::string& cache_path,
                                         const ReadProgress& progress);

/// NumPy archive with `faces` and `vertices`; merges vertices by its array `merged` unless ReadOptions::weld
/// says so.
Result<std::unique_ptr<Motion>> open_npz(const std::string& path, const ReadOptions& options,
                                         const ReadProgress& progress);
/// Two NumPy files: the one with integers holds the faces.
Result<std::unique_ptr<Motion>> open_npy(const std::string& one, const std::string& other);
/// The files of a VTK collection in the order of their times. Error: it refers to a file that is not below
/// its directory, or to several at one time.
Result<std::vector<std::string>> pvd_files(const std::string& path);
Result<std::unique_ptr<Motion>> open_pvd(const std::string& path, const ReadProgress& progress);
/// The files beside a .gltf that its buffers name, as paths; none where it cannot be read.
std::vector<std::string> gltf_files(const std::string& path);
/// A glTF or GLB, the clip ReadOptions::clip, sampled at ReadOptions::fps; merges the vertices of seams
/// unless ReadOptions::weld says so.
Result<std::unique_ptr<Motion>> open_gltf(const std::string& path, const ReadOptions& options,
                                          const ReadProgress& progress);

/// The topology of faces, lines and points. Lines that are sides of faces, points on faces or lines, and
/// copies of both add nothing to a check, so they are left out. `parts`: those of all three, or of the faces
/// alone; then others get the parts "lines" and "points".
Result<Topology> make_topology(Index vertex_count, std::vector<Triangle> faces, std::span<const Edge> lines,
                               std::span<const Index> points, ObjectParts& parts);
/// Which vertices the triangles name. Numbers beyond vertex_count are ignored.
std::vector<bool> named_vertices(Index vertex_count, std::span<const Triangle> triangles);
/// Gives lines and points parts where only the faces have them.
void add_parts(const Topology& topology, ObjectParts& parts);
/// The vertices in no triangle. `merged`: MotionInfo::merged; those that were merged away are none.
std::vector<Index> loose_vertices(const Topology& topology, std::span<const Index> merged);
/// "5 vertices in no face were not checked"
std::string unchecked_vertices(const Topology& topology, std::size_t count);
/// The motion with its loose vertices as points, or named in MotionInfo::unchecked.
Result<std::unique_ptr<Motion>> with_loose_vertices(std::unique_ptr<Motion> motion, bool as_points);

/// Merges vertices that have exactly the same position in the first frame into the first of them, in the
/// corners of triangles only (MotionInfo::merged). A frame in which merged vertices part is an error.
Result<std::unique_ptr<Motion>> weld(std::unique_ptr<Motion> motion);
/// Merges each vertex into the one that `merged` (MotionInfo::merged) has for it. `by`, which said so, and
/// `remedy` are for errors: a frame in which such vertices part.
Result<std::unique_ptr<Motion>> merge(std::unique_ptr<Motion> motion, std::vector<Index> merged,
                                      const char* by, const char* remedy);
/// Of every vertex, the first one at exactly its position; 0 and -0 are the same.
std::vector<Index> first_at_same_place(std::span<const double> positions);

/// Motions of one frame get as many as the longest has, all the same.
void stand_still(std::span<std::unique_ptr<Motion>> motions);

}  // namespace foldproof::io
