#include <fmt/format.h>

#include <cmath>
#include <map>
#include <random>

#include "base/try.h"
#include "foldproof/check.h"
#include "foldproof/model.h"

namespace foldproof {
namespace {

// Shapes given by coordinates, or by positions if they were repaired, in single precision.
class SampledMotion final : public Motion {
 public:
  SampledMotion(const Model& model, std::shared_ptr<const Predictor> predictor)
      : name_(model.name), topology_(model.hierarchy()->topology()), predictor_(std::move(predictor)) {}

  void add(Eigen::VectorXd coordinates) { coordinates_.push_back(std::move(coordinates)); }
  void pop() {
    coordinates_.pop_back();
    repaired_.erase(frame_count());
  }
  /// Replaces the last shape.
  void replace(std::span<const double> x) { repaired_[frame_count() - 1].assign(x.begin(), x.end()); }
  std::size_t repaired() const { return repaired_.size(); }

  const std::string& name() const override { return name_; }
  const Topology& topology() const override { return topology_; }
  Index frame_count() const override { return static_cast<Index>(coordinates_.size()); }

  Result<void> read_frame(Index k, std::span<double> out) override {
    if (const auto repaired = repaired_.find(k); repaired != repaired_.end()) {
      std::ranges::copy(repaired->second, out.begin());
      return {};
    }
    const Eigen::VectorXd x = predictor_->from_coordinates(coordinates_[k]);
    if (!x.cast<float>().allFinite())
      return fail(ErrorCode::NonFinite, fmt::format("shape {}", k), "is too large to compute with",
                  "give a smaller spread");
    std::ranges::transform(x, out.begin(), [](double c) { return static_cast<float>(c); });
    return {};
  }

 private:
  std::string name_;
  Topology topology_;
  std::shared_ptr<const Predictor> predictor_;
  std::vector<Eigen::VectorXd> coordinates_;
  std::map<Index, std::vector<float>> repaired_;
};

Result<void> require_settings(const Model& model, const SampleSettings& settings) {
  FOLDPROOF_TRY(require_learned(model));
  if (settings.count < 1) return fail(ErrorCode::InvalidArgument, "count", "is 0", "give at least 1");
  if (!(settings.spread > 0) || !std::isfinite(settings.spread))
    return fail(ErrorCode::InvalidArgument, "spread",
                fmt::format("{} is not a positive number", settings.spread), "give another");
  return {};
}

}  // namespace

Result<Samples> sample_shapes(const Model& model, const SampleSettings& settings, const TrainHooks& hooks) {
  FOLDPROOF_TRY(require_settings(model, settings));
  const auto predictor = std::make_shared<const Predictor>(model.learned);
  auto shapes = std::make_unique<SampledMotion>(model, predictor);
  StepChecker checker({model.object()});
  StaticResult found;
  std::vector<double> x(3 * std::size_t{model.hierarchy()->topology().vertex_count()});
  const Eigen::VectorXd deviations = settings.spread * model.learned->pca.deviations;
  std::mt19937_64 random(settings.seed);
  std::normal_distribution<double> normal(0, 1);
  std::uint64_t drawn = 0;
  while (shapes->frame_count() < settings.count) {
    if (hooks.cancel != nullptr && *hooks.cancel)
      return fail(ErrorCode::Interrupted, "interrupted", "not all shapes were drawn", "nothing was written");
    if (drawn > 1000 && shapes->frame_count() < drawn / 100) {
      return fail(ErrorCode::LimitExceeded, model.name,
                  fmt::format("crosses itself in all but {} of {} shapes that were drawn",
                              shapes->frame_count(), drawn),
                  "give a smaller spread, or train it on poses that do not cross themselves");
    }
    ++drawn;
    shapes->add(deviations.unaryExpr([&](double deviation) { return deviation * normal(random); }));
    FOLDPROOF_TRY(shapes->read_frame(shapes->frame_count() - 1, x));
    const std::span<const double> positions[] = {x};
    FOLDPROOF_TRY(checker.check_static(positions, {}, found));
    if (found.crossing_count > 0 && settings.repair && FOLDPROOF_TRY(settings.repair(x))) {
      shapes->replace(x);
      FOLDPROOF_TRY(shapes->read_frame(shapes->frame_count() - 1, x));  // rounded
      FOLDPROOF_TRY(checker.check_static(positions, {}, found));
    }
    if (found.crossing_count > 0) shapes->pop();
    if (hooks.progress) hooks.progress(static_cast<double>(shapes->frame_count()) / settings.count);
  }
  const std::uint64_t repaired = shapes->repaired();
  return Samples{std::move(shapes), drawn, repaired};
}

}  // namespace foldproof
