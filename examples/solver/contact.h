// Distances of candidate pairs, and a barrier on them.
#pragma once

#include "foldproof/solver.h"

namespace example {

// Two features closer than a barrier reaches: their distance is |sum of weights times vertices|.
struct Contact {
  std::array<foldproof::Index, 4> vertices;
  std::array<double, 4> weights;
  foldproof::Vec3 normal;  // from the second feature to the first, of length one
  double distance;
};

// Of all candidates those closer than `reach`, in the candidates' order.
void find_contacts(const foldproof::CollisionMesh& mesh, const foldproof::Candidates& candidates,
                   std::span<const double> x, double reach, std::vector<Contact>& out);

// -stiffness (d/reach - 1)^2 ln(d/reach), as incremental potential contact has it; joules. Zero from reach
// on, infinite at 0.
struct Barrier {
  double reach;
  double stiffness;
  double value(double d) const;
  double slope(double d) const;
  double curvature(double d) const;
};

}  // namespace example
