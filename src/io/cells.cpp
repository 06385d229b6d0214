#include "io/cells.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <optional>

namespace foldproof::io {
namespace {

struct Volume {
  std::size_t vertices;
  std::vector<std::vector<std::uint8_t>> faces;  // seen from outside, counterclockwise
};

const Volume& volume(CellShape shape) {
  static const Volume kTetrahedron{4, {{0, 1, 3}, {1, 2, 3}, {2, 0, 3}, {0, 2, 1}}};
  static const Volume kVoxel{
      8, {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}}};
  static const Volume kHexahedron{
      8, {{0, 4, 7, 3}, {1, 2, 6, 5}, {0, 1, 5, 4}, {3, 7, 6, 2}, {0, 3, 2, 1}, {4, 5, 6, 7}}};
  static const Volume kWedge{6, {{0, 1, 2}, {3, 5, 4}, {0, 3, 4, 1}, {1, 4, 5, 2}, {2, 5, 3, 0}}};
  static const Volume kPyramid{5, {{0, 3, 2, 1}, {0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}}};
  switch (shape) {
    case CellShape::Tetrahedron:
      return kTetrahedron;
    case CellShape::Voxel:
      return kVoxel;
    case CellShape::Hexahedron:
      return kHexahedron;
    case CellShape::Wedge:
      return kWedge;
    default:
      return kPyramid;
  }
}

std::optional<CellShape> shape_of(std::int64_t vtk_type) {
  switch (vtk_type) {
    case 1:  // vertex
    case 2:  // several
      return CellShape::Points;
    case 3:  // line
    case 4:  // several
      return CellShape::Polyline;
    case 5:  // triangle
    case 7:  // polygon
    case 9:  // quad
      return CellShape::Polygon;
    case 6:
      return CellShape::Strip;
    case 8:
      return CellShape::Pixel;
    case 10:
      return CellShape::Tetrahedron;
    case 11:
      return CellShape::Voxel;
    case 12:
      return CellShape::Hexahedron;
    case 13:
      return CellShape::Wedge;
    case 14:
      return CellShape::Pyramid;
    default:
      return std::nullopt;
  }
}
constexpr std::int64_t kEmptyCell = 0;

/// The indices of `values` in ascending order of these; of equal ones, the first comes first.
template <class T>
std::vector<std::size_t> sorted_order(const std::vector<T>& values) {
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::sort(order, [&](std::size_t a, std::size_t b) {
    return values[a] != values[b] ? values[a] < values[b] : a < b;
  });
  return order;
}

/// Triangles by their vertices, in any order.
class SurfaceTriangles {
 public:
  explicit SurfaceTriangles(std::vector<Triangle> triangles) : triangles_(std::move(triangles)) {
    for (Triangle& t : triangles_) std::ranges::sort(t);
    std::ranges::sort(triangles_);
  }

  /// The triangles of a face of three or four vertices that are not among these. Of its two diagonals, a face
  /// of four has the one that leaves fewer.
  std::vector<Triangle> missing(std::span<const Index> v) const {
    if (v.size() == 3) return not_here({{v[0], v[1], v[2]}});
    auto one = not_here({{v[0], v[1], v[2]}, {v[0], v[2], v[3]}});
    auto other = not_here({{v[1], v[2], v[3]}, {v[1], v[3], v[0]}});
    return one.size() <= other.size() ? one : other;
  }

 private:
  std::vector<Triangle> not_here(std::vector<Triangle> triangles) const {
    std::erase_if(triangles, [&](Triangle t) {
      std::ranges::sort(t);
      return std::ranges::binary_search(triangles_, t);
    });
    return triangles;
  }

  std::vector<Triangle> triangles_;
};

}  // namespace

void CellCollector::add_polygon(std::span<const Index> vertices, std::int64_t part) {
  mesh_.add_polygon(vertices);
  parts_.resize(mesh_.triangles.size(), part);
}

