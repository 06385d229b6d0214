#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/parallel.h"
#include "picture/scene.h"

namespace foldproof {
namespace {

using namespace picture;

constexpr Index kBandRows = 32;
constexpr Index kMostPixels = 16384;

Result<void> require_settings(const PictureSettings& s) {
  const auto size = fmt::format("{} x {}", s.width, s.height);
  if (s.width == 0 || s.height == 0 || s.width > kMostPixels || s.height > kMostPixels ||
      std::uint64_t{s.width} * s.height > (std::uint64_t{1} << 26)) {
    return fail("picture", size + " pixels cannot be drawn", "give 1 to 16384 each way, 67 million together");
  }
  if (s.samples < 1 || s.samples > 8)
    return fail("picture", fmt::format("{} samples are not between 1 and 8", s.samples),
                "give another number");
  return {};
}

bool all_finite(std::span<const double> values) {
  return std::all_of(values.begin(), values.end(), [](double x) { return std::isfinite(x); });
}

Result<void> require_mesh(const PictureMesh& mesh) {
  const Topology& topology = *mesh.topology;
  if (mesh.positions.size() != std::size_t{topology.vertex_count()} * 3)
    return fail("picture", "a mesh has another number of positions than of vertices",
                "give 3 numbers per vertex");
  if (!all_finite(mesh.positions))
    return fail("picture", "a mesh has a coordinate that is not finite", "leave that mesh out");
  const bool faces_fit = mesh.face_colours.empty() || mesh.face_colours.size() == topology.triangles().size();
  const bool vertices_fit =
      mesh.vertex_colours.empty() || mesh.vertex_colours.size() == topology.vertex_count();
  if (!faces_fit || !vertices_fit || (!mesh.face_colours.empty() && !mesh.vertex_colours.empty()))
    return fail("picture", "a mesh has colours that do not fit", "give one per face, or one per vertex");
  return {};
}

Result<void> require_panel(const Panel& panel) {
  for (const PictureMesh& mesh : panel.meshes) {
    if (auto ok = require_mesh(mesh); !ok) return ok;
  }
  for (const PicturePoints& points : panel.points) {
    const bool finite = std::all_of(points.positions.begin(), points.positions.end(),
                                    [](const Vec3& x) { return x.allFinite(); });
    if (!finite)
      return fail("picture", "a point has a coordinate that is not finite", "leave that point out");
    if (!(points.size > 0 && points.size <= 1))
      return fail("picture", fmt::format("{} is no size for points", points.size),
                  "give a share above 0, at most 1");
  }
  if (panel.view.focus && !(panel.view.focus->radius > 0 && panel.view.focus->centre.allFinite() &&
                            std::isfinite(panel.view.focus->radius)))
    return fail("view", "looks at a place without an extent", "give a finite place and a radius above 0");
  return {};
}

/// Around everything in a panel, in the view's axes.
Box bounds(const Panel& panel, const Eigen::Matrix3d& axes) {
  Box box;
  for (const PictureMesh& mesh : panel.meshes) {
    for (std::size_t k = 0; k < mesh.positions.size(); k += 3)
      box.extend(axes * Eigen::Map<const Vec3>(&mesh.positions[k]));
  }
  for (const PicturePoints& points : panel.points) {
    for (const Vec3& x : points.positions) box.extend(axes * x);
  }
  return box.isEmpty() ? Box(Vec3(Vec3::Zero())) : box;
}

/// Columns that make the smaller side of a panel largest.
Index best_columns(Index panels, const PictureSettings& s) {
  Index best = 1;
  double best_side = 0;
  for (Index columns = 1; columns <= panels; ++columns) {
    const Index rows = (panels + columns - 1) / columns;
    const double side = std::min(double{1} * s.width / columns, double{1} * s.height / rows);
    if (side > best_side) {
      best_side = side;
      best = columns;
    }
  }
  return best;
}

Result<std::vector<Area>> arrange(Index panels, const PictureSettings& s) {
  const Index columns = s.columns ? std::min(s.columns, panels) : best_columns(panels, s);
  const Index rows = (panels + columns - 1) / columns;
  if (columns > s.width || rows > s.height)
    return fail("picture", fmt::format("{} panels have no room in {} x {} pixels", panels, s.width, s.height),
                "draw fewer, or a larger picture");
  std::vector<Area> areas;
  const auto cut = [](Index whole, Index part, Index parts) {
    return static_cast<Index>(std::uint64_t{whole} * part / parts);
  };
  for (Index k = 0; k < panels; ++k) {
    const Index column = k % columns, row = k / columns;
    const Index x = cut(s.width, column, columns), y = cut(s.height, row, rows);
    areas.push_back({x, y, cut(s.width, column + 1, columns) - x, cut(s.height, row + 1, rows) - y});
  }
  return areas;
}

Result<std::vector<Scene>> make_scenes(std::span<const Panel> panels, const PictureSettings& settings) {
  const auto areas = arrange(static_cast<Index>(panels.size()), settings);
  if (!areas) return tl::unexpected(areas.error());
  std::vector<Eigen::Matrix3d> axes;
  std::vector<Box> boxes;
  Vec3 largest = Vec3::Zero();
  for (const Panel& panel : panels) {
    if (const auto ok = require_panel(panel); !ok) return tl::unexpected(ok.error());
    const auto oriented = orientation(panel.view);
    if (!oriented) return tl::unexpected(oriented.error());
    axes.push_back(*oriented);
    boxes.push_back(bounds(panel, *oriented));
    largest = largest.cwiseMax(boxes.back().sizes());
    if (!(boxes.back().sizes().maxCoeff() < 1e150) || !(boxes.back().center().cwiseAbs().maxCoeff() < 1e150))
      return fail("picture", "a mesh is too large for the camera's arithmetic", "scale it down");
  }
  std::vector<Scene> scenes;
  for (std::size_t k = 0; k < panels.size(); ++k) {
    const Vec3 size = settings.same_scale ? largest : boxes[k].sizes();
    const Camera camera(panels[k].view, axes[k], boxes[k].center(), 0.5 * size, (*areas)[k],
                        settings.samples);
    scenes.push_back(make_scene(panels[k], (*areas)[k], camera, size.maxCoeff()));
  }
  return scenes;
}

/// Which faces and balls may reach into which band of rows.
struct Bands {
  std::vector<std::vector<Index>> faces, balls;

