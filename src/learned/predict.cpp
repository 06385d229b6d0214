#include <cmath>

#include "foldproof/learned.h"

namespace foldproof {
namespace {

using Eigen::VectorXd;

class PredictedMotion final : public Motion {
 public:
  PredictedMotion(std::string name, Topology topology, std::shared_ptr<const Predictor> predictor,
                  KeyPointTracks tracks)
      : name_(std::move(name)),
        topology_(std::move(topology)),
        predictor_(std::move(predictor)),
        tracks_(std::move(tracks)) {}

  const std::string& name() const override { return name_; }
  const Topology& topology() const override { return topology_; }
  Index frame_count() const override { return tracks_.frames; }

  Result<void> read_frame(Index k, std::span<double> out) override {
    const std::size_t row = std::size_t{3} * tracks_.points;
    const VectorXd x = predictor_->from_key_points(
        Eigen::Map<const VectorXd>(tracks_.positions.data() + k * row, static_cast<Eigen::Index>(row)));
    if (!x.allFinite()) {
      return fail(ErrorCode::NonFinite, tracks_.name + ", frame " + std::to_string(k),
                  "is too far away to compute with", "give positions in the unit of the training poses");
    }
    std::copy(x.begin(), x.end(), out.begin());
    return {};
  }

 private:
  std::string name_;
  Topology topology_;
  std::shared_ptr<const Predictor> predictor_;
  KeyPointTracks tracks_;
};

}  // namespace

Predictor::Predictor(std::shared_ptr<const Learned> learned)
    : learned_(std::move(learned)), map_(learned_->pca, learned_->key_points.vertices) {}

VectorXd Predictor::from_coordinates(const VectorXd& p) const {
  if (!learned_->kernel) return learned_->pca.reconstruct(p);
  const KernelPca& kernel = *learned_->kernel;
  const VectorXd y = kernel.pca.project(learned_->pca.reconstruct(p));
  return kernel.reconstruct(kernel.project_coordinates(y));
}

VectorXd Predictor::from_key_points(const VectorView& key_positions) const {
  return from_coordinates(map_.coordinates(key_positions));
}

VectorXd Predictor::from_all_points(const VectorView& x) const {
  return from_coordinates(learned_->pca.project(x));
}

PoseError Predictor::error(const VectorView& x) const {
  const VectorXd best = from_all_points(x), from_keys = from_key_points(map_.gather(x));
  return {vertex_distance(x, best), vertex_distance(best, from_keys), vertex_distance(x, from_keys)};
}

std::unique_ptr<Motion> predicted_motion(std::string name, Topology topology,
                                         std::shared_ptr<const Predictor> predictor, KeyPointTracks tracks) {
  return std::make_unique<PredictedMotion>(std::move(name), std::move(topology), std::move(predictor),
                                           std::move(tracks));
}

}  // namespace foldproof
