/// The projected content of a panel, in samples.
#pragma once

#include "picture/camera.h"
#include "picture/color.h"

namespace foldproof::picture {

struct Sphere {
  ScreenPoint center;
  double radius;        ///< Samples.
  double world_radius;  ///< Mesh units.
  LinearColor color;
};

struct Face {
  // Indices into the arrays of the scene; vertices and normals are those of the corners.
  Index color;
  Triangle vertices;
  std::array<Index, 3> normals;  ///< Three times the same for flat shading.
};

struct Scene {
  Scene(const PixelRect& pixels, const Camera& projection) : area(pixels), camera(projection) {}

  PixelRect area;
  Camera camera;
  std::vector<ScreenPoint> vertices;  ///< Of all meshes.
  std::vector<Face> faces;
  std::vector<LinearColor> colors;
  std::vector<Eigen::Vector3f>
      normals;  ///< In the camera's axes, of unit length or zero, by the triangles' winding.
  std::vector<Sphere> spheres;
};

/// `extent`: the length that PicturePoints::size is relative to. `samples`: across a pixel. Precondition: the
/// panel is valid.
Scene make_scene(const Panel& panel, const PixelRect& area, const Camera& camera, double extent,
                 Index samples);

/// Draws the rows [rows[0], rows[1]) of the scene's area into the image. `faces` and `spheres`: all that may
/// overlap these rows.
void draw_rows(const Scene& scene, Index samples, std::optional<Color> background, std::array<Index, 2> rows,
               std::span<const Index> faces, std::span<const Index> spheres, Image& image);

}  // namespace foldproof::picture
