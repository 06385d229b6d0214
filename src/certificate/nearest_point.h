/// The point of a convex hull that is nearest to the origin, where only support points of the hull are known.
#pragma once

#include <array>

namespace foldproof::inline internal {

/// Wolfe's algorithm (Finding the nearest point in a polytope, 1976), in three dimensions. A heuristic: in
/// single precision it promises nothing.
class NearestPoint {
 public:
  using Point = std::array<float, 3>;

  /// Starts from a point that is likely to be near, of the hull or not.
  explicit NearestPoint(const Point& start) : points_{start}, nearest_(start) {}

  /// The nearest point so far.
  const Point& point() const { return nearest_; }

  /// Adds the support point against the direction of the nearest point. False where the hull has no nearer
  /// point, or has the origin within: that ends the search.
  bool add(const Point& support) {
    const float last = dot(nearest_, nearest_);
    points_[count_] = support;
    weights_[count_++] = 0;
    if (descend() && dot(nearest_, nearest_) < last) return true;
    if (!has_start_) return false;
    *this = NearestPoint(support);  // the start may have been no point of the hull
    has_start_ = false;
    return true;
  }

 private:
  static float dot(const Point& a, const Point& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

  // Moves to the nearest point of those that were added. False if they have the origin between them, or if
  // one is superfluous.
  bool descend() {
    while (true) {
      std::array<float, 4> wanted;  // weights of the point nearest in the line, plane or space of all points
      if (!find_weights(wanted)) return false;
      float step = 1;
      int at_zero = -1;
      for (int i = 0; i < count_; ++i) {
        if (wanted[i] > 0 || weights_[i] > step * (weights_[i] - wanted[i])) continue;
        step = weights_[i] / (weights_[i] - wanted[i]);
        at_zero = i;
      }
      for (int i = 0; i < count_; ++i) weights_[i] += step * (wanted[i] - weights_[i]);
      if (at_zero < 0) break;
      remove(at_zero);
    }
    nearest_ = {};
    for (int i = 0; i < count_; ++i) {
      for (int axis = 0; axis < 3; ++axis) nearest_[axis] += weights_[i] * points_[i][axis];
    }
    return count_ < 4;
  }

  void remove(int which) {
    has_start_ &= which > 0;
    --count_;
    for (int i = which; i < count_; ++i) {
      points_[i] = points_[i + 1];
      weights_[i] = weights_[i + 1];
    }
  }

  // By Gaussian elimination. False if one point is in the plane, or on the line, of the others.
  bool find_weights(std::array<float, 4>& weights) const {
    const int n = count_ - 1;
    Point side[3];
    float a[3][3], b[3];
    for (int i = 0; i < n; ++i) {
      for (int axis = 0; axis < 3; ++axis) side[i][axis] = points_[i + 1][axis] - points_[0][axis];
      b[i] = -dot(side[i], points_[0]);
      for (int k = 0; k <= i; ++k) a[i][k] = a[k][i] = dot(side[i], side[k]);
    }
    for (int i = 0; i < n; ++i) {
      if (!(a[i][i] > 0)) return false;
      for (int k = i + 1; k < n; ++k) {
        const float factor = a[k][i] / a[i][i];
        for (int j = i; j < n; ++j) a[k][j] -= factor * a[i][j];
        b[k] -= factor * b[i];
      }
    }
    weights[0] = 1;
    for (int i = n; i-- > 0;) {
      for (int k = i + 1; k < n; ++k) b[i] -= a[i][k] * weights[k + 1];
      weights[i + 1] = b[i] / a[i][i];
      weights[0] -= weights[i + 1];
    }
    return true;
  }

  std::array<Point, 4> points_;
  std::array<float, 4> weights_{1};
  int count_ = 1;
  bool has_start_ = true;  // as the first point
  Point nearest_;
};

}  // namespace foldproof::inline internal
