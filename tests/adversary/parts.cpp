#include "adversary/parts.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>

#include "foldproof/eigen.h"
#include "mesh/grid.h"

namespace foldproof::adversary {
namespace {

// A sheet in x and y that waves in z.
Mesh sheet(Source& source, double size) {
  const int most = source.one_in(60) ? 16 : 5;
  const int nx = source.whole(1, most), ny = source.whole(1, most);
  const double narrow = source.one_in(2) ? 1 : source.spread(1e-3, 1);
  const double height = source.one_in(4) ? 0 : size * source.spread(1e-6, 0.5);
  const double a = source.real(0, 6), b = source.real(0, 6), phase = source.real(0, 6);
  Mesh mesh;
  for (int j = 0; j <= ny; ++j) {
    for (int i = 0; i <= nx; ++i) {
      const double u = double(i) / nx - 0.5, v = double(j) / ny - 0.5;
      mesh.vertices.emplace_back(size * u, size * narrow * v, height * std::sin(a * u + b * v + phase));
    }
  }
  using testing::Grid, testing::Diagonal;
  const auto columns = static_cast<Index>(nx), rows = static_cast<Index>(ny);
  mesh.triangles = Grid{columns, rows, false, Diagonal::SecondToThird}.triangles();
  return mesh;
}

// Sides of a column of three or four corners; stacked in z.
Mesh prism(Source& source, double size) {
  const auto corners = static_cast<Index>(source.whole(3, 4));
  const double width = size * source.spread(1e-6, 1);
  const auto stories = static_cast<Index>(source.whole(1, 3));
  Mesh mesh;
  for (Index j = 0; j <= stories; ++j) {
    for (Index i = 0; i < corners; ++i) {
      const double angle = 6.283 * i / corners + 0.3;
      mesh.vertices.emplace_back(width * std::cos(angle), width * std::sin(angle),
                                 size * (double(j) / stories - 0.5));
    }
  }
  for (Index j = 0; j < stories; ++j) {
    for (Index i = 0; i < corners; ++i) {
      const Index a = j * corners + i, b = j * corners + (i + 1) % corners;
      mesh.triangles.push_back({a, b, a + corners});
      mesh.triangles.push_back({b, b + corners, a + corners});
    }
  }
  return mesh;
}

Mesh box(Source& source, double size) {
  const Vec3 side(size, size * source.spread(1e-6, 1), size * source.spread(1e-6, 1));
  Mesh mesh;
  for (int k = 0; k < 8; ++k)
    mesh.vertices.emplace_back(Vec3(k & 1, k >> 1 & 1, k >> 2).cwiseProduct(side) - side / 2);
  for (const auto& q : std::array<std::array<Index, 4>, 6>{
           {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}}) {
    mesh.triangles.push_back({q[0], q[1], q[2]});
    mesh.triangles.push_back({q[0], q[2], q[3]});
  }
  return mesh;
}

// Triangles without common vertices, each of its own size and shape.
Mesh soup(Source& source, double size) {
  Mesh mesh;
  const int count = source.whole(1, 16);
  const double least = source.spread(1e-6, 1);
  for (int k = 0; k < count; ++k) {
    const Vec3 at = size * 0.5 * random_vector(source);
    const double side = size * source.spread(least, 1);
    const Vec3 shape = side * Vec3(source.spread(1e-6, 1), source.one_in(2) ? 1 : source.spread(1e-6, 1), 1);
    const auto v = static_cast<Index>(mesh.vertices.size());
    for (int c = 0; c < 3; ++c) mesh.vertices.push_back(at + shape.cwiseProduct(random_vector(source)));
    mesh.triangles.push_back({v, v + 1, v + 2});
  }
  return mesh;
}

// A few long thin triangles side by side, or around one common corner.
Mesh needles(Source& source, double size) {
  Mesh mesh;
  const int count = source.whole(1, 10);
  const double width = size * source.spread(1e-6, 0.1), beside = size * source.spread(1e-6, 0.2);
  const bool common = source.one_in(3);
  if (common) mesh.vertices.emplace_back(0, 0, size / 2);
  for (int k = 0; k < count; ++k) {
    const Vec3 at(beside * k, beside * source.real(-1, 1), 0);
    const auto v = static_cast<Index>(mesh.vertices.size());
    mesh.vertices.push_back(at + Vec3(0, 0, -size / 2));
    mesh.vertices.push_back(at + Vec3(width, width * source.real(-1, 1), -size / 2));
    if (!common) mesh.vertices.push_back(at + Vec3(width / 2, 0, size / 2));
    mesh.triangles.push_back({v, v + 1, common ? 0 : v + 2});
  }
  return mesh;
}

// A strip folded to and fro.
Mesh strip(Source& source, double size) {
  Mesh mesh;
  const auto folds = static_cast<Index>(source.whole(2, 12));
  const double rise = size * source.spread(1e-6, 0.3), width = size * source.spread(1e-3, 1);
  for (Index k = 0; k <= folds; ++k) {
    const double x = k % 2 == 0 ? -size / 2 : size / 2;
    mesh.vertices.emplace_back(x, -width / 2, rise * k);
    mesh.vertices.emplace_back(x, width / 2, rise * (k + (source.one_in(8) ? 0.5 : 0)));
  }
  for (Index k = 0; k < folds; ++k) {
    mesh.triangles.push_back({2 * k, 2 * k + 1, 2 * k + 2});
    mesh.triangles.push_back({2 * k + 1, 2 * k + 3, 2 * k + 2});
  }
  return mesh;
}

// Triangles around a vertex, nearly flat: whole, or with a gap.
Mesh fan(Source& source, double size) {
  Mesh mesh;
  const auto count = static_cast<Index>(source.whole(3, 14));
  const double rise = size * source.spread(1e-6, 1);
  mesh.vertices.emplace_back(0, 0, rise);
  for (Index k = 0; k < count; ++k) {
    const double angle = 6.283 * k / count;
    mesh.vertices.emplace_back(size / 2 * std::cos(angle), size / 2 * std::sin(angle), 0);
  }
  const Index sides = source.one_in(2) ? count : count - 1;
  for (Index k = 0; k < sides; ++k) mesh.triangles.push_back({0, 1 + k, 1 + (k + 1) % count});
  return mesh;
}

// Vertices named twice, triangles given twice, corners in one place or on one line.
void spoil(Source& source, Mesh& mesh) {
  const auto any = [&] { return source.pick(static_cast<unsigned>(mesh.vertices.size())); };
  Triangle& t = mesh.triangles[source.pick(static_cast<unsigned>(mesh.triangles.size()))];
  switch (source.pick(5)) {
    case 0:
      t[1] = t[2];
      break;
    case 1:
      mesh.triangles.push_back(t);
      break;
    case 2:
      mesh.vertices[t[0]] = mesh.vertices[t[1]];
      break;
    case 3:
      mesh.vertices[t[0]] = mesh.vertices[t[1]] / 2 + mesh.vertices[t[2]] / 2;
      break;
    default:
      mesh.triangles.push_back({any(), any(), any()});
      break;
  }
}

}  // namespace

void Mesh::add(const Mesh& other) {
  const auto first = static_cast<Index>(vertices.size());
  vertices.insert(vertices.end(), other.vertices.begin(), other.vertices.end());
  for (const Triangle& t : other.triangles) triangles.push_back({first + t[0], first + t[1], first + t[2]});
}

Vec3 Mesh::random_point(Source& source) const {
  if (triangles.empty()) return Vec3::Zero();
  const Triangle& t = triangles[source.pick(static_cast<unsigned>(triangles.size()))];
  const double u = source.real(0, 1), v = source.real(0, 1 - u);
  return vertices[t[0]] + u * (vertices[t[1]] - vertices[t[0]]) + v * (vertices[t[2]] - vertices[t[0]]);
}

double ratio(Source& source) {
  if (!source.one_in(4)) return source.spread(1e-6, 1e6);
  constexpr std::array<int, 5> kWidths = {7, 8, 15, 16, 31};
  const double edge = std::ldexp(1 + source.real(-0.05, 0.05), kWidths[source.pick(5)]) / 252;
  return source.one_in(2) ? edge : 1 / edge;
}

Mesh make_part(Source& source, double size) {
  constexpr std::array kMakers = {sheet, prism, box, soup, needles, strip, fan};
  Mesh mesh = kMakers[source.pick(kMakers.size())](source, size);
  if (source.one_in(8)) spoil(source, mesh);
  if (source.one_in(3)) {
    const double angle = source.real(-3, 3);
    const Eigen::Matrix3d turn =
        Eigen::AngleAxisd(angle, to_eigen((random_vector(source) + Vec3(0, 0, 1e-9)).normalized()))
            .toRotationMatrix();
    for (Vec3& p : mesh.vertices) p = to_vec3(turn * to_eigen(p));
  } else if (const int axis = source.whole(0, 2); axis != 0) {
    for (Vec3& p : mesh.vertices) p = axis == 1 ? Vec3(p.z(), p.x(), p.y()) : Vec3(p.y(), p.z(), p.x());
  }
  return mesh;
}

}  // namespace foldproof::adversary