  Bands(const Scene& scene, Index samples) {
    const Index count = (scene.area.height + kBandRows - 1) / kBandRows;
    faces.resize(count);
    balls.resize(count);
    const double height = double{1} * kBandRows * samples;
    const auto put = [&](std::vector<std::vector<Index>>& bands, Index number, double least, double most) {
      const auto begin = static_cast<Index>(std::clamp(std::floor(least / height), 0.0, double{1} * count));
      const auto end = static_cast<Index>(std::clamp(std::floor(most / height) + 1, 0.0, double{1} * count));
      for (Index band = begin; band < end; ++band) bands[band].push_back(number);
    };
    for (Index k = 0; k < scene.faces.size(); ++k) {
      const Triangle& t = scene.faces[k].corners;
      const auto [least, most] = std::minmax({scene.spots[t[0]].y, scene.spots[t[1]].y, scene.spots[t[2]].y});
      put(faces, k, least, most);
    }
    for (Index k = 0; k < scene.balls.size(); ++k) {
      const Ball& ball = scene.balls[k];
      put(balls, k, ball.spot.y - ball.radius, ball.spot.y + ball.radius);
    }
  }
};

}  // namespace

Result<Image> draw_picture(std::span<const Panel> panels, const PictureSettings& settings) {
  if (const auto ok = require_settings(settings); !ok) return tl::unexpected(ok.error());
  if (panels.empty()) return fail("picture", "has no panel", "give at least one");
  const auto scenes = make_scenes(panels, settings);
  if (!scenes) return tl::unexpected(scenes.error());
  Image image{settings.width, settings.height, {}};
  image.pixels.resize(std::size_t{image.width} * image.height, settings.background);
  for (const Scene& scene : *scenes) {
    const Bands bands(scene, settings.samples);
    parallel_for(std::size_t{0}, bands.faces.size(), [&](std::size_t band) {
      const Index begin = static_cast<Index>(band) * kBandRows;
      const Index end = std::min(begin + kBandRows, scene.area.height);
      draw_rows(scene, settings.samples, settings.background, {begin, end}, bands.faces[band],
                bands.balls[band], image);
    });
  }
  return image;
}

}  // namespace foldproof
