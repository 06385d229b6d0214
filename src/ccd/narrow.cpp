// Continuous collision of one pair of features. The proofs behind every bound stand in docs/soundness.md,
// section "Narrow phase"; the numbers N1..N6 below are its statements.

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "ccd/bounds.h"
#include "ccd/patch.h"
#include "foldproof/ccd.h"

namespace foldproof {
namespace {

// The Minkowski difference of two features, moving: corner k goes from a[k] to e[k]. The features touch when
// the origin lies in the convex hull of the corners: of 3 for vertex-face, of 4 for edge-edge (a
// parallelogram).
struct MovingPatch {
  PatchCorners a, e;
  int corners;
  Vec3 size = Vec3::Zero();  // per axis, the largest coordinate of any corner at either end
  double extent = 0;         // the largest of these

  Vec3 corner(int k, double t) const { return (1 - t) * a[k] + t * e[k]; }

  PatchCorners at(double t) const {
    PatchCorners d;
    for (int k = 0; k < corners; ++k) d[k] = corner(k, t);
    return d;
  }
};

MovingPatch make_patch(const FourPoints& x0, const FourPoints& x1, bool edge_edge, double scale) {
  MovingPatch patch;
  patch.corners = edge_edge ? 4 : 3;
  for (int end = 0; end < 2; ++end) {
    const FourPoints& x = end == 0 ? x0 : x1;
    PatchCorners& d = end == 0 ? patch.a : patch.e;
    const PatchCorners raw = edge_edge ? edge_edge_corners(x, scale) : vertex_face_corners(x, scale);
    for (int k = 0; k < patch.corners; ++k) {
      d[k] = raw[k];
      patch.size = patch.size.cwiseMax(d[k].cwiseAbs());
    }
  }
  patch.extent = patch.size.maxCoeff();
  return patch;
}

// In one stated order, which the batch keeps too.
double dot(const Vec3& a, const Vec3& b) { return a.x() * b.x() + a.y() * b.y() + a.z() * b.z(); }

// The signed volume that the origin spans with the first three corners, while they go from a to e: Bernstein
// coefficients of a cubic over that interval.
struct Volume {
  std::array<double, 4> b;

  Volume(const PatchCorners& a, const PatchCorners& e) {
    const Vec3 aa = a[1].cross(a[2]);
    const Vec3 ae = a[1].cross(e[2]) + e[1].cross(a[2]);
    const Vec3 ee = e[1].cross(e[2]);
    b = {dot(a[0], aa), (dot(e[0], aa) + dot(a[0], ae)) / 3, (dot(e[0], ae) + dot(a[0], ee)) / 3,
         dot(e[0], ee)};
  }

  // N3. One strict sign throughout: the origin is never coplanar with the corners, so the features cannot
  // touch.
  bool keeps_sign(double error) const {
    return (b[0] > error && b[1] > error && b[2] > error && b[3] > error) ||
           (b[0] < -error && b[1] < -error && b[2] < -error && b[3] < -error);
  }
};

double volume_error(const MovingPatch& patch) {
  return kDetError * (patch.size.x() * patch.size.y() * patch.size.z()) + kDetUnderflow;
}

// About where a cubic in Bernstein form first reaches zero on [0,1]; 1 when it does not seem to. Only a guess
// is needed: whoever uses it proves what lies before.
double guess_first_zero(const std::array<double, 4>& b) {
  const double c0 = b[0], c1 = 3 * (b[1] - b[0]), c2 = 3 * (b[2] - 2 * b[1] + b[0]),
               c3 = b[3] - 3 * (b[2] - b[1]) - b[0];
  const auto value = [&](double t) { return c0 + t * (c1 + t * (c2 + t * c3)); };
  // Between zeros of the derivative the cubic is monotone.
  std::array<double, 3> ends{1, 1, 1};
  const double q = c2 * c2 - 3 * c1 * c3;
  if (q > 0) {
    const double w = -(c2 + std::copysign(std::sqrt(q), c2));
    double r0 = w / (3 * c3), r1 = c1 / w;
    if (r1 < r0) std::swap(r0, r1);
    int count = 0;
    for (const double r : {r0, r1}) {
      if (r > 0 && r < 1) ends[count++] = r;
    }
  }
  double low = 0;
  for (double high : ends) {
    if (value(high) * c0 > 0) {
      low = high;
      continue;
    }
    double t = (low + high) / 2;
    for (int i = 0; i < 40 && high - low > 1e-16; ++i) {
      const double f = value(t);
      (f * c0 > 0 ? low : high) = t;
      const double slope = c1 + t * (2 * c2 + t * 3 * c3);
      const double newton = t - f / slope;
      const double next = newton > low && newton < high ? newton : (low + high) / 2;
      if (std::abs(next - t) < 1e-15) return next;
      t = next;
    }
    return t;
  }
  return 1;
}

// Advances a time before which nothing touches until the pair is within tolerance, or the step is over (N4).
class March {
 public:
  March(const MovingPatch& patch, double thickness, double tolerance)
      : patch_(patch),
        thickness_(thickness),
        apart_(thickness * (1 + 8 * kUnit) + kDotError * patch.extent),
        volume_error_(volume_error(patch)),
        target_(thickness + tolerance / 4),
        hit_(thickness + tolerance / 2) {
    double speed = 0;
    for (int k = 0; k < patch.corners; ++k) speed = std::max(speed, (patch.e[k] - patch.a[k]).norm());
    short_of_contact_ = tolerance / (8 * speed);
  }

