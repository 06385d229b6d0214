#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/parallel.h"
#include "base/try.h"
#include "picture/scene.h"

namespace foldproof {
namespace {

using picture::Box;
using picture::Camera;
using picture::PixelRect;
using picture::Scene;
using picture::Sphere;

constexpr Index kBandRows = 32;
constexpr Index kMaxPixels = 16384;

Result<void> require_settings(const PictureSettings& s) {
  const auto size = fmt::format("{} x {}", s.width, s.height);
  if (s.width == 0 || s.height == 0 || s.width > kMaxPixels || s.height > kMaxPixels ||
      std::uint64_t{s.width} * s.height > (std::uint64_t{1} << 26)) {
    return fail(ErrorCode::InvalidArgument, "picture", size + " pixels cannot be drawn",
                "give 1 to 16384 each way, 67 million together");
  }
  if (s.samples < 1 || s.samples > 8)
    return fail(ErrorCode::InvalidArgument, "picture",
                fmt::format("{} samples are not between 1 and 8", s.samples), "give another number");
  return {};
}

bool all_finite(std::span<const double> values) {
  return std::all_of(values.begin(), values.end(), [](double x) { return std::isfinite(x); });
}

Result<void> require_mesh(const PictureMesh& mesh) {
  const Topology& topology = *mesh.topology;
  if (mesh.positions.size() != std::size_t{topology.vertex_count()} * 3)
    return fail(ErrorCode::InvalidArgument, "picture",
                "a mesh has another number of positions than of vertices", "give 3 numbers per vertex");
  if (!all_finite(mesh.positions))
    return fail(ErrorCode::NonFinite, "picture", "a mesh has a coordinate that is not finite",
                "leave that mesh out");
  if (!mesh.face_colors.empty() && mesh.face_colors.size() != topology.triangles().size())
    return fail(ErrorCode::InvalidArgument, "picture", "a mesh has colors that do not fit",
                "give one per face");
  return {};
}

Result<void> require_panel(const Panel& panel) {
  for (const PictureMesh& mesh : panel.meshes) {
    FOLDPROOF_TRY(require_mesh(mesh));
  }
  for (const PicturePoints& points : panel.points) {
    const bool finite = std::all_of(points.positions.begin(), points.positions.end(),
                                    [](const Vec3& x) { return x.allFinite(); });
    if (!finite)
      return fail(ErrorCode::NonFinite, "picture", "a point has a coordinate that is not finite",
                  "leave that point out");
    if (!(points.size > 0 && points.size <= 1))
      return fail(ErrorCode::InvalidArgument, "picture", fmt::format("{} is no size for points", points.size),
                  "give a share above 0, at most 1");
  }
  if (panel.view.focus && !(panel.view.focus->radius > 0 && panel.view.focus->center.allFinite() &&
                            std::isfinite(panel.view.focus->radius)))
    return fail(ErrorCode::InvalidArgument, "view", "has a focus without an extent",
                "give a finite center and a radius above 0");
  if (panel.view.fit &&
      (panel.view.fit->isEmpty() || !panel.view.fit->min().allFinite() || !panel.view.fit->max().allFinite()))
    return fail(ErrorCode::InvalidArgument, "view", "is fitted to an empty or infinite box",
                "give a finite box");
  return {};
}

/// The box that a panel's camera is fitted to, in the view's axes.
Box bounds(const Panel& panel, const Eigen::Matrix3d& axes) {
  Box box;
  if (panel.view.fit) {
    for (int corner = 0; corner < 8; ++corner)
      box.extend(axes * panel.view.fit->corner(static_cast<Box::CornerType>(corner)));
    return box;
  }
  for (const PictureMesh& mesh : panel.meshes) {
    for (std::size_t k = 0; k < mesh.positions.size(); k += 3)
      box.extend(axes * to_eigen(Vec3::load(&mesh.positions[k])));
  }
  for (const PicturePoints& points : panel.points) {
    for (const Vec3& x : points.positions) box.extend(axes * to_eigen(x));
  }
  return box.isEmpty() ? Box(Eigen::Vector3d(0, 0, 0)) : box;
}

Result<std::vector<PixelRect>> arrange(Index panels, const PictureSettings& s) {
  if (panels > s.width)
    return fail(ErrorCode::InvalidArgument, "picture",
                fmt::format("{} panels do not fit into {} x {} pixels", panels, s.width, s.height),
                "draw fewer, or a larger picture");
  std::vector<PixelRect> areas;
  const auto left = [&](Index k) { return static_cast<Index>(std::uint64_t{s.width} * k / panels); };
  for (Index k = 0; k < panels; ++k) areas.push_back({left(k), 0, left(k + 1) - left(k), s.height});
  return areas;
}

Result<std::vector<Scene>> make_scenes(std::span<const Panel> panels, const PictureSettings& settings) {
  const auto areas = FOLDPROOF_TRY(arrange(static_cast<Index>(panels.size()), settings));
  std::vector<Scene> scenes;
  for (std::size_t k = 0; k < panels.size(); ++k) {
    FOLDPROOF_TRY(require_panel(panels[k]));
    const auto axes = FOLDPROOF_TRY(picture::orientation(panels[k].view));
    const Box box = bounds(panels[k], axes);
    if (!(box.sizes().maxCoeff() < 1e150) || !(box.center().cwiseAbs().maxCoeff() < 1e150))
      return fail(ErrorCode::LimitExceeded, "picture", "a mesh is too large for the camera's arithmetic",
                  "scale it down");
    const Camera camera(panels[k].view, axes, box.center(), 0.5 * box.sizes(), areas[k], settings.samples);
    scenes.push_back(make_scene(panels[k], areas[k], camera, box.sizes().maxCoeff(), settings.samples));
  }
  return scenes;
}

/// The faces and spheres whose bounding boxes overlap each band of rows.
struct Bands {
  std::vector<std::vector<Index>> faces, spheres;

