#include "io/cells.h"

#include <algorithm>
#include <numeric>

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

}  // namespace

void CellCollector::add_polygon(std::span<const Index> vertices, std::int64_t part) {
  mesh_.add_polygon(vertices);
  parts_.resize(mesh_.triangles.size(), part);
}

bool CellCollector::add(CellShape shape, std::span<const Index> vertices, std::int64_t part) {
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
  for (const auto& corners : v.faces) {
    Face face{{kNoIndex, kNoIndex, kNoIndex, kNoIndex}, part};
    std::ranges::transform(corners, face.vertices.begin(), [&](std::uint8_t c) { return vertices[c]; });
    faces_.push_back(face);
  }
  return true;
}

std::vector<std::int64_t> CellCollector::finish() {
  if (!mesh_.triangles.empty()) return std::move(parts_);
  std::vector<std::array<Index, 4>> keys;
  keys.reserve(faces_.size());
  for (const Face& face : faces_) std::ranges::sort(keys.emplace_back(face.vertices));
  std::vector<std::size_t> order(faces_.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::sort(order, [&](std::size_t a, std::size_t b) { return keys[a] < keys[b]; });
  std::vector<bool> inside(faces_.size());
  for (std::size_t i = 1; i < order.size(); ++i) {
    if (keys[order[i - 1]] == keys[order[i]]) inside[order[i - 1]] = inside[order[i]] = true;
  }
  for (std::size_t i = 0; i < faces_.size(); ++i) {
    const std::size_t count = faces_[i].vertices[3] == kNoIndex ? 3 : 4;
    if (!inside[i]) add_polygon(std::span(faces_[i].vertices).first(count), faces_[i].part);
  }
  return std::move(parts_);
}

}  // namespace foldproof::io