  CcdResult run(double latest, int max_iterations) {
    stride_ = 1;
    for (int i = 0; i < max_iterations; ++i) {
      if (t_ > latest) return {Answer::Separated, 1};
      now_ = patch_.at(t_);
      const PatchClosest here = closest_to_origin(now_, patch_.corners);
      if (here.distance <= hit_) return {Answer::Hit, t_};
      if (t_ >= 1 || advance(here.normal)) return {Answer::Separated, 1};
      if (stuck_) break;
    }
    if (t_ > latest) return {Answer::Separated, 1};
    return {Answer::Undecided, t_};
  }

 private:
  // Moves t_ forward as far as something proves; true when that is to the end of the step.
  bool advance(const Vec3& normal) {
    const double plane_end = plane_reach(normal);
    if (plane_end >= 1) return true;
    const double left = 1 - t_;
    if (plane_end - t_ >= left / 8) {
      t_ = plane_end;
      return false;
    }
    if (thickness_ == 0) {
      const Volume volume(now_, patch_.e);
      if (volume.keeps_sign(volume_error_)) return true;
      const double end = t_ + left * guess_first_zero(volume.b) - short_of_contact_;
      if (end > plane_end && end < 1 && Volume(now_, patch_.at(end)).keeps_sign(volume_error_)) {
        t_ = end;
        return false;
      }
    }
    // The plane alone gets nowhere fast: try longer intervals with proofs that follow a turning pair.
    const double end = stride_ >= left ? 1 : t_ + stride_;
    if (end > plane_end) {
      if (free_until(end, normal)) {
        t_ = end;
        stride_ *= 2;
        return t_ >= 1;
      }
      stride_ = (end - t_) / 4;
    }
    stuck_ = !(end > t_) && !(plane_end > t_);
    if (plane_end > t_) {
      t_ = plane_end;
      stride_ = std::max(stride_, 0x1p-50);
    }
    return false;
  }

  // N2. The latest time until which one plane with this normal separates; t_ when it does not separate now.
  double plane_reach(const Vec3& normal) const {
    double reach = 1;
    bool to_end = true;
    for (int k = 0; k < patch_.corners; ++k) {
      const double g0 = normal.dot(now_[k]), g1 = normal.dot(patch_.e[k]);
      if (!(g0 > apart_)) return t_;
      if (g1 > apart_) continue;
      to_end = false;
      reach = std::min(reach, (g0 - target_) / (g0 - g1));
    }
    if (to_end) return 1;
    const double end = t_ + (1 - t_) * reach;
    if (!(end > t_) || !(end < 1)) return t_;
    for (int k = 0; k < patch_.corners; ++k) {
      if (!(normal.dot(patch_.corner(k, end)) > apart_)) return t_;
    }
    return end;
  }

