/// Checks the competitors against each other on one step.
#pragma once

#include <string>

#include "competitor.h"
#include "foldproof/check.h"

namespace foldproof::bench {

/// The same collisions with the same times of impact, bit for bit.
bool same_answer(const StepResult& a, const StepResult& b);

class Verifier {
 public:
  Verifier(const Topology& topology, std::span<const double> x0, std::span<const double> x1)
      : topology_(topology), x0_(x0), x1_(x1) {}

  /// All peers are given the same boxes, so their candidates must be the same pairs, each once.
  Result<void> add_peer(const std::string& name, const Candidates& candidates);

  /// Every collision must be among the peers' candidates, or else its boxes come within the tolerance of each
  /// other.
  Result<void> check_answer(const StepResult& result) const;

 private:
  struct Sorted {
    std::string name;
    std::vector<Pair> vertex_face, edge_edge;
  };
  Index edge_id(const Edge& edge) const;

  const Topology& topology_;
  std::span<const double> x0_, x1_;
  std::vector<Sorted> first_;  ///< The first peer's candidates; empty before.
};

}  // namespace foldproof::bench
