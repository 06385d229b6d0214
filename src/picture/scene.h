/// A panel, ready to be drawn: everything in samples.
#pragma once

#include "picture/camera.h"
#include "picture/colour.h"

namespace foldproof::picture {

struct Ball {
  Spot spot;      ///< Of its middle.
  double radius;  ///< Samples.
  double length;  ///< The same in mesh units.
  Light light;
};

struct Face {
  Triangle corners;              ///< Among the spots of the scene.
  std::array<Index, 3> lights;   ///< Of the corners.
  std::array<Index, 3> normals;  ///< The same one three times for a triangle that is to look flat.
};

struct Scene {
  Scene(const Area& drawn, const Camera& with) : area(drawn), camera(with) {}

  Area area;
  Camera camera;
  std::vector<Spot> spots;  ///< Of vertices, those of all meshes one after the other.
  std::vector<Face> faces;
  std::vector<Light> lights;
  std::vector<Eigen::Vector3f> normals;  ///< In the camera's axes, any length, by the winding of triangles.
  std::vector<Ball> balls;
};

/// `extent` is what the size of points is a share of. Precondition: the panel is sound.
Scene make_scene(const Panel& panel, const Area& area, const Camera& camera, double extent);

/// Draws rows of pixels [begin, end) of the scene's area into the image. `faces` and `balls`: those that may
/// reach into these rows.
void draw_rows(const Scene& scene, Index samples, Colour background, std::array<Index, 2> rows,
               std::span<const Index> faces, std::span<const Index> balls, Image& image);

}  // namespace foldproof::picture
