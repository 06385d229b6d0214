/// What certificates save: the same steps with and without them, after different trainings.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "scene.h"

namespace foldproof::bench {

struct CertificatePlan {
  Index steps = 40;           ///< Measured steps of each motion at most; they follow each other.
  Index learning_steps = 20;  ///< Steps before the first that counts, where nothing was trained.
  bool processor_time = false;
};

/// One row per scene, step size and training; counts and times are sums over the steps. Error: a scene cannot
/// be read, or an answer with certificates differs from the one without.
Result<nlohmann::json> compare_certificates(const std::vector<SceneInfo>& scenes,
                                            const CertificatePlan& plan);

}  // namespace foldproof::bench