  // N3 and N5 on [t_, end].
  bool free_until(double end, const Vec3& normal) const {
    const PatchCorners then = patch_.at(end);
    if (thickness_ == 0 && Volume(now_, then).keeps_sign(volume_error_)) return true;
    const Vec3 other = closest_to_origin(then, patch_.corners).normal;
    for (int k = 0; k < patch_.corners; ++k) {
      if (!(normal.dot(now_[k]) > apart_) || !(other.dot(then[k]) > apart_)) return false;
      if (!((normal.dot(then[k]) + other.dot(now_[k])) / 2 > apart_)) return false;
    }
    return true;
  }

  const MovingPatch& patch_;
  const double thickness_;
  const double apart_;  // a projection above this is proven to be above the thickness
  const double volume_error_;
  const double target_;  // where a plane's reach ends: short of `hit_`, so that the next look decides
  const double hit_;
  double short_of_contact_;  // time in which nothing moves farther than an eighth of the tolerance
  double t_ = 0;
  double stride_ = 1;
  bool stuck_ = false;
  PatchCorners now_;
};

// A power of two that brings a pair out of the range where products overflow or underflow; 1 for ordinary
// sizes.
double rescue_scale(const FourPoints& x0, const FourPoints& x1, double thickness) {
  double size = thickness;
  for (int i = 0; i < 4; ++i) {
    size = std::max({size, x0[i].cwiseAbs().maxCoeff(), x1[i].cwiseAbs().maxCoeff()});
  }
  if (size == 0) return 1;
  // Stay within the exponent range of double, so that the scale itself is a finite normal number.
  return std::ldexp(1.0, -std::clamp(std::ilogb(size), -1000, 1000));
}

CcdResult patch_ccd(const FourPoints& x0, const FourPoints& x1, bool edge_edge, const CcdSettings& settings) {
  double scale = 1;
  MovingPatch patch = make_patch(x0, x1, edge_edge, scale);
  const double size = std::max(patch.extent, settings.thickness);
  if (!(size < kLarge) || size < kSmall) {
    scale = rescue_scale(x0, x1, settings.thickness);
    patch = make_patch(x0, x1, edge_edge, scale);
    if (patch.extent > 0 && patch.extent < kSmall && settings.thickness * scale < kSmall) {
      // Far from the origin, yet tiny: the differences are exact, and can be scaled once more.
      const double again = std::ldexp(1.0, -std::max(std::ilogb(patch.extent), -1000));
      for (int k = 0; k < patch.corners; ++k) {
        patch.a[k] *= again;
        patch.e[k] *= again;
      }
      patch.size *= again;
      patch.extent *= again;
      scale *= again;
    }
  }
  const double thickness = settings.thickness * scale;
  const double tolerance = std::max(std::max(settings.tolerance, kLeastTolerance) * scale,
                                    kResolution * std::max(patch.extent, thickness));
  if (thickness == 0 && Volume(patch.a, patch.e).keeps_sign(volume_error(patch)))
    return {Answer::Separated, 1};
  return March(patch, thickness, tolerance).run(settings.latest, settings.max_iterations);
}

Closest closest(const FourPoints& x, bool edge_edge) {
  const double scale = rescue_scale(x, x, 0);
  const PatchCorners corners = edge_edge ? edge_edge_corners(x, scale) : vertex_face_corners(x, scale);
  const PatchClosest c = closest_to_origin(corners, edge_edge ? 4 : 3);
  return {c.distance / scale, c.difference / scale};
}

}  // namespace

CcdResult vertex_face_ccd(const FourPoints& x0, const FourPoints& x1, const CcdSettings& settings) {
  return patch_ccd(x0, x1, false, settings);
}

CcdResult edge_edge_ccd(const FourPoints& x0, const FourPoints& x1, const CcdSettings& settings) {
  return patch_ccd(x0, x1, true, settings);
}

double ccd_resolution(double extent) { return std::max(kResolution * extent, kLeastTolerance); }

Closest vertex_face_closest(const FourPoints& x) { return closest(x, false); }

Closest edge_edge_closest(const FourPoints& x) { return closest(x, true); }

}  // namespace foldproof
