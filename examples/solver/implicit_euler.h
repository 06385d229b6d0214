// Implicit Euler as a minimization, by Newton's method on Eigen's conjugate gradients; contact by a barrier.
#pragma once

#include <Eigen/IterativeLinearSolvers>

#include "scene.h"
#include "timed_checker.h"

namespace example {

struct StepReport {
  int newton_steps = 0;
  std::size_t contacts = 0;
  double least_share = 1;      // of a Newton step that could be taken
  bool collision_free = true;  // every Newton step was
};

class ImplicitEuler {
 public:
  ImplicitEuler(const Scene& scene, CollisionQueries& checker, int most_newton_steps = 12);
  StepReport step();
  std::span<const double> positions() const { return x_; }

 private:
  using Vector = Eigen::VectorXd;
  double energy(std::span<const double> x, std::span<const Contact> contacts) const;
  void assemble(std::span<const Contact> contacts);
  void add_block(Index a, Index b, const Eigen::Matrix3d& block);
  bool newton_step(StepReport& report);
  bool descend(const std::vector<double>& target, double share, double before, StepReport& report);

  const Scene& scene_;
  CollisionQueries& checker_;
  const Barrier barrier_;
  const int most_newton_steps_;
  int steps_ = 0;
  std::vector<double> x_, velocity_, inertial_, trial_;
  std::vector<Contact> contacts_, trial_contacts_;
  std::vector<Eigen::Triplet<double>> triplets_;
  Vector gradient_;
  Eigen::SparseMatrix<double> hessian_;
  Eigen::ConjugateGradient<Eigen::SparseMatrix<double>> conjugate_gradients_;
};

}  // namespace example
