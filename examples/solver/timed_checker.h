// Whom the solver asks about collisions, and what that takes.
#pragma once

#include "contact.h"

namespace example {

// What an implicit solver asks. Positions are those of all vertices.
class CollisionQueries {
 public:
  virtual ~CollisionQueries() = default;
  // How far towards x1 it may go: a share.
  virtual double step_size(std::span<const double> x0, std::span<const double> x1) = 0;
  virtual bool step_is_free(std::span<const double> x0, std::span<const double> x1) = 0;
  virtual void contacts(std::span<const double> x, double reach, std::vector<Contact>& out) = 0;
};

// Processor time of this program, all threads, in seconds.
double processor_time();

// The same questions to two checkers, one with certificates, one without: both must say the same.
class TimedChecker final : public CollisionQueries {
 public:
  explicit TimedChecker(std::shared_ptr<const foldproof::CollisionMesh> mesh);
  double step_size(std::span<const double> x0, std::span<const double> x1) override;
  bool step_is_free(std::span<const double> x0, std::span<const double> x1) override;
  bool intersects(std::span<const double> x);
  void contacts(std::span<const double> x, double reach, std::vector<Contact>& out) override;
  double seconds_with() const { return seconds_[0]; }
  double seconds_without() const { return seconds_[1]; }
  // What a solver that asks one of them does not do.
  double seconds_compared() const { return seconds_compared_; }
  // Times when the two did not agree; and errors, of which there are none when positions are finite.
  int disagreements() const { return disagreements_; }

 private:
  template <class Ask>
  auto ask_both(Ask ask);
  std::shared_ptr<const foldproof::CollisionMesh> mesh_;
  foldproof::ContactChecker checkers_[2];
  double seconds_[2] = {}, seconds_compared_ = 0;
  int disagreements_ = 0;
  std::vector<Contact> other_;
};

}  // namespace example
