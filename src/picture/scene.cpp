#include "picture/scene.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace foldproof::picture {
namespace {

class SceneBuilder {
 public:
  SceneBuilder(Scene& scene, Index samples) : scene_(scene), samples_(samples) {}

  void add(const PictureMesh& mesh) {
    const auto first_vertex = static_cast<Index>(scene_.vertices.size());
    const Topology& topology = *mesh.topology;
    for (Index v = 0; v < topology.vertex_count(); ++v)
      scene_.vertices.push_back(scene_.camera.project(position(mesh, v)));
    const auto first_color = static_cast<Index>(scene_.colors.size());
    for (const Color color : mesh.face_colors) scene_.colors.push_back(to_linear(color));
    if (mesh.face_colors.empty()) scene_.colors.push_back(to_linear(mesh.color));

    const auto triangles = topology.triangles();
    const Index first_normal = add_normals(mesh);
    for (Index t = 0; t < triangles.size(); ++t) {
      Face face;
      face.color = first_color + (mesh.face_colors.empty() ? 0 : t);
      if (topology.element(t) != Element::Face) {
        add_stroke(first_vertex + triangles[t][0], first_vertex + triangles[t][1], face.color);
        continue;
      }
      for (Index k = 0; k < 3; ++k) {
        const Index vertex = triangles[t][k];
        face.vertices[k] = first_vertex + vertex;
        face.normals[k] = first_normal + (mesh.smooth ? 3 * t + k : t);
      }
      scene_.faces.push_back(face);
    }
  }

  void add(const PicturePoints& points, double extent) {
    for (const Vec3& x : points.positions) {
      const ScreenPoint point = scene_.camera.project(x);
      const double radius = points.size * extent;
      scene_.spheres.push_back(
          {point, radius * scene_.camera.samples_per_unit(point), radius, to_linear(points.color)});
    }
  }

 private:
  // A line or, between a vertex and itself, a point: two triangles that face the eye.
  void add_stroke(Index from, Index to, Index color) {
    constexpr double kWidth = 1.0 / 400;  // of the panel
    const ScreenPoint a = scene_.vertices[from], b = scene_.vertices[to];
    const double half = std::max(scene_.area.width, scene_.area.height) * kWidth / 2 * samples_;
    const double length = std::hypot(b.x - a.x, b.y - a.y);
    const double along_x = length > 0 ? (b.x - a.x) / length : 1,
                 along_y = length > 0 ? (b.y - a.y) / length : 0;
    const auto first = static_cast<Index>(scene_.vertices.size());
    for (const auto& [p, end] : {std::pair(a, -half), std::pair(b, half)}) {
      for (const double side : {-half, half}) {
        scene_.vertices.push_back(
            {p.x + end * along_x - side * along_y, p.y + end * along_y + side * along_x, p.reversed_depth});
      }
    }
    const auto normal = static_cast<Index>(scene_.normals.size());
    scene_.normals.emplace_back(0.0f, 0.0f, 1.0f);
    for (const Index k : {Index{0}, Index{1}}) {
      scene_.faces.push_back({color, {first + k, first + k + 1, first + k + 2}, {normal, normal, normal}});
    }
  }

  static Vec3 position(const PictureMesh& mesh, Index vertex) {
    return Vec3::load(&mesh.positions[3 * std::size_t{vertex}]);
  }

  /// Adds one normal per corner of a triangle, or one per triangle. Returns the index of the first.
  Index add_normals(const PictureMesh& mesh) {
    const auto first = static_cast<Index>(scene_.normals.size());
    std::vector<Vec3> of_triangle;  // as long as twice the area
    for (const Triangle& t : mesh.topology->triangles()) {
      const Vec3 a = position(mesh, t[0]);
      of_triangle.push_back(scene_.camera.rotate((position(mesh, t[1]) - a).cross(position(mesh, t[2]) - a)));
    }
    if (mesh.smooth) {
      add_smooth_normals(*mesh.topology, of_triangle);
    } else {
      for (const Vec3& normal : of_triangle) add_normal(normal);
    }
    return first;
  }

  void add_normal(const Vec3& normal) {
    scene_.normals.emplace_back(to_eigen(normal.stableNormalized()).cast<float>());
  }

  /// A corner's normal: that of the triangles around its vertex, weighted by area, without those that turn
  /// away from its own by more than the crease angle.
  void add_smooth_normals(const Topology& topology, const std::vector<Vec3>& of_triangle) {
    constexpr double kCrease = 0.5;  // the cosine of 60 degrees
    const auto triangles = topology.triangles();
    std::vector<Index> begin(topology.vertex_count() + std::size_t{1}, 0), around(3 * triangles.size());
    for (const Triangle& t : triangles) {
      for (const Index vertex : t) ++begin[vertex + std::size_t{1}];
    }
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    std::vector<Index> next(begin.begin(), begin.end() - 1);
    for (Index t = 0; t < triangles.size(); ++t) {
      for (const Index vertex : triangles[t]) around[next[vertex]++] = t;
    }
    std::vector<Vec3> unit;
    unit.reserve(of_triangle.size());
    for (const Vec3& normal : of_triangle) unit.emplace_back(normal.stableNormalized());
    for (Index t = 0; t < triangles.size(); ++t) {
      for (const Index vertex : triangles[t]) {
        Vec3 sum = of_triangle[t];
        for (Index i = begin[vertex]; i < begin[vertex + std::size_t{1}]; ++i) {
          const Index other = around[i];
          if (other != t && unit[t].dot(unit[other]) >= kCrease) sum += of_triangle[other];
        }
        add_normal(sum);
      }
    }
  }

  Scene& scene_;
  Index samples_;  // across a pixel
};

}  // namespace

Scene make_scene(const Panel& panel, const PixelRect& area, const Camera& camera, double extent,
                 Index samples) {
  Scene scene(area, camera);
  SceneBuilder builder(scene, samples);
  for (const PictureMesh& mesh : panel.meshes) builder.add(mesh);
  for (const PicturePoints& points : panel.points) builder.add(points, extent);
  return scene;
}

}  // namespace foldproof::picture
