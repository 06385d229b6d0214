#include "picture/upright.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "base/try.h"
#include "foldproof/eigen.h"

namespace foldproof {
namespace {

using Box = Eigen::AlignedBox3d;

int axis_of(Up up) { return up == Up::Y ? 1 : 2; }

/// How far the lowest, or highest, point of the poses moves along each axis.
Eigen::Vector3d moved(std::span<const Box> poses, const Eigen::Vector3d& (Box::*end)() const) {
  Box ends;
  for (const Box& pose : poses) ends.extend((pose.*end)());
  return ends.sizes();
}

Result<Box> box_of_frame(std::span<const std::unique_ptr<Motion>> motions, Index frame) {
  Box box;
  std::vector<double> x;
  for (const auto& motion : motions) {
    x.resize(std::size_t{motion->topology().vertex_count()} * 3);
    FOLDPROOF_TRY(motion->read_frame(frame, x));
    box.extend(box_of(x));
  }
  return box;
}

/// The number of pixels of each side of a contact, red and blue, and of its curves, green.
Result<std::array<double, 3>> visible(const Panel& panel) {
  const auto image = FOLDPROOF_TRY(draw_picture(
      std::span(&panel, 1), {.width = 200, .height = 175, .samples = 1, .background = colors::kBlack}));
  std::array<double, 3> pixels{};
  for (const Color c : image.pixels) {
    if (c.red > 0) ++pixels[0];
    if (c.blue > 0) ++pixels[1];
    if (c.green > 0) ++pixels[2];
  }
  return pixels;
}

Box box_of_marked(std::span<const PictureMesh> meshes, const ContactMarks& marked) {
  Box box;
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    const auto triangles = meshes[i].topology->triangles();
    for (std::size_t t = 0; t < triangles.size(); ++t) {
      for (const Index v : triangles[t]) {
        if (marked[i][t]) box.extend(to_eigen(Vec3::load(&meshes[i].positions[3 * std::size_t{v}])));
      }
    }
  }
  return box;
}

/// Around the mesh, from above and below in turn.
std::vector<View> views_around(Up up) {
  std::vector<View> views;
  for (int k = 0; k < 8; ++k) {
    const double angle = k * std::numbers::pi / 4;
    views.push_back(upright({.from = {std::sin(angle), k % 2 == 0 ? 0.35 : -0.35, std::cos(angle)}}, up));
  }
  return views;
}

/// Around a normal, from its sides.
std::vector<View> views_across(const Vec3& normal, Up up) {
  std::vector<View> views;
  if (normal == Vec3::Zero()) return views;
  const Vec3 n = normal.normalized();
  Vec3 level = n.cross(default_view(up).up);
  if (level.norm() < 1e-3) level = n.cross(Vec3(1, 0, 0));
  const Vec3 u = level.normalized(), v = n.cross(u);
  for (int k = 0; k < 8; ++k) {
    const double angle = k * std::numbers::pi / 4;
    views.push_back(view_along(std::cos(angle) * u + std::sin(angle) * v, up));
  }
  return views;
}

/// The curves as points, at most 200.
PicturePoints points_on(std::span<const std::vector<Vec3>> curves, double size) {
  PicturePoints points{.positions = {}, .color = {0, 255, 0}, .size = size};
  std::size_t count = 0;
  for (const auto& curve : curves) count += curve.size();
  const std::size_t stride = 1 + count / 200;
  std::size_t k = 0;
  for (const auto& curve : curves) {
    for (const Vec3& point : curve)
      if (k++ % stride == 0) points.positions.push_back(point);
  }
  return points;
}

}  // namespace

Box box_of(std::span<const double> x) {
  Box box;
  for (std::size_t k = 0; k < x.size(); k += 3) box.extend(to_eigen(Vec3::load(&x[k])));
  return box;
}

Up guess_up(std::span<const Box> poses) {
  if (poses.empty()) return Up::Y;
  Box motion;
  for (const Box& pose : poses) motion.extend(pose);
  const Eigen::Vector3d lowest = moved(poses, &Box::min), highest = moved(poses, &Box::max);
  const double size = motion.sizes().maxCoeff();
  const auto stands_across = [&](int axis, int other) {
    const bool moves = std::max(lowest[axis], highest[axis]) > 1e-3 * size;
    return moves && lowest[axis] <= 0.05 * size && 3 * lowest[axis] <= lowest[other];
  };
  return stands_across(2, 1) && !stands_across(1, 2) ? Up::Z : Up::Y;
}

