#include "picture/camera.h"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace foldproof {
namespace picture {
namespace {

// Of the smaller side of a panel, from the middle: 14 degrees, a long lens that distorts little.
constexpr double kHalfAngle = 14 * 3.14159265358979323846 / 180;
// The share of a panel that things may fill.
constexpr double kFill = 0.94;

}  // namespace

Result<Eigen::Matrix3d> orientation(const View& view) {
  const Vec3 back = view.from.stableNormalized();
  const Vec3 right = view.up.stableNormalized().cross(back);
  if (!(back.norm() > 0.5) || !(right.norm() > 1e-6)) {
    return fail("view", "needs a direction to the eye, and another one that is up", "give another direction");
  }
  Eigen::Matrix3d axes;
  axes.row(0) = right.normalized();
  axes.row(1) = back.cross(axes.row(0).transpose());
  axes.row(2) = back;
  return axes;
}

Camera::Camera(const View& view, const Eigen::Matrix3d& axes, const Vec3& middle, const Vec3& half,
               const Area& area, Index samples)
    : axes_(axes), middle_(middle), perspective_(view.perspective) {
  const double width = 0.5 * area.width * samples, height = 0.5 * area.height * samples;
  x_ = width;
  y_ = height;
  const double least = std::max(half.maxCoeff() * 1e-3, 1e-300);  // for things without extent
  const Vec3 room = half.cwiseMax(least);
  if (perspective_) {
    focal_ = std::min(width, height) / std::tan(kHalfAngle);
    const double across = std::max(room.x() / width, room.y() / height);
    distance_ = room.z() + focal_ * across / kFill;
  } else {
    focal_ = kFill * std::min(width / room.x(), height / room.y());
  }
  if (view.focus) look_at(*view.focus, area, samples);
}

/// Cuts a part out of what the fitted camera sees, so nothing can be behind the eye.
void Camera::look_at(const View::Focus& focus, const Area& area, Index samples) {
  const Spot spot = project(focus.centre);
  const double seen = focus.radius * scale_at(spot);
  const double zoom = kFill * 0.5 * std::min(area.width, area.height) * samples / seen;
  const double width = 0.5 * area.width * samples, height = 0.5 * area.height * samples;
  x_ = width + (x_ - spot.x) * zoom;
  y_ = height + (y_ - spot.y) * zoom;
  focal_ *= zoom;
}

Spot Camera::project(const Vec3& x) const {
  const Vec3 seen = axes_ * x - middle_;
  const double nearness = perspective_ ? 1 / (distance_ - seen.z()) : seen.z();
  const double scale = perspective_ ? focal_ * nearness : focal_;
  return {x_ + seen.x() * scale, y_ - seen.y() * scale, nearness};
}

}  // namespace picture

Result<View> parse_view(const std::string& text) {
  if (text == "front") return View{.from = {0, 0, 1}};
  if (text == "back") return View{.from = {0, 0, -1}};
  if (text == "side") return View{.from = {1, 0, 0}};
  if (text == "top") return View{.from = {0, 1, 0}, .up = {0, 0, -1}};
  View view;
  const char *at = text.data(), *const end = at + text.size();
  bool read = true;
  for (int axis = 0; axis < 3; ++axis) {
    if (axis > 0) read = read && at != end && *at++ == ',';
    const auto number = std::from_chars(at, end, view.from[axis]);
    read = read && number.ec == std::errc{};
    at = number.ptr;
  }
  if (!read || at != end || !view.from.allFinite() || view.from.isZero(0)) {
    return fail("--view", "'" + text + "' is no view",
                "give front, back, side, top, or a direction to the eye as x,y,z");
  }
  const double sideways = std::hypot(view.from.x(), view.from.z());
  if (sideways < 1e-3 * std::abs(view.from.y())) view.up = {0, 0, view.from.y() > 0 ? -1.0 : 1.0};
  return view;
}

}  // namespace foldproof
