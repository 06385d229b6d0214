#include "picture/scene.h"

namespace foldproof::picture {
namespace {

class Maker {
 public:
  explicit Maker(Scene& scene) : scene_(scene) {}

  void add(const PictureMesh& mesh) {
    const auto first = static_cast<Index>(scene_.spots.size());
    const Topology& topology = *mesh.topology;
    for (Index v = 0; v < topology.vertex_count(); ++v)
      scene_.spots.push_back(scene_.camera.project(at(mesh, v)));
    const auto lights = static_cast<Index>(scene_.lights.size());
    const auto colours = mesh.vertex_colours.empty() ? mesh.face_colours : mesh.vertex_colours;
    for (const Colour colour : colours) scene_.lights.push_back(to_light(colour));
    if (colours.empty()) scene_.lights.push_back(to_light(mesh.colour));

    const auto triangles = topology.triangles();
    const Index normals = add_normals(mesh);
    for (Index t = 0; t < triangles.size(); ++t) {
      Face face;
      for (int k = 0; k < 3; ++k) {
        const Index vertex = triangles[t][k];
        const Index light = !mesh.vertex_colours.empty() ? vertex : !mesh.face_colours.empty() ? t : 0;
        face.corners[k] = first + vertex;
        face.lights[k] = lights + light;
        face.normals[k] = normals + (mesh.smooth ? vertex : t);
      }
      scene_.faces.push_back(face);
    }
  }

  void add(const PicturePoints& points, double extent) {
    for (const Vec3& x : points.positions) {
      const Spot spot = scene_.camera.project(x);
      const double length = points.size * extent;
      scene_.balls.push_back({spot, length * scene_.camera.scale_at(spot), length, to_light(points.colour)});
    }
  }

 private:
  static Vec3 at(const PictureMesh& mesh, Index vertex) {
    return Eigen::Map<const Vec3>(&mesh.positions[3 * std::size_t{vertex}]);
  }

  /// One per vertex, weighted by area, or one per triangle. Returns the number of the first.
  Index add_normals(const PictureMesh& mesh) {
    const auto first = static_cast<Index>(scene_.normals.size());
    const auto triangles = mesh.topology->triangles();
    if (mesh.smooth) scene_.normals.resize(first + mesh.topology->vertex_count(), Eigen::Vector3f::Zero());
    for (const Triangle& t : triangles) {
      const Vec3 a = at(mesh, t[0]);
      const Vec3 normal = scene_.camera.turn((at(mesh, t[1]) - a).cross(at(mesh, t[2]) - a));
      if (!mesh.smooth) scene_.normals.emplace_back(normal.cast<float>());
      for (int k = 0; mesh.smooth && k < 3; ++k) scene_.normals[first + t[k]] += normal.cast<float>();
    }
    return first;
  }

  Scene& scene_;
};

}  // namespace

Scene make_scene(const Panel& panel, const Area& area, const Camera& camera, double extent) {
  Scene scene(area, camera);
  Maker maker(scene);
  for (const PictureMesh& mesh : panel.meshes) maker.add(mesh);
  for (const PicturePoints& points : panel.points) maker.add(points, extent);
  return scene;
}

}  // namespace foldproof::picture
