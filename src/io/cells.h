/// Triangles of a mesh of cells: its surfaces; where it has none, the boundary of its volumes.
#pragma once

#include "io/readers.h"

namespace foldproof::io {

enum class CellShape : std::uint8_t { Polygon, Strip, Pixel, Tetrahedron, Voxel, Hexahedron, Wedge, Pyramid };

/// Collects cells.
class CellCollector {
 public:
  explicit CellCollector(MeshData& mesh) : mesh_(mesh) {}

  /// `vertices`: in VTK's order. `part`: a number that the cell's triangles get. False: the shape has another
  /// number of vertices.
  bool add(CellShape shape, std::span<const Index> vertices, std::int64_t part);
  /// Where there are no surfaces, adds the faces that only one volume has, in their order. Files often hold
  /// both, which would be the same triangles twice. Returns the part of each triangle.
  std::vector<std::int64_t> finish();

 private:
  struct Face {
    std::array<Index, 4> vertices;  // a triangle's last is kNoIndex
    std::int64_t part;
  };
  void add_polygon(std::span<const Index> vertices, std::int64_t part);

  MeshData& mesh_;
  std::vector<Face> faces_;
  std::vector<std::int64_t> parts_;
};

}  // namespace foldproof::io
