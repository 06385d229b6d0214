// The predictions that Mode::Paper trusts.
#include "foldproof/learned.h"
#include "keypoints/least_squares.h"

namespace foldproof {
namespace {

class PredictedCertificates : public NodePredictor {
 public:
  explicit PredictedCertificates(std::shared_ptr<const Learned> learned) : learned_(std::move(learned)) {}

  // A node is predicted free when its margin is above the threshold at the start and at the end of the step.
  void predict(std::span<const double> x0, std::span<const double> x1, double miss_rate,
               std::span<std::uint8_t> free) const override {
    const CertificateMap& map = *learned_->certificates;
    const auto excess = map.excess_for(miss_rate);
    const Eigen::VectorXd margins = margins_at(x0).cwiseMin(margins_at(x1));
    std::fill(free.begin(), free.end(), std::uint8_t{0});
    if (!excess) return;
    for (std::size_t k = 0; k < map.nodes.size(); ++k)
      free[map.nodes[k]] = margins[static_cast<Eigen::Index>(k)] > map.thresholds[k] + *excess;
  }

 private:
  Eigen::VectorXd margins_at(std::span<const double> x) const {
    const Eigen::Map<const Eigen::VectorXd> pose(x.data(), static_cast<Eigen::Index>(x.size()));
    return learned_->certificates->margins(rows_of(pose, learned_->key_points.vertices));
  }

  std::shared_ptr<const Learned> learned_;
};

}  // namespace

std::shared_ptr<const NodePredictor> predicted_certificates(std::shared_ptr<const Learned> learned) {
  if (!learned || !learned->certificates) return nullptr;
  return std::make_shared<const PredictedCertificates>(std::move(learned));
}

}  // namespace foldproof
