/// Foldproof in simulators that use ipc-toolkit: a narrow phase behind its interface.
///
/// See foldproof/ipc_toolkit.h, which includes it.
#pragma once

#if __cplusplus < 202002L
#error "Foldproof needs C++20: target_compile_features(simulator PRIVATE cxx_std_20)"
#endif

#include <algorithm>
#include <cmath>
#include <ipc/ccd/narrow_phase_ccd.hpp>
#include <stdexcept>

#include "foldproof/ccd.h"
#include "foldproof/eigen.h"

#if defined(EIGEN_DONT_VECTORIZE) && EIGEN_MAX_ALIGN_BYTES != 0
#error "foldproof_model has Eigen align more than ipc-toolkit does: see docs/ipc_toolkit.md, Build"
#endif

namespace foldproof::ipc_toolkit {

/// Types that differ between releases of ipc-toolkit, taken from the signatures of its interfaces.
namespace detail {

template <class Member>
struct Signature;

template <class Class, class Answer, class First, class... Others>
struct Signature<Answer (Class::*)(First, Others...) const> {
  using Parameter = First;
};
/// Of a function that is not overloaded: the type of its first parameter.
template <auto member>
using Parameter = typename Signature<decltype(member)>::Parameter;

/// Adds `conservative_rescaling` to a class that lacks it; since 1.6 there is one, which nobody sets.
template <class Base, class = void>
class Rescaling : public Base {
 public:
  double conservative_rescaling = 0.8;
};
template <class Base>
class Rescaling<Base, std::void_t<decltype(Base::conservative_rescaling)>> : public Base {
 public:
  Rescaling() { this->conservative_rescaling = 0.8; }
};

/// The value, or the error as an exception.
template <class T>
T value_of(Result<T> result) {
  if (!result) throw std::invalid_argument("foldproof: " + result.error().line());
  if constexpr (!std::is_void_v<T>) return std::move(*result);
}

}  // namespace detail

/// Narrow phase by vertex_face_ccd and edge_edge_ccd. False is proven: farther than `min_distance` from time
/// 0 to `tmax`. True: `toi` is a time up to which the pair is proven farther, and not above `tmax`; it is 0
/// if the pair starts too close. An undecided pair counts as true. `toi` is set with true only. 3D only.
/// Thread-safe.
class NarrowPhaseCCD : public detail::Rescaling<::ipc::NarrowPhaseCCD> {
 public:
  // conservative_rescaling, 0.8: `toi` is this share of the time to collision, in (0,1]. With 1 the next step
  // may start in collision.

  /// Rescales gaps, as ipc-toolkit's own do: `toi` is the time at which 1 - conservative_rescaling of the
  /// pair's gap at the start is left, of its distance less min_distance. A pair that comes no closer than
  /// that does not collide. Where that cannot be proven, the time is rescaled.
  bool rescale_distance = false;
  /// Mesh units. Pairs closer than `min_distance` plus this may count as collisions. 0: 2^-30 of the
  /// largest side of the box around the pair during the step.
  double tolerance = 0;

  using Point = detail::Parameter<&::ipc::NarrowPhaseCCD::point_point_ccd>;
  using Point3 = detail::Parameter<&::ipc::NarrowPhaseCCD::edge_edge_ccd>;