Result<MotionExtent> extent_of(std::span<const std::unique_ptr<Motion>> motions) {
  constexpr Index kFrames = 32;
  const Index last = motions[0]->frame_count() - 1, steps = std::min(last, kFrames - 1);
  MotionExtent extent;
  std::vector<Box> poses;
  for (Index k = 0; k <= steps; ++k) {
    const auto frame = static_cast<Index>(steps == 0 ? 0 : std::uint64_t{last} * k / steps);
    const Box box = FOLDPROOF_TRY(box_of_frame(motions, frame));
    extent.box.extend(box);
    poses.push_back(box);
  }
  const bool is_gltf = std::any_of(motions.begin(), motions.end(), [](const auto& motion) {
    const std::string extension = extension_of(motion->name());
    return extension == ".glb" || extension == ".gltf";
  });
  extent.up = is_gltf ? Up::Y : guess_up(poses);
  return extent;
}

View upright(const View& view, Up up) {
  if (up == Up::Y) return view;
  const auto turn = [](const Vec3& v) { return Vec3(v.x(), -v.z(), v.y()); };
  View turned = view;
  turned.from = turn(view.from);
  turned.up = turn(view.up);
  return turned;
}

View default_view(Up up) { return upright({.from = {0.4, 0.3, 1}}, up); }

View view_along(const Vec3& normal, Up up) {
  View view = default_view(up);
  const double height = normal[axis_of(up)];
  const double limit = std::sin(std::numbers::pi / 3) * normal.norm();
  Vec3 level = normal - height * view.up;
  // From straight above, the front stays below.
  if (level.norm() < 1e-6 * normal.norm()) level = upright({.from = {0, 0, 1}}, up).from;
  if (std::abs(height) <= limit) {
    view.from = normal;
  } else {
    view.from = 0.5 * normal.norm() * level.normalized() + std::copysign(limit, height) * view.up;
  }
  return view;
}

Result<View> view_of(std::span<const PictureMesh> meshes, const ContactMarks& marks,
                     std::span<const std::vector<Vec3>> curves, const Vec3& normal, Up up) {
  constexpr std::array<Color, 3> kOf{colors::kBlack, {255, 0, 0}, {0, 0, 255}};
  Panel shown{.meshes = {meshes.begin(), meshes.end()}};
  std::vector<std::vector<Color>> colors(meshes.size());
  std::array<bool, 3> has{};
  Box all;
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    for (const std::uint8_t mark : marks[i]) {
      colors[i].push_back(kOf[mark]);
      has[mark] = true;
    }
    shown.meshes[i].face_colors = colors[i];
    shown.meshes[i].smooth = false;
    all.extend(box_of(meshes[i].positions));
  }
  View best = default_view(up);
  const Box box = box_of_marked(meshes, marks);
  if (box.isEmpty()) return best;
  // Small marks would be less than a pixel.
  const View::Focus near{to_vec3(box.center()), std::max(0.6 * box.diagonal().norm(), 1e-300)};
  if (!curves.empty()) {
    const double size = near.radius / 60 / all.sizes().maxCoeff();
    shown.points.push_back(points_on(curves, std::clamp(size, 1e-9, 1.0)));
  }
  double most = 0;
  const auto consider = [&](const View& view, double weight) -> Result<void> {
    shown.view = view;
    shown.view.focus = near;
    const auto [first, second, curve] = FOLDPROOF_TRY(visible(shown));
    // Both sides count only together, unless there is one alone.
    const double sides = has[1] && has[2] ? std::sqrt(first * second) : first + second;
    // From below, the picture is strange to most.
    const bool below = view.from.dot(default_view(up).up) < -0.1 * view.from.norm();
    const double seen = (below ? 0.5 : 1) * weight * (sides + 2 * curve);
    if (seen > most) best = view;
    most = std::max(most, seen);
    return {};
  };
  for (const View& view : views_across(normal, up)) {
    FOLDPROOF_TRY(consider(view, 1.3));
  }
  for (const View& view : views_around(up)) {
    FOLDPROOF_TRY(consider(view, 1));
  }
  return best;
}

}  // namespace foldproof
