#include <fmt/format.h>

#include <algorithm>

#include "base/try.h"
#include "report/report.h"

namespace foldproof {

Result<std::vector<std::shared_ptr<const Model>>> load_models(std::span<const std::string> paths,
                                                              Motions motions) {
  std::vector<std::shared_ptr<const Model>> models;
  for (const std::string& path : paths) {
    auto model = FOLDPROOF_TRY(load_model(path));
    models.push_back(std::make_shared<const Model>(std::move(model)));
  }
  if (models.size() != 1 || motions.size() < 2) return models;
  const auto model = models[0];
  const auto fits = [&](const auto& motion) { return model->hierarchy()->topology() == motion->topology(); };
  if (std::none_of(motions.begin(), motions.end(), fits)) {
    return fail(ErrorCode::InvalidArgument, paths[0], "is a model of none of these meshes",
                "train a model on one of them");
  }
  models.clear();
  for (const auto& motion : motions) models.push_back(fits(motion) ? model : nullptr);
  return models;
}

Result<void> require_models_of(Motions motions, const CheckSettings& settings) {
  if (settings.models.empty()) return {};
  if (settings.models.size() != motions.size()) {
    return fail(ErrorCode::InvalidArgument, "models",
                fmt::format("are {} for {} motions", settings.models.size(), motions.size()),
                "give one for all, or one for each");
  }
  for (std::size_t i = 0; i < motions.size(); ++i) {
    if (!settings.models[i]) continue;
    FOLDPROOF_TRY(require_model_of(*settings.models[i], motions[i]->topology(), motions[i]->name(),
                                   motions[i]->info().merged));
  }
  return {};
}

}  // namespace foldproof