  bool point_point_ccd(Point p0_t0, Point p1_t0, Point p0_t1, Point p1_t1, double& toi,
                       double min_distance = 0, double tmax = 1) const override {
    const Vec3 p0 = in_3d(p0_t0), q0 = in_3d(p1_t0), p1 = in_3d(p0_t1), q1 = in_3d(p1_t1);
    return collide(foldproof::edge_edge_ccd, {p0, p0, q0, q0}, {p1, p1, q1, q1}, toi,
                   {min_distance, tolerance, tmax});
  }
  bool point_edge_ccd(Point p_t0, Point e0_t0, Point e1_t0, Point p_t1, Point e0_t1, Point e1_t1, double& toi,
                      double min_distance = 0, double tmax = 1) const override {
    const Vec3 p0 = in_3d(p_t0), p1 = in_3d(p_t1);
    return collide(foldproof::edge_edge_ccd, {p0, p0, in_3d(e0_t0), in_3d(e1_t0)},
                   {p1, p1, in_3d(e0_t1), in_3d(e1_t1)}, toi, {min_distance, tolerance, tmax});
  }
  bool point_triangle_ccd(Point3 p_t0, Point3 t0_t0, Point3 t1_t0, Point3 t2_t0, Point3 p_t1, Point3 t0_t1,
                          Point3 t1_t1, Point3 t2_t1, double& toi, double min_distance = 0,
                          double tmax = 1) const override {
    return collide(foldproof::vertex_face_ccd, points(p_t0, t0_t0, t1_t0, t2_t0),
                   points(p_t1, t0_t1, t1_t1, t2_t1), toi, {min_distance, tolerance, tmax});
  }
  bool edge_edge_ccd(Point3 ea0_t0, Point3 ea1_t0, Point3 eb0_t0, Point3 eb1_t0, Point3 ea0_t1, Point3 ea1_t1,
                     Point3 eb0_t1, Point3 eb1_t1, double& toi, double min_distance = 0,
                     double tmax = 1) const override {
    return collide(foldproof::edge_edge_ccd, points(ea0_t0, ea1_t0, eb0_t0, eb1_t0),
                   points(ea0_t1, ea1_t1, eb0_t1, eb1_t1), toi, {min_distance, tolerance, tmax});
  }

 private:
  static Vec3 in_3d(Point p) {
    if (p.size() != 3)
      throw std::invalid_argument("foldproof: a point has " + std::to_string(p.size()) +
                                  " coordinates, not 3; keep a narrow phase of ipc-toolkit for 2D");
    return to_vec3(p);
  }
  static FourPoints points(Point3 a, Point3 b, Point3 c, Point3 d) {
    return {to_vec3(a), to_vec3(b), to_vec3(c), to_vec3(d)};
  }
  bool collide(decltype(vertex_face_ccd)* ccd, const FourPoints& x0, const FourPoints& x1, double& toi,
               CcdSettings settings) const {
    Vec3 low = x0[0], high = x0[0];
    bool finite = std::isfinite(settings.thickness) && std::isfinite(settings.tolerance);
    for (const FourPoints* points : {&x0, &x1}) {
      for (const Vec3& p : *points) {
        low = low.cwiseMin(p);
        high = high.cwiseMax(p);
        finite = finite && p.allFinite();
      }
    }
    if (!(finite && settings.thickness >= 0 && settings.tolerance >= 0 && settings.latest >= 0 &&
          settings.latest <= 1 && conservative_rescaling > 0 && conservative_rescaling <= 1))
      throw std::invalid_argument(
          "foldproof: give finite positions, min_distance and tolerance finite and >= 0, tmax in [0,1], "
          "conservative_rescaling in (0,1]");
    if (settings.tolerance == 0) settings.tolerance = 0x1p-30 * (high - low).maxCoeff();
    if (rescale_distance) {
      const auto& closest = ccd == foldproof::vertex_face_ccd ? vertex_face_closest : edge_edge_closest;
      const double gap = closest(x0).distance - settings.thickness;
      CcdSettings kept = settings;
      kept.thickness += (1 - conservative_rescaling) * std::max(gap, 0.0);
      const CcdResult result = ccd(x0, x1, kept);
      if (result.answer == Answer::Separated) return false;
      if (result.toi > 0) {
        toi = result.toi;
        return true;
      }
    }
    const CcdResult result = ccd(x0, x1, settings);
    if (result.answer == Answer::Separated) return false;
    toi = conservative_rescaling * result.toi;
    return true;
  }
};

}  // namespace foldproof::ipc_toolkit
