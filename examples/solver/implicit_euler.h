// Implicit Euler as a minimization, by Newton's method on Eigen's sparse Cholesky; contact by a barrier.
#pragma once

#include <Eigen/SparseCholesky>

#include "contact.h"
#include "scene.h"

namespace example {

// Processor time of this program, all threads, in seconds.
double processor_time();

// The same questions to two checkers, one with certificates, one without: both must say the same.
class TimedChecker {
 public:
  explicit TimedChecker(std::shared_ptr<const foldproof::CollisionMesh> mesh);
  double step_size(std::span<const double> x0, std::span<const double> x1);
  bool step_is_free(std::span<const double> x0, std::span<const double> x1);
  bool intersects(std::span<const double> x);
  void contacts(std::span<const double> x, double reach, std::vector<Contact>& out);
  double seconds_with() const { return seconds_[0]; }
  double seconds_without() const { return seconds_[1]; }
  // Times when the two did not agree; and errors, of which there are none when positions are finite.
  int disagreements() const { return disagreements_; }

 private:
  template <class Ask>
  auto ask_both(Ask ask);
  std::shared_ptr<const foldproof::CollisionMesh> mesh_;
  foldproof::ContactChecker checkers_[2];
  double seconds_[2] = {};
  int disagreements_ = 0;
  foldproof::Candidates candidates_;
  std::vector<Contact> other_;
};

struct StepReport {
  int newton_steps = 0;
  std::size_t contacts = 0;
  double least_share = 1;      // of a Newton step that could be taken
  bool collision_free = true;  // every Newton step was
};

class ImplicitEuler {
 public:
  ImplicitEuler(const Scene& scene, TimedChecker& checker);
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
  TimedChecker& checker_;
  std::vector<double> x_, velocity_, inertial_, trial_;
  std::vector<Contact> contacts_, trial_contacts_;
  std::vector<Eigen::Triplet<double>> triplets_;
  Vector gradient_;
  Eigen::SparseMatrix<double> hessian_;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> cholesky_;
};

}  // namespace example
