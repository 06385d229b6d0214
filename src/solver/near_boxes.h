/// Boxes in double precision: around points, and which of them come near each other.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <span>

#include "foldproof/base.h"

namespace foldproof {

/// A point in a pose, or at both ends of a step; the fourth coordinates are 0.
template <int Ends>
struct alignas(32) PlacedPoint {
  double x[Ends][4];
};

/// At each end the lower corner and the negated upper corner; the fourth coordinates are 0.
template <int Ends>
struct alignas(32) PlacedBox {
  double x[Ends][2][4];
};

/// Two boxes by their places in a row of boxes.
struct BoxPair {
  Index a, b;
};

/// What lies between two boxes along the axis and side where that is most, at the end where it is less there;
/// below zero when they overlap. One rounding, of a difference: what exceeds a number says that the
/// difference is at least that number.
template <int Ends>
double separation(const PlacedBox<Ends>& a, const PlacedBox<Ends>& b) {
  double most = -std::numeric_limits<double>::infinity();
  for (int side = 0; side < 2; ++side) {
    for (int axis = 0; axis < 3; ++axis) {
      double least = a.x[0][side][axis] + b.x[0][1 - side][axis];
      if (Ends == 2) least = std::min(least, a.x[Ends - 1][side][axis] + b.x[Ends - 1][1 - side][axis]);
      most = std::max(most, least);
    }
  }
  return most;
}

/// What is done with boxes in a row, by the best instructions that the machine has. `kept` has room for all
/// that are asked about, and takes the places of those whose separation is <= distance, a number of at least
/// 0, in their order; what is given back is how many these are.
template <int Ends>
struct BoxOperations {
  using Point = PlacedPoint<Ends>;
  using Box = PlacedBox<Ends>;
  template <std::size_t N>
  using Corners = std::span<const std::array<Index, N>>;  ///< Places of N points for each box.

  void (*fit_vertices)(const Point* points, Corners<1> corners, Box* boxes);
  void (*fit_edges)(const Point* points, Corners<2> corners, Box* boxes);
  void (*fit_triangles)(const Point* points, Corners<3> corners, Box* boxes);
  /// The box around points, at least one, and how far they went since they stood elsewhere: along each axis
  /// the least and the negated most, at any end; each rounded once.
  void (*fit_moving)(const Point* points, const Point* before, std::span<const Index> places, Box& box,
                     double (&went)[2][4]);
  /// `kept` may be where the pairs stand.
  std::size_t (*keep_near_pairs)(const Box* boxes, std::span<const BoxPair> pairs, double distance,
                                 BoxPair* kept);
  /// The pairs of `box` and each of boxes[begin, end).
  std::size_t (*keep_near)(const Box* boxes, Index begin, Index end, const Box& box, double distance,
                           Index* kept);
};

template <int Ends>
const BoxOperations<Ends>& box_operations();
template <>
const BoxOperations<1>& box_operations();
template <>
const BoxOperations<2>& box_operations();

}  // namespace foldproof