bool CellCollector::add(CellShape shape, std::span<const Index> vertices, std::int64_t part) {
  if (shape == CellShape::Points || shape == CellShape::Polyline) {
    if (vertices.empty()) return false;
    if (shape == CellShape::Polyline) mesh_.add_polyline(vertices);
    if (shape == CellShape::Points) mesh_.points.insert(mesh_.points.end(), vertices.begin(), vertices.end());
    return true;
  }
  if (shape == CellShape::Pixel) {
    if (vertices.size() != 4) return false;
    add_polygon(std::array{vertices[0], vertices[1], vertices[3], vertices[2]}, part);
    return true;
  }
  if (shape == CellShape::Polygon || shape == CellShape::Strip) {
    if (vertices.size() < 3) return false;
    if (shape == CellShape::Polygon) add_polygon(vertices, part);
    // Every other triangle of a strip is the other way around.
    for (std::size_t i = 2; shape == CellShape::Strip && i < vertices.size(); ++i)
      add_polygon(std::array{vertices[i - 2], vertices[i - 1 + i % 2], vertices[i - i % 2]}, part);
    return true;
  }
  const Volume& v = volume(shape);
  if (vertices.size() != v.vertices) return false;
  Corners sorted;
  sorted.fill(kNoIndex);
  std::ranges::copy(vertices, sorted.begin());
  std::ranges::sort(sorted);
  for (const auto& corners : v.faces) {
    Face face{{kNoIndex, kNoIndex, kNoIndex, kNoIndex}, part, volumes_.size()};
    std::ranges::transform(corners, face.vertices.begin(), [&](std::uint8_t c) { return vertices[c]; });
    faces_.push_back(face);
  }
  volumes_.push_back(sorted);
  return true;
}

std::string CellCollector::add(const VtkCells& cells, VertexRange vertices,
                               std::span<const std::int64_t> labels) {
  std::vector<Index> cell;
  std::int64_t begin = 0;
  for (std::size_t i = 0; i < cells.ends.size(); ++i) {
    const auto wrong = [&](const std::string& problem) { return fmt::format("cell {} {}", i, problem); };
    if (cells.ends[i] < begin || static_cast<std::uint64_t>(cells.ends[i]) > cells.ids.size())
      return wrong("has an offset that is not within its vertices");
    cell.clear();
    for (; begin < cells.ends[i]; ++begin) {
      const std::int64_t id = cells.ids[static_cast<std::size_t>(begin)];
      if (id < 0 || id >= vertices.count)
        return wrong(
            fmt::format("refers to vertex {}, but there are {} (counting from 0)", id, vertices.count));
      cell.push_back(vertices.first + static_cast<Index>(id));
    }
    if (cells.types[i] == kEmptyCell) continue;
    const auto shape = shape_of(cells.types[i]);
    if (!shape) return wrong(fmt::format("is of VTK's type {}, which is not read", cells.types[i]));
    if (!add(*shape, cell, i < labels.size() ? labels[i] : 0))
      return wrong(fmt::format("has {} vertices", cell.size()));
  }
  return {};
}

/// Of every volume, the first one that has its corners.
std::vector<std::size_t> CellCollector::merge_volumes() const {
  const std::vector<std::size_t> order = sorted_order(volumes_);
  std::vector<std::size_t> first(volumes_.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool same = i > 0 && volumes_[order[i - 1]] == volumes_[order[i]];
    first[order[i]] = same ? first[order[i - 1]] : order[i];
  }
  return first;
}

/// Of every face, whether it is on the boundary: the first one of those that have the same vertices, if all
/// of them belong to one volume.
std::vector<bool> CellCollector::find_boundary() const {
  const std::vector<std::size_t> first = merge_volumes();
  std::vector<std::array<Index, 4>> keys;
  keys.reserve(faces_.size());
  for (const Face& face : faces_) std::ranges::sort(keys.emplace_back(face.vertices));
  const std::vector<std::size_t> order = sorted_order(keys);
  std::vector<bool> boundary(faces_.size());
  for (std::size_t begin = 0, end = 0; begin < order.size(); begin = end) {
    const std::size_t volume = first[faces_[order[begin]].volume];
    bool one_volume = true;
    for (; end < order.size() && keys[order[end]] == keys[order[begin]]; ++end)
      one_volume = one_volume && first[faces_[order[end]].volume] == volume;
    boundary[order[begin]] = one_volume;
  }
  return boundary;
}

std::vector<std::int64_t> CellCollector::finish() {
  if (faces_.empty()) return std::move(parts_);
  const SurfaceTriangles surface(mesh_.triangles);
  const std::vector<bool> boundary = find_boundary();
  for (std::size_t i = 0; i < faces_.size(); ++i) {
    if (!boundary[i]) continue;
    const std::span<const Index> vertices = std::span(faces_[i].vertices).first(faces_[i].size());
    const std::vector<Triangle> missing = surface.missing(vertices);
    if (missing.size() + 2 == vertices.size()) {
      add_polygon(vertices, faces_[i].part);
    } else {
      for (const Triangle& t : missing) add_polygon(t, faces_[i].part);
    }
  }
  return std::move(parts_);
}

}  // namespace foldproof::io
