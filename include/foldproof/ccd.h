/// Narrow phase: one pair of features, moving along straight lines for t in [0,1] or at rest.
#pragma once

#include "foldproof/base.h"

namespace foldproof {

/// The answer for a pair of features during a step.
enum class Answer : std::uint8_t {
  Separated,  ///< Proven, in floating point: the distance exceeds `thickness` during [0, latest].
  Hit,        ///< At `toi` the distance is at most thickness + tolerance; nothing touches before.
  Undecided,  ///< The iteration limit was reached at `toi`; nothing touches before. Counts as a hit.
};

struct CcdSettings {
  double thickness = 0;  ///< Mesh units, >= 0. A distance up to this is a collision.
  double tolerance = 0;  ///< Mesh units, >= 0. How far beyond `thickness` a Hit may be. Raised to the
                         ///< resolution of double arithmetic at these positions (see ccd_resolution).
  double latest = 1;     ///< In [0,1]. Stop when proven free until here; then the answer is Separated.
  int max_iterations = 100000;
};

struct CcdResult {
  Answer answer = Answer::Separated;
  double toi = 1;  ///< Proven free of collision on [0, toi); at toi itself see Answer. 1 when Separated.
};

/// Positions of the four vertices of a pair at one end of the step, in mesh units.
/// Vertex-face: v f0 f1 f2. Edge-edge: ea0 ea1 eb0 eb1.
using FourPoints = std::array<Vec3, 4>;

/// Vertex against triangle. Triangles may degenerate to segments or points.
/// Precondition: finite coordinates. Cost: about 0.1 us when far apart, a microsecond when close; queries
/// process eight pairs at once. Thread-safe. Soundness: docs/soundness.md, "Narrow phase".
CcdResult vertex_face_ccd(const FourPoints& x0, const FourPoints& x1, const CcdSettings& settings);

/// Edge against edge. Edges may degenerate to points and may be parallel. Otherwise as vertex_face_ccd.
CcdResult edge_edge_ccd(const FourPoints& x0, const FourPoints& x1, const CcdSettings& settings);

/// The smallest tolerance, mesh units, that double arithmetic supports for a pair whose coordinates differ by
/// at most `extent` mesh units. Never below 2^-1060.
double ccd_resolution(double extent);

/// A closest pair of points of two features at rest.
struct Closest {
  double distance;  ///< Mesh units.
  Vec3 difference;  ///< Point on the first feature minus point on the second.
};
Closest vertex_face_closest(const FourPoints& x);
Closest edge_edge_closest(const FourPoints& x);

/// Sign of the signed volume of (a, b, c, d): +1 when d lies on the side of plane abc from which abc is seen
/// clockwise, -1 on the other side, 0 when exactly coplanar. Exact for all finite doubles.
int orient3d(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

/// Exact test whether three points are not on one line.
bool triangle_has_area(const Vec3& a, const Vec3& b, const Vec3& c);

/// Exact test whether two closed triangles have a point in common; they may degenerate to segments or points.
/// Touching counts.
bool triangles_intersect(const std::array<Vec3, 3>& a, const std::array<Vec3, 3>& b);

/// Exact test whether a closed segment and a closed triangle have a point in common.
bool segment_intersects_triangle(const std::array<Vec3, 2>& s, const std::array<Vec3, 3>& t);

/// Exact test whether two triangles abc, abd that share the edge ab are folded flat onto each other:
/// coplanar, with c and d on the same side of ab. Degenerate triangles: any common point away from the edge.
bool triangles_fold(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

}  // namespace foldproof
