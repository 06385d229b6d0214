#include "picture/camera.h"

#include <algorithm>
#include <cmath>

#include "base/read_double.h"
#include "picture/upright.h"

namespace foldproof {
namespace picture {
namespace {

// Half the field of view along the smaller side of a panel: 14 degrees, a long lens with little distortion.
constexpr double kHalfAngle = 14 * 3.14159265358979323846 / 180;
// The share of a panel that its content may fill.
constexpr double kFill = 0.94;

}  // namespace

Result<Eigen::Matrix3d> orientation(const View& view) {
  const Vec3 back = view.from.stableNormalized();
  const Vec3 right = view.up.stableNormalized().cross(back);
  if (!(back.norm() > 0.5) || !(right.norm() > 1e-6)) {
    return fail(ErrorCode::InvalidArgument, "view",
                "needs a direction to the eye and a different up direction", "give another direction");
  }
  Eigen::Matrix3d axes;
  axes.row(0) = to_eigen(right.normalized());
  axes.row(1) = to_eigen(back.cross(right.normalized()));
  axes.row(2) = to_eigen(back);
  return axes;
}

Camera::Camera(const View& view, const Eigen::Matrix3d& axes, const Eigen::Vector3d& center,
               const Eigen::Vector3d& half_size, const PixelRect& area, Index samples)
    : axes_(axes), center_(center), perspective_(view.perspective) {
  const double width = 0.5 * area.width * samples, height = 0.5 * area.height * samples;
  x_ = width;
  y_ = height;
  const double min_size = std::max(half_size.maxCoeff() * 1e-3, 1e-300);  // content may have no extent
  const Eigen::Vector3d half = half_size.cwiseMax(min_size);
  if (perspective_) {
    focal_ = std::min(width, height) / std::tan(kHalfAngle);
    const double units_per_sample = std::max(half.x() / width, half.y() / height);
    distance_ = half.z() + focal_ * units_per_sample / kFill;
  } else {
    focal_ = kFill * std::min(width / half.x(), height / half.y());
  }
  if (view.focus) zoom_to(*view.focus, area, samples);
}

/// Enlarges a part of the fitted camera's image. The eye stays outside, so nothing is behind it.
void Camera::zoom_to(const View::Focus& focus, const PixelRect& area, Index samples) {
  const ScreenPoint point = project(focus.center);
  const double projected_radius = focus.radius * samples_per_unit(point);
  const double zoom = kFill * 0.5 * std::min(area.width, area.height) * samples / projected_radius;
  const double width = 0.5 * area.width * samples, height = 0.5 * area.height * samples;
  x_ = width + (x_ - point.x) * zoom;
  y_ = height + (y_ - point.y) * zoom;
  focal_ *= zoom;
}

ScreenPoint Camera::project(const Vec3& x) const {
  const Eigen::Vector3d local = axes_ * to_eigen(x) - center_;
  const double reversed_depth = perspective_ ? 1 / (distance_ - local.z()) : local.z();
  const double scale = perspective_ ? focal_ * reversed_depth : focal_;
  return {x_ + local.x() * scale, y_ - local.y() * scale, reversed_depth};
}

}  // namespace picture

Result<View> parse_view(const std::string& text, Up up) {
  if (text == "front") return upright({.from = {0, 0, 1}}, up);
  if (text == "back") return upright({.from = {0, 0, -1}}, up);
  if (text == "side") return upright({.from = {1, 0, 0}}, up);
  if (text == "top") return upright({.from = {0, 1, 0}, .up = {0, 0, -1}}, up);
  Vec3 from;
  const char *next = text.data(), *const end = next + text.size();
  bool valid = true;
  for (int axis = 0; axis < 3; ++axis) {
    if (axis > 0) valid = valid && next != end && *next++ == ',';
    const auto number = read_double(next, end, from[axis]);
    valid = valid && number.ec == std::errc{};
    next = number.ptr;
  }
  if (!valid || next != end || !from.allFinite() || from == Vec3::Zero()) {
    return fail(ErrorCode::InvalidArgument, "--view", "'" + text + "' is no view",
                "give auto, front, back, side, top, or a direction to the eye as x,y,z");
  }
  View view = upright({}, up);
  view.from = from;
  const Vec3 vertical = view.up * view.up.dot(from);
  if ((from - vertical).norm() < 1e-3 * vertical.norm())
    view.up = upright({.up = {0, 0, view.up.dot(from) > 0 ? -1.0 : 1.0}}, up).up;
  return view;
}

}  // namespace foldproof
