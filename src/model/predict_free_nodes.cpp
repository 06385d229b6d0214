// What the paper's mode trusts: certificates that are predicted from key points.
#include <fmt/format.h>

#include "foldproof/model.h"
#include "keypoints/least_squares.h"

namespace foldproof {
namespace {

Eigen::VectorXd margins_at(const Learned& learned, std::span<const double> x) {
  const Eigen::Map<const Eigen::VectorXd> pose(x.data(), static_cast<Eigen::Index>(x.size()));
  return learned.certificates->margins(rows_of(pose, learned.key_points.vertices));
}

}  // namespace

// A node is predicted free when its margin is above the threshold at the start and at the end of the step.
Result<void> predict_free_nodes(std::span<const std::shared_ptr<const Model>> models, Positions x0,
                                Positions x1, double miss_rate, std::vector<std::vector<std::uint8_t>>& out) {
  if (x0.size() != models.size() || x1.size() != models.size())
    return fail(ErrorCode::InvalidArgument, "positions",
                fmt::format("given for {} and {} objects", x0.size(), x1.size()),
                fmt::format("give them for all {}", models.size()));
  out.resize(models.size());
  for (std::size_t i = 0; i < models.size(); ++i) {
    if (!models[i] || !models[i]->learned || !models[i]->learned->certificates)
      return fail(ErrorCode::NotLearned, fmt::format("object {}", i),
                  "has nothing learned that predicts its certificates",
                  "train a model on at least 3 poses that differ, or leave the mode paper");
    const Learned& learned = *models[i]->learned;
    const CertificateMap& map = *learned.certificates;
    const Hierarchy& hierarchy = *models[i]->hierarchy();
    const std::size_t numbers = 3 * std::size_t{hierarchy.topology().vertex_count()};
    for (const std::span<const double> x : {x0[i], x1[i]}) {
      if (x.size() != numbers)
        return fail(ErrorCode::InvalidArgument, fmt::format("object {}", i),
                    fmt::format("has {} numbers in a pose", x.size()),
                    fmt::format("give {}, three per vertex", numbers));
    }
    out[i].assign(hierarchy.nodes().size(), 0);
    const auto excess = map.excess_for(miss_rate);
    if (!excess) continue;
    const Eigen::VectorXd margins = margins_at(learned, x0[i]).cwiseMin(margins_at(learned, x1[i]));
    for (std::size_t k = 0; k < map.nodes.size(); ++k)
      out[i][map.nodes[k]] = margins[static_cast<Eigen::Index>(k)] > map.thresholds[k] + *excess;
  }
  return {};
}

}  // namespace foldproof
