/// From mesh units to samples.
#pragma once

#include <Eigen/Geometry>

#include "picture/picture.h"

namespace foldproof::picture {

using Box = Eigen::AlignedBox3d;

/// A place in the grid of samples, y down. `nearness` grows towards the eye and is affine over a triangle.
struct Spot {
  double x, y;
  double nearness;  ///< 1 / distance in perspective, else the negative distance.
};

/// A rectangle of pixels.
struct Area {
  Index x, y, width, height;
};

/// Rows: right, up, towards the eye. Error: a view without a direction.
Result<Eigen::Matrix3d> orientation(const View& view);

class Camera {
 public:
  /// `middle` is in the view's axes; `half` the extent that must fit on either side of it.
  Camera(const View& view, const Eigen::Matrix3d& axes, const Vec3& middle, const Vec3& half,
         const Area& area, Index samples);

  Spot project(const Vec3& x) const;
  Vec3 turn(const Vec3& direction) const { return axes_ * direction; }
  bool perspective() const { return perspective_; }
  /// How long a length looks at a spot, in samples.
  double scale_at(const Spot& spot) const { return perspective_ ? focal_ * spot.nearness : focal_; }
  /// The nearness of what lies `length` nearer to the eye than a spot.
  double nearer(const Spot& spot, double length) const {
    return perspective_ ? 1 / (1 / spot.nearness - length) : spot.nearness + length;
  }

 private:
  void look_at(const View::Focus& focus, const Area& area, Index samples);

  Eigen::Matrix3d axes_;
  Vec3 middle_;
  bool perspective_;
  double distance_ = 0;   // from the eye to the middle
  double focal_ = 1;      // samples per unit of length, in perspective at distance 1
  double x_ = 0, y_ = 0;  // where the middle is seen
};

}  // namespace foldproof::picture
