/// Inside of ContactChecker.
#pragma once

#include "query/checker.h"
#include "solver/choice.h"

namespace foldproof {

/// Pairs of leaves that one task looks through for candidates. Reused.
struct CandidateChunk {
  std::span<const LeafPairRef> pairs;
  CandidateBuffer boxes;  ///< Pairs whose boxes are near each other.
  Candidates found;       ///< Those of them that count.
  double least = 0;       ///< Distance of the nearest of them.
};

struct ContactChecker::Impl {
  Impl(std::shared_ptr<const CollisionMesh> of, const ContactSettings& with)
      : mesh(std::move(of)),
        settings(with),
        choice(*mesh),
        scene({mesh->hierarchy()}, {}, {}),
        near({mesh->hierarchy()}, {}, {}) {}

  void begin() {
    work = {};
    milliseconds = {};
  }
  StepSettings step_settings(double distance) const;
  /// When the first pair comes into contact; infinity when none does.
  Result<double> earliest_contact(std::span<const double> x0, std::span<const double> x1,
                                  double min_distance);

  /// Finds the pairs that count and whose boxes come within `distance`, a bounded number at a time: `look`
  /// has each chunk, several threads at once; then `take` has it, in order.
  template <class Look, class Take>
  Result<void> find(std::span<const double> x0, std::span<const double> x1, double distance, Look look,
                    Take take);
  void choose(CandidateChunk& chunk) const;
  double least_distance(const Candidates& found, std::span<const double> x) const;

  std::shared_ptr<const CollisionMesh> mesh;
  ContactSettings settings;
  ContactChoice choice;
  Scene scene;  ///< For steps and intersections.
  Scene near;   ///< For candidates: another gap, so other charts and another front.
  std::vector<Chunk> chunks;
  std::vector<CandidateChunk> candidate_chunks;
  StepResult step;
  StaticResult pose;
  std::vector<double> reached;
  Work work;
  StageTimes milliseconds;
};

}  // namespace foldproof
