/// Boxes in double precision: around points, and which of them are close.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <span>

#include "foldproof/base.h"

namespace foldproof::inline internal {

/// A point in a pose, or at both ends of a step; the fourth coordinates are 0.
template <int Ends>
struct alignas(32) PointAtEnds {
  double x[Ends][4];
};

/// At each end the lower corner and the negated upper corner; the fourth coordinates are 0.
template <int Ends>
struct alignas(32) BoxAtEnds {
  double x[Ends][2][4];
};

/// Two boxes by their indices in an array of boxes.
struct BoxPair {
  Index a, b;
};

/// The largest gap between two boxes along any axis and side, where the gap of a step is the smaller one of
/// both ends. Negative when they overlap. It is a single rounded difference, so if it exceeds a number, the
/// exact difference is at least that number.
template <int Ends>
double separation(const BoxAtEnds<Ends>& a, const BoxAtEnds<Ends>& b) {
  double largest = -std::numeric_limits<double>::infinity();
  for (int side = 0; side < 2; ++side) {
    for (int axis = 0; axis < 3; ++axis) {
      double gap = a.x[0][side][axis] + b.x[0][1 - side][axis];
      if (Ends == 2) gap = std::min(gap, a.x[Ends - 1][side][axis] + b.x[Ends - 1][1 - side][axis]);
      largest = std::max(largest, gap);
    }
  }
  return largest;
}

/// Operations on arrays of boxes, with the machine's best instruction set. Those that filter store in `kept`,
/// in order, the boxes or pairs whose separation is <= distance (at least 0), and return their number. `kept`
/// has space for the whole input.
template <int Ends>
struct BoxOperations {
  using Point = PointAtEnds<Ends>;
  using Box = BoxAtEnds<Ends>;
  template <std::size_t N>
  using Corners = std::span<const std::array<Index, N>>;  ///< Indices of N points for each box.

  void (*fit_vertices)(const Point* points, Corners<1> corners, Box* boxes);
  void (*fit_edges)(const Point* points, Corners<2> corners, Box* boxes);
  void (*fit_triangles)(const Point* points, Corners<3> corners, Box* boxes);
  /// The box around at least one point, and the points' displacements from their last positions: along each
  /// axis the minimum and the negated maximum, at any end; each rounded once.
  void (*fit_moving)(const Point* points, const Point* last_points, std::span<const Index> indices, Box& box,
                     double (&displacement)[2][4]);
  /// `kept` may be the array of the pairs.
  std::size_t (*keep_near_pairs)(const Box* boxes, std::span<const BoxPair> pairs, double distance,
                                 BoxPair* kept);
  /// Of boxes[begin, end) those close to `box`: their indices.
  std::size_t (*keep_near)(const Box* boxes, Index begin, Index end, const Box& box, double distance,
                           Index* kept);
};

template <int Ends>
const BoxOperations<Ends>& box_operations();
template <>
const BoxOperations<1>& box_operations();
template <>
const BoxOperations<2>& box_operations();

}  // namespace foldproof::internal
