/// Inside of ContactChecker.
#pragma once

#include "check/step.h"
#include "solver/candidate_lists.h"

namespace foldproof::inline internal {

/// Error: the argument `name` is no length.
Result<void> check_length(const char* name, double value);

}  // namespace foldproof::inline internal

namespace foldproof {

struct ContactChecker::Impl {
  Impl(std::shared_ptr<const CollisionMesh> of, const ContactSettings& with,
       std::shared_ptr<const PairFilter> pairs)
      : mesh(std::move(of)),
        settings(with),
        filter(*mesh, std::move(pairs)),
        pose_lists(*mesh, filter),
        step_lists(*mesh, filter) {}

  std::unique_ptr<Pipeline> make_pipeline() const {
    return std::make_unique<Pipeline>(std::vector<Object>{mesh->hierarchy()},
                                      Filter{&filter, {}, filter.ignores_nodes()});
  }
  template <class Run>
  Result<void> run(Run run) {
    return run_on(
        pipeline, [&] { return make_pipeline(); }, run);
  }
  void start_call() {
    work = {};
    milliseconds = {};
  }
  StepSettings step_settings(double distance) const;
  struct Question {
    double min_distance;
    double min_gap_share = 0, max_gap = 0;  ///< Of PairSettings.
    bool any_will_do = false;               ///< Not the first contact, but any.
  };
  /// When the first pair comes into contact; infinity when none does.
  Result<double> earliest_contact(std::span<const double> x0, std::span<const double> x1,
                                  const Question& question);
  /// Finds the pairs that come into contact: `step`.
  Result<void> find_contacts(std::span<const double> x0, std::span<const double> x1, const StepSettings& with,
                             const Question& question);
  Result<void> check_rescaling() const;
  /// The pair that the last earliest_contact found: a step size of 0 that it limits.
  StepSize limited(std::span<const double> x0, std::span<const double> x1) const;
  /// Its closest features at a time of the step.
  ClosePair closest(std::span<const double> x0, std::span<const double> x1, double time) const;
  /// What is asked of shorter steps, after earliest_contact has found one.
  Question shorter_step(std::span<const double> x0, std::span<const double> x1, double min_distance) const;
  /// The step size if there is a contact, which limits `size`: a step that ends before it.
  Result<StepSize> shortened(std::span<const double> x0, std::span<const double> x1, const Question& question,
                             StepSize size);

  Result<void> check_positions(std::span<const double> x0, std::span<const double> x1);

  /// Some of the relevant pairs whose boxes come near each other, and what is made of them.
  struct Part {
    std::vector<BoxPair> pairs;
    std::uint64_t vertex_pairs = 0, edge_pairs = 0;
    std::vector<BoxPair> of_kind[2];  ///< Those of a vertex, and of two edges, with active vertices.
    Candidates candidates;
    std::vector<ClosePair> close;
  };
  /// Finds the relevant pairs whose boxes come within `distance` at some time of the step; Ends = 1: in the
  /// pose x0 = x1. Calls `process` for parts of them, in several threads at once, then `merge` for the same
  /// parts in order.
  template <int Ends, class Process, class Merge>
  Result<void> find(CandidateLists<Ends>& lists, std::span<const double> x0, std::span<const double> x1,
                    double distance, Process process, Merge merge);
  /// The close pairs of a part that was found in a pose.
  void measure(Part& part, double distance, std::span<const std::uint8_t> active) const;

  std::shared_ptr<const CollisionMesh> mesh;
  ContactSettings settings;
  ContactFilter filter;
  std::unique_ptr<Pipeline> pipeline = make_pipeline();  ///< For steps and intersections.
  CandidateLists<1> pose_lists;
  CandidateLists<2> step_lists;
  std::vector<Part> parts;
  std::vector<Index> close_pair_table;
  StepResult step;
  StaticResult pose;
  std::vector<double> end_positions;  ///< Of a shortened step.
  Work work;
  StageTimes milliseconds;
};

}  // namespace foldproof
