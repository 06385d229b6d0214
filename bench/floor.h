/// The floor: what it takes to read the mesh.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "foldproof/bvh.h"

namespace foldproof::bench {

/// Reads every vertex of one pose once, from the user's order and double precision, and fits a box to every
/// node of a hierarchy: single precision, one thread, nothing for the motion, nothing made safe. Whoever
/// looks at the mesh at all in a step does at least that.
class Floor {
 public:
  explicit Floor(const Hierarchy& hierarchy);
  void fit(std::span<const double> x);

  struct Leaf {
    Index node, begin, end;  ///< Which of the places are its vertices.
  };

 private:
  struct alignas(16) Point {
    float x[4];
  };
  struct alignas(32) Box {
    float x[8];  // x y z of the lower corner, then of the upper one negated; each padded
  };

  std::vector<Index> ids_;  // leaf order -> the user's id
  std::size_t place_of_last_ = 0;
  std::vector<Index> places_;  // of each leaf's vertices in leaf order
  std::vector<Leaf> leaves_;
  std::vector<Index> right_;  // per node: its right child, 0 for a leaf
  std::vector<Point> points_;
  std::vector<Box> boxes_;
};

}  // namespace foldproof::bench
