/// Inside of ContactChecker.
#pragma once

#include "check/step.h"
#include "solver/candidate_lists.h"

namespace foldproof {

struct ContactChecker::Impl {
  Impl(std::shared_ptr<const CollisionMesh> of, const ContactSettings& with)
      : mesh(std::move(of)),
        settings(with),
        filter(*mesh),
        pipeline({mesh->hierarchy()}),
        of_pose(*mesh, filter),
        of_step(*mesh, filter) {}

  void begin() {
    work = {};
    milliseconds = {};
  }
  StepSettings step_settings(double distance) const;
  /// When the first pair comes into contact; infinity when none does.
  Result<double> earliest_contact(std::span<const double> x0, std::span<const double> x1,
                                  double min_distance);

  /// Finds the pairs that count and whose boxes come within `distance` at some time of the step, or in a pose
  /// where both ends are the same array: `look` has them part by part, several threads at once, and `take`
  /// has the same parts in order.
  template <class Look, class Take>
  Result<void> find(std::span<const double> x0, std::span<const double> x1, double distance, Look look,
                    Take take);
  double least_distance(const Candidates& found, std::span<const double> x) const;

  std::shared_ptr<const CollisionMesh> mesh;
  ContactSettings settings;
  ContactFilter filter;
  Pipeline pipeline;  ///< For steps and intersections.
  CandidateLists<1> of_pose;
  CandidateLists<2> of_step;
  struct Part {
    Candidates found;
    std::vector<BoxPair> scratch;
    double least = 0;  ///< Distance of the nearest of them.
  };
  std::vector<Part> parts;
  StepResult step;
  StaticResult pose;
  std::vector<double> reached;
  Work work;
  StageTimes milliseconds;
};

}  // namespace foldproof
