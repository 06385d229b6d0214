#include "reduced.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include <nlohmann/json.hpp>

#include "base/try.h"
#include "foldproof/reduced.h"
#include "measure.h"

namespace foldproof::bench {
namespace {

using nlohmann::json;

constexpr Index kModes = 6;

double now_microseconds(bool processor_time) { return 1e3 * now_milliseconds(processor_time); }

// How the tube of radius 1 and length 10 stands.
struct Form {
  double bend_y = 0, bend_z = 0, twist = 0, bulge = 0;
};

Eigen::VectorXd tube(Index around, Index along, const Form& form) {
  Eigen::VectorXd x(Eigen::Index{3} * around * (along + 1));
  const double bent = std::hypot(form.bend_y, form.bend_z), angle = std::atan2(form.bend_z, form.bend_y);
  for (Index j = 0; j <= along; ++j) {
    for (Index i = 0; i < around; ++i) {
      const double s = 10.0 * j / along - 5;
      const double phi = 2 * std::numbers::pi * i / around + form.twist * s / 5 - angle;
      const double r = 1 + form.bulge * std::exp(-s * s);
      const double turn = bent * std::tanh(s / 2) / 2;
      const double up = r * std::cos(phi) * std::cos(turn) + (std::cosh(0.2 * s) - 1) * bent;
      const double side = r * std::sin(phi);
      x.segment<3>(3 * (Eigen::Index{j} * around + i)) = Eigen::Vector3d(
          s - r * std::cos(phi) * std::sin(turn), up * std::cos(angle) - side * std::sin(angle),
          up * std::sin(angle) + side * std::cos(angle));
    }
  }
  return x;
}

Topology tube_mesh(Index around, Index along) {
  std::vector<Triangle> triangles;
  for (Index j = 0; j < along; ++j) {
    for (Index i = 0; i < around; ++i) {
      const Index a = j * around + i, b = j * around + (i + 1) % around;
      triangles.push_back({a, b, a + around});
      triangles.push_back({b, b + around, a + around});
    }
  }
  return *Topology::make(around * (along + 1), std::move(triangles));
}

// The same thirty forms at every resolution, so that the subspace is the same but for the sampling.
Result<Pca> subspace_of(Index around, Index along) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal(0, 1);
  Eigen::MatrixXd samples(Eigen::Index{3} * around * (along + 1), 30);
  for (Eigen::Index k = 0; k < samples.cols(); ++k) {
    Form form;
    form.bend_y = 0.4 * normal(random);
    form.bend_z = 0.4 * normal(random);
    form.twist = 0.2 * normal(random);
    form.bulge = 0.1 * normal(random);
    samples.col(k) = tube(around, along, form);
  }
  return pca(samples, {.modes = kModes});
}

struct Cost {
  double checked = 0, proven = 0;  // microseconds
  double pairs = 0, leaf_pairs = 0;
  Index collisions = 0;
};

// Steps at one distance from the mean, in deviations; the fastest of several runs of each.
Result<Cost> cost_at(const std::shared_ptr<const ReducedShape>& shape, double distance,
                     const ReducedPlan& plan) {
  ReducedChecker checker({shape});
  ReducedShape::Scratch scratch;
  StepResult found;
  std::mt19937 random(4);
  std::normal_distribution<double> normal(0, 1);
  Cost cost;
  for (Index k = 0; k < plan.steps; ++k) {
    Eigen::Vector<double, kModes> direction, other;
    for (Index m = 0; m < kModes; ++m) {
      direction[m] = normal(random);
      other[m] = normal(random);
    }
    direction *= distance / direction.norm();
    const Eigen::Vector<double, kModes> end = 0.97 * direction + 0.05 * other.normalized();
    std::vector<double> p0(kModes), p1(kModes);
    for (Index m = 0; m < kModes; ++m) {
      p0[m] = direction[m] * shape->motion()->deviations()[m];
      p1[m] = end[m] * shape->motion()->deviations()[m];
    }
    const ReducedPose from{p0}, to{p1};
    double checked = std::numeric_limits<double>::infinity(), proven = checked;
    for (int round = 0; round < 5; ++round) {
      constexpr int kCalls = 100;  // asking for the time takes as long as a step
      const double start = now_microseconds(plan.processor_time);
      for (int call = 0; call < kCalls; ++call) {
        FOLDPROOF_TRY(checker.check({&from, 1}, {&to, 1}, {}, found));
      }
      checked = std::min(checked, (now_microseconds(plan.processor_time) - start) / kCalls);
      const double middle = now_microseconds(plan.processor_time);
      for (int call = 0; call < kCalls; ++call) shape->proven_free(p0, p1, scratch);
      proven = std::min(proven, (now_microseconds(plan.processor_time) - middle) / kCalls);
    }
    cost.checked += checked / plan.steps;
    cost.proven += proven / plan.steps;
    cost.pairs += static_cast<double>(found.work.certificate_tests + found.work.node_tests) / plan.steps;
    cost.leaf_pairs += static_cast<double>(found.work.leaf_pairs) / plan.steps;
    cost.collisions += !found.clean();
  }
  return cost;
}

Result<void> add_rows(Index triangles, const ReducedPlan& plan, json& rows) {
  // A tube ten times as long as thick, of nearly square cells.
  const auto around = static_cast<Index>(std::lround(std::sqrt(triangles * 2 * std::numbers::pi / 20)));
  const Index along = triangles / (2 * around);
  const auto subspace = FOLDPROOF_TRY(subspace_of(around, along));
  const std::span<const double> mean(subspace.mean.data(), static_cast<std::size_t>(subspace.mean.size()));
  auto hierarchy = FOLDPROOF_TRY(Hierarchy::build(tube_mesh(around, along), mean));
  auto motion =
      FOLDPROOF_TRY(ReducedMotion::make(std::make_shared<const Hierarchy>(std::move(hierarchy)), subspace));
  const double start = now_microseconds(plan.processor_time);
  auto built = ReducedShape::build(std::make_shared<const ReducedMotion>(std::move(motion)),
                                   {{std::vector<double>(kModes, 0.0)}});
  if (!built) return tl::unexpected(built.error());
  const double seconds = (now_microseconds(plan.processor_time) - start) / 1e6;
  const auto shape = std::make_shared<const ReducedShape>(std::move(*built));
  for (const double distance : {1.0, 3.0, 4.0, 4.5}) {
    const auto cost = FOLDPROOF_TRY(cost_at(shape, distance, plan));
    if (cost.collisions > 0)
      return fail("reduced", fmt::format("{} steps collide", cost.collisions), "measure nearer to the mean");
    rows.push_back({{"triangles", 2 * around * along},
                    {"build_seconds", seconds},
                    {"radius", shape->radius(0)},
                    {"distance", distance},
                    {"step_microseconds", cost.checked},
                    {"proven_free_microseconds", cost.proven},
                    {"node_pairs", cost.pairs},
                    {"leaf_pairs", cost.leaf_pairs}});
  }
  return {};
}

}  // namespace

Result<json> measure_reduced(const ReducedPlan& plan) {
  json rows = json::array();
  for (Index triangles = 10'000; triangles <= plan.largest; triangles *= 10)
    FOLDPROOF_TRY(add_rows(triangles, plan, rows));
  return rows;
}

}  // namespace foldproof::bench
