#include "check/predicted.h"

#include "keypoints/least_squares.h"

namespace foldproof {

PredictedCertificates::PredictedCertificates(std::shared_ptr<const Learned> learned, std::size_t node_count)
    : learned_(std::move(learned)), believed_(node_count, 0) {}

Eigen::VectorXd PredictedCertificates::margins_at(std::span<const double> x) const {
  const Eigen::Map<const Eigen::VectorXd> pose(x.data(), static_cast<Eigen::Index>(x.size()));
  const Eigen::VectorXd keys = rows_of(pose, learned_->key_points.vertices);
  return learned_->certificates->margins(keys);
}

void PredictedCertificates::look(std::span<const double> x0, std::span<const double> x1, double miss_rate) {
  const CertificateMap& map = *learned_->certificates;
  const auto excess = map.excess_for(miss_rate);
  const Eigen::VectorXd least = margins_at(x0).cwiseMin(margins_at(x1));
  for (std::size_t k = 0; k < map.nodes.size(); ++k) {
    believed_[map.nodes[k]] =
        excess && least[static_cast<Eigen::Index>(k)] > map.thresholds[k] + *excess ? 1 : 0;
  }
}

}  // namespace foldproof
