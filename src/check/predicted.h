/// The mode `paper`: what key points make believe of a step.
#pragma once

#include <memory>
#include <vector>

#include "foldproof/learned.h"

namespace foldproof {

/// Certificates of nodes as they are predicted from the key points at both ends of a step (paper, Eq. 3).
/// They prove nothing.
class PredictedCertificates {
 public:
  /// `learned` has certificates.
  PredictedCertificates(std::shared_ptr<const Learned> learned, std::size_t node_count);

  /// Predicts. Cost: see CertificateMap::margins. `miss_rate`: see StepSettings.
  void look(std::span<const double> x0, std::span<const double> x1, double miss_rate);
  /// Whether the node's certificate is believed at both ends; never without a prediction.
  bool holds(Index node) const { return believed_[node] != 0; }

 private:
  Eigen::VectorXd margins_at(std::span<const double> x) const;

  std::shared_ptr<const Learned> learned_;
  std::vector<std::uint8_t> believed_;
};

}  // namespace foldproof
