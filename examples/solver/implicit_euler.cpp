#include "implicit_euler.h"

#include <algorithm>
#include <cmath>

#include "foldproof/eigen.h"

namespace example {
namespace {

constexpr double kTimeStep = 0.01, kGravity = -9.81;
constexpr double kBarrierStiffness = 2e-3;
constexpr int kMaxHalvings = 12, kMaxIterations = 300;
constexpr double kResidual = 1e-3;           // of linear systems, relative: Newton goes on anyway
constexpr double kKept = 0.85;               // of its velocity by a vertex in contact: friction, roughly
constexpr double kStill = 2e-3 * kTimeStep;  // m: a Newton step below it ends the search

Vec3 at(std::span<const double> x, Index v) { return Vec3::load(&x[3 * std::size_t{v}]); }

/// n n^T
Eigen::Matrix3d square_of(const Vec3& n) {
  return foldproof::to_eigen(n) * foldproof::to_eigen(n).transpose();
}

}  // namespace

ImplicitEuler::ImplicitEuler(const Scene& scene, CollisionQueries& checker, int most_newton_steps)
    : scene_(scene),
      checker_(checker),
      barrier_{scene.reach, kBarrierStiffness},
      most_newton_steps_(most_newton_steps),
      x_(scene.x),
      velocity_(x_.size(), 0),
      inertial_(x_),
      trial_(x_) {
  conjugate_gradients_.setTolerance(kResidual);
  conjugate_gradients_.setMaxIterations(kMaxIterations);
}

// Times the square of the time step, so that it is in joules times it.
double ImplicitEuler::energy(std::span<const double> x, std::span<const Contact> contacts) const {
  double inertia = 0, potential = 0;
  for (Index v = 0; v < scene_.movable; ++v)
    inertia += scene_.mass[v] / 2 * (at(x, v) - at(inertial_, v)).squaredNorm();
  for (const Spring& s : scene_.springs)
    potential += s.stiffness / 2 * std::pow((at(x, s.a) - at(x, s.b)).norm() - s.rest, 2);
  for (const Contact& c : contacts) potential += c.count * barrier_.value(c.distance);
  return inertia + kTimeStep * kTimeStep * potential;
}

void ImplicitEuler::add_block(Index a, Index b, const Eigen::Matrix3d& block) {
  if (a >= scene_.movable || b >= scene_.movable || a < b) return;  // the lower triangle
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) {
      if (a > b || i >= k)
        triplets_.emplace_back(static_cast<int>(3 * a) + i, static_cast<int>(3 * b) + k, block(i, k));
    }
  }
}

// Gradient and a positive definite matrix near the second derivative: springs that are too short do not push
// sideways, and distances count as linear.
void ImplicitEuler::assemble(std::span<const Contact> contacts) {
  constexpr double kSquare = kTimeStep * kTimeStep;
  triplets_.clear();
  gradient_.setZero(3 * std::ptrdiff_t{scene_.movable});
  const auto add = [&](Index v, const Vec3& g) {
    if (v < scene_.movable) gradient_.segment<3>(3 * std::ptrdiff_t{v}) += foldproof::to_eigen(g);
  };
  for (Index v = 0; v < scene_.movable; ++v) {
    add(v, scene_.mass[v] * (at(x_, v) - at(inertial_, v)));
    add_block(v, v, scene_.mass[v] * Eigen::Matrix3d::Identity());
  }
  for (const Spring& s : scene_.springs) {
    const Vec3 along = at(x_, s.a) - at(x_, s.b);
    const double length = along.norm();
    const Vec3 n = along / length;
    const Vec3 force = kSquare * s.stiffness * (length - s.rest) * n;
    add(s.a, force);
    add(s.b, -force);
    const Eigen::Matrix3d nn = square_of(n);
    const double sideways = std::max(0.0, 1 - s.rest / length);
    const Eigen::Matrix3d k = kSquare * s.stiffness * (nn + sideways * (Eigen::Matrix3d::Identity() - nn));
    add_block(s.a, s.a, k);
    add_block(s.b, s.b, k);
    add_block(std::max(s.a, s.b), std::min(s.a, s.b), -k);
  }
  for (const Contact& c : contacts) {
    const double slope = kSquare * c.count * barrier_.slope(c.distance);
    const Eigen::Matrix3d k = kSquare * c.count * barrier_.curvature(c.distance) * square_of(c.normal);
    for (int i = 0; i < 4; ++i) {
      add(c.vertices[i], slope * c.weights[i] * c.normal);
      for (int j = 0; j < 4; ++j) add_block(c.vertices[i], c.vertices[j], c.weights[i] * c.weights[j] * k);
    }
  }
  hessian_.resize(gradient_.size(), gradient_.size());
  hessian_.setFromTriplets(triplets_.begin(), triplets_.end());
}

// Halves a step that is free of collisions until the energy falls. False: it does not.
bool ImplicitEuler::descend(const std::vector<double>& target, double share, double before,
                            StepReport& report) {
  for (int i = 0; i < kMaxHalvings && share > 0; ++i, share /= 2) {
    foldproof::step_towards(x_, target, share, trial_);
    checker_.contacts(trial_, barrier_.reach, trial_contacts_);
    if (energy(trial_, trial_contacts_) > before) continue;
    report.collision_free = report.collision_free && checker_.step_is_free(x_, trial_);
    x_.swap(trial_);
    contacts_.swap(trial_contacts_);
    return true;
  }
  return false;
}

// False when there is nothing left to gain.
bool ImplicitEuler::newton_step(StepReport& report) {
  assemble(contacts_);
  conjugate_gradients_.compute(hessian_);
  const Vector direction = conjugate_gradients_.solve(-gradient_);
  const double longest = direction.lpNorm<Eigen::Infinity>();
  if (!(longest > kStill)) return false;
  std::vector<double> target = x_;
  for (std::ptrdiff_t i = 0; i < direction.size(); ++i) target[static_cast<std::size_t>(i)] += direction[i];
  const double share = checker_.step_size(x_, target);
  report.least_share = std::min(report.least_share, share);
  ++report.newton_steps;
  return descend(target, share, energy(x_, contacts_), report);
}

StepReport ImplicitEuler::step() {
  const std::vector<double> start = x_;
  for (std::size_t i = 0; i < 3 * std::size_t{scene_.movable}; ++i) {
    const double gravity = i % 3 == 2 ? kGravity : 0;
    inertial_[i] = x_[i] + kTimeStep * velocity_[i] + kTimeStep * kTimeStep * gravity;
  }
  if (scene_.lead) scene_.lead(kTimeStep * ++steps_, inertial_);
  StepReport report;
  checker_.contacts(x_, barrier_.reach, contacts_);
  while (report.newton_steps < most_newton_steps_ && newton_step(report)) {
  }
  for (std::size_t i = 0; i < x_.size(); ++i) velocity_[i] = (x_[i] - start[i]) / kTimeStep;
  std::vector<double> kept(scene_.vertex_count(), 1);
  for (const Contact& c : contacts_) {
    for (const Index v : c.vertices) kept[v] = kKept;
  }
  for (std::size_t i = 0; i < x_.size(); ++i) velocity_[i] *= kept[i / 3];
  report.contacts = contacts_.size();
  return report;
}

}  // namespace example