  Bands(const Scene& scene, Index samples) {
    const Index count = (scene.area.height + kBandRows - 1) / kBandRows;
    faces.resize(count);
    spheres.resize(count);
    const double height = double{1} * kBandRows * samples;
    const auto put = [&](std::vector<std::vector<Index>>& bands, Index id, double min_y, double max_y) {
      const auto begin = static_cast<Index>(std::clamp(std::floor(min_y / height), 0.0, double{1} * count));
      const auto end = static_cast<Index>(std::clamp(std::floor(max_y / height) + 1, 0.0, double{1} * count));
      for (Index band = begin; band < end; ++band) bands[band].push_back(id);
    };
    for (Index k = 0; k < scene.faces.size(); ++k) {
      const Triangle& t = scene.faces[k].vertices;
      const auto [min_y, max_y] =
          std::minmax({scene.vertices[t[0]].y, scene.vertices[t[1]].y, scene.vertices[t[2]].y});
      put(faces, k, min_y, max_y);
    }
    for (Index k = 0; k < scene.spheres.size(); ++k) {
      const Sphere& sphere = scene.spheres[k];
      put(spheres, k, sphere.center.y - sphere.radius, sphere.center.y + sphere.radius);
    }
  }
};

}  // namespace

Result<Image> draw_picture(std::span<const Panel> panels, const PictureSettings& settings) {
  FOLDPROOF_TRY(require_settings(settings));
  if (panels.empty()) return fail(ErrorCode::InvalidArgument, "picture", "has no panel", "give at least one");
  const auto scenes = FOLDPROOF_TRY(make_scenes(panels, settings));
  Image image{settings.width, settings.height, {}};
  image.pixels.resize(std::size_t{image.width} * image.height, settings.background.value_or(Color{}));
  if (!settings.background) image.alpha.resize(image.pixels.size(), 0);
  for (const Scene& scene : scenes) {
    const Bands bands(scene, settings.samples);
    parallel_for(std::size_t{0}, bands.faces.size(), [&](std::size_t band) {
      const Index begin = static_cast<Index>(band) * kBandRows;
      const Index end = std::min(begin + kBandRows, scene.area.height);
      draw_rows(scene, settings.samples, settings.background, {begin, end}, bands.faces[band],
                bands.spheres[band], image);
    });
  }
  return image;
}

}  // namespace foldproof
