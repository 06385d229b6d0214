/// Triangles of a mesh of cells: its surfaces and the boundary of its volumes.
#pragma once

#include <array>

#include "io/readers.h"

namespace foldproof::io {

/// Points and polylines have one vertex or more.
enum class CellShape : std::uint8_t {
  Points,
  Polyline,
  Polygon,
  Strip,
  Pixel,
  Tetrahedron,
  Voxel,
  Hexahedron,
  Wedge,
  Pyramid
};

/// Cells as VTK's files store them.
struct VtkCells {
  std::vector<std::int64_t> ends;   ///< Per cell, where its vertices end among all.
  std::vector<std::int64_t> ids;    ///< The vertices of all cells, one after the other.
  std::vector<std::int64_t> types;  ///< Per cell, VTK's number of its shape.
};

/// The vertices that the ids of cells count.
struct VertexRange {
  Index first = 0, count = 0;
};

/// Collects cells.
class CellCollector {
 public:
  explicit CellCollector(MeshData& mesh) : mesh_(mesh) {}

  /// `vertices`: in VTK's order. `part`: a number that the cell's triangles get; lines and points have none.
  /// False: the shape has another number of vertices.
  bool add(CellShape shape, std::span<const Index> vertices, std::int64_t part);
  /// `labels`: the parts of cells, 0 where there are none. Returns what is wrong with them, else nothing.
  std::string add(const VtkCells& cells, VertexRange vertices, std::span<const std::int64_t> labels);
  /// Adds the faces that only one volume has, in their order, without the triangles that are there already,
  /// as files often hold both. Volumes with the same corners are one. Returns the part of each triangle.
  std::vector<std::int64_t> finish();

 private:
  struct Face {
    std::array<Index, 4> vertices;  // a triangle's last is kNoIndex
    std::int64_t part;
    std::size_t volume;

    std::size_t size() const { return vertices[3] == kNoIndex ? 3 : 4; }
  };
  using Corners = std::array<Index, 8>;  // ascending; kNoIndex behind the last

  void add_polygon(std::span<const Index> vertices, std::int64_t part);
  std::vector<std::size_t> merge_volumes() const;
  std::vector<bool> find_boundary() const;

  MeshData& mesh_;
  std::vector<Corners> volumes_;
  std::vector<Face> faces_;  // of the volumes
  std::vector<std::int64_t> parts_;
};

}  // namespace foldproof::io
