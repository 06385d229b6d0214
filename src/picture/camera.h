/// Projects mesh units to samples.
#pragma once

#include <Eigen/Geometry>

#include "foldproof/eigen.h"
#include "picture/picture.h"

namespace foldproof::picture {

using Box = Eigen::AlignedBox3d;

/// A point in the grid of samples, y down.
struct ScreenPoint {
  double x, y;
  /// 1 / distance in perspective, else -distance: larger is nearer, and it is affine over a triangle.
  double reversed_depth;
};

/// A rectangle of pixels.
struct PixelRect {
  Index x, y, width, height;
};

/// The view's axes in rows: right, up, towards the eye. Error: a view without a direction.
Result<Eigen::Matrix3d> orientation(const View& view);

class Camera {
 public:
  /// Fits a box into `area`: its center and half its size, both in the view's axes.
  Camera(const View& view, const Eigen::Matrix3d& axes, const Eigen::Vector3d& center,
         const Eigen::Vector3d& half_size, const PixelRect& area, Index samples);

  ScreenPoint project(const Vec3& x) const;
  Vec3 rotate(const Vec3& direction) const { return to_vec3(axes_ * to_eigen(direction)); }
  /// The size on screen of a unit of length at a point, in samples.
  double samples_per_unit(const ScreenPoint& point) const {
    return perspective_ ? focal_ * point.reversed_depth : focal_;
  }
  /// The depth of a point that is `length` nearer to the eye.
  double nearer(const ScreenPoint& point, double length) const {
    return perspective_ ? 1 / (1 / point.reversed_depth - length) : point.reversed_depth + length;
  }

 private:
  void zoom_to(const View::Focus& focus, const PixelRect& area, Index samples);

  Eigen::Matrix3d axes_;
  Eigen::Vector3d center_;
  bool perspective_;
  double distance_ = 0;   // from the eye to the center
  double focal_ = 1;      // samples per unit of length, in perspective at distance 1
  double x_ = 0, y_ = 0;  // the center's projection
};

}  // namespace foldproof::picture
