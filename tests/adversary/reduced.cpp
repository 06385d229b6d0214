#include <fmt/format.h>

#include "adversary/run.h"
#include "foldproof/reduced.h"
#include "oracle/same_answers.h"

namespace foldproof::adversary {
namespace {

// The first object's poses span a space of one or two modes.
Result<Pca> subspace_of(const Case& c) {
  const auto& first = c.steps[0].x0[0];
  Eigen::MatrixXd samples(static_cast<Eigen::Index>(first.size()),
                          2 * static_cast<Eigen::Index>(c.steps.size()));
  for (std::size_t k = 0; k < c.steps.size(); ++k) {
    const Step& step = c.steps[k];
    for (int end = 0; end < 2; ++end) {
      const Pose& x = end == 0 ? step.x0[0] : step.x1[0];
      samples.col(2 * static_cast<Eigen::Index>(k) + end) =
          Eigen::Map<const Eigen::VectorXd>(x.data(), samples.rows());
    }
  }
  return pca(samples, {.modes = 2});
}

}  // namespace

std::string check_reduced(const Case& c, Tally& tally) {
  now_asking("reduced coordinates");
  const Object& o = c.objects[0];
  const auto hierarchy =
      std::make_shared<const Hierarchy>(Hierarchy::build(Topology::make(o.vertex_count, o.triangles).value(),
                                                         c.steps[0].x0[0], {o.leaf_triangles})
                                            .value());
  const auto subspace = subspace_of(c);
  if (!subspace || subspace->modes() == 0) return {};
  auto made = ReducedMotion::make(hierarchy, *subspace);
  if (!made) return {};  // beyond the numbers that a model may have
  const auto motion = std::make_shared<const ReducedMotion>(std::move(*made));
  auto shape = ReducedShape::build(motion, {{std::vector<double>(motion->modes(), 0.0)}});
  if (!shape) return {};
  const auto shared = std::make_shared<const ReducedShape>(std::move(*shape));
  ReducedChecker checker({shared, shared});
  StepChecker vertices({hierarchy, hierarchy});
  std::mt19937_64 rng(c.seed);
  std::uniform_real_distribution<double> number(-3, 3);
  for (int round = 0; round < 4; ++round) {
    std::vector<double> p[4];
    const double far = std::exp2(number(rng)), stride = std::exp2(number(rng));
    for (int k = 0; k < 4; ++k) {
      for (Index mode = 0; mode < motion->modes(); ++mode) {
        const double way = motion->deviations()[mode] * number(rng) / 3;
        p[k].push_back(k % 2 == 0 ? far * way : p[k - 1][mode] + stride * way);
      }
    }
    const std::vector<ReducedPose> begin = {{p[0]}, {p[2]}}, end = {{p[1]}, {p[3]}};
    StepSettings settings = c.steps[0].settings;
    settings.earliest_only = false;
    StepResult reduced, full;
    if (!checker.check(begin, end, settings, reduced)) return {};
    Poses x[2];
    for (int k = 0; k < 4; ++k) {
      x[k % 2].emplace_back(3 * std::size_t{o.vertex_count});
      pose_vertices(*motion, {p[k]}, x[k % 2].back());
    }
    const std::vector<std::span<const double>> x0(x[0].begin(), x[0].end()), x1(x[1].begin(), x[1].end());
    settings.tolerance = reduced.tolerance;
    settings.certificates = false;
    if (const auto done = vertices.check(x0, x1, settings, full); !done)
      return "refused: " + done.error().line();
    ++tally.reduced_steps;
    if (!oracle::same_collisions(reduced, full)) {
      return fmt::format("reduced coordinates, round {}: {} and {} pairs, on all vertices {} and {}", round,
                         reduced.vertex_face.size(), reduced.edge_edge.size(), full.vertex_face.size(),
                         full.edge_edge.size());
    }
  }
  return {};
}

}  // namespace foldproof::adversary
