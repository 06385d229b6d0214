#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <random>

#include "base/try.h"
#include "model/limits.h"
#include "model/references.h"
#include "model/trainer.h"

namespace foldproof {
namespace {

// By default. Charts from more poses prove little more, and the file grows.
constexpr Index kReferences = 16;

// For the progress: cost of building charts in a pose, and of learning from one, relative to testing one.
constexpr std::size_t kBuildWork = 8;
constexpr std::size_t kLearningWork = 6;

// Memory limit of the poses that are learned from.
constexpr std::uint64_t kMaxSampleBytes = std::uint64_t{512} << 20;
constexpr std::size_t kMinLearnedPoses = 3;

std::string name_of(const TrainPose& pose) {
  if (pose.motion->frame_count() == 1) return pose.motion->name();
  return fmt::format("{}, frame {}", pose.motion->name(), pose.frame);
}

Result<void> require_one_mesh(std::span<const TrainPose> poses) {
  if (poses.empty()) return fail(ErrorCode::InvalidArgument, "poses", "are none", "name at least one");
  const Motion& first = *poses[0].motion;
  const Motion* last = &first;
  for (const TrainPose& pose : poses) {
    if (std::exchange(last, pose.motion) == pose.motion) continue;
    if (pose.motion->topology() == first.topology()) continue;
    return fail(
        ErrorCode::InvalidMesh, pose.motion->name(),
        fmt::format("has other triangles than {}: {} over {} vertices instead of {} over {}", first.name(),
                    pose.motion->topology().triangles().size(), pose.motion->topology().vertex_count(),
                    first.topology().triangles().size(), first.topology().vertex_count()),
        "train one model per mesh, with the same triangles in the same order in every pose");
  }
  return require_few_loose_vertices(first.topology(), first.name());
}

Result<void> require_shares(const LearnSettings& learning) {
  const auto check = [](const char* what, double value) -> Result<void> {
    if (value > 0 && value <= 1) return {};
    return fail(ErrorCode::InvalidArgument, what,
                fmt::format("{} is not a share: above 0 and at most 1", value), "give another");
  };
  FOLDPROOF_TRY(check("energy", learning.size.energy));
  FOLDPROOF_TRY(check("key points", learning.key_points.max_share));
  return check("first key points", learning.key_points.first_share);
}

/// Collects the input of learning while poses are tested.
class LearnInputCollector {
 public:
  /// Selects poses: all of them, or evenly spaced ones when they are too many.
  LearnInputCollector(std::size_t poses, Index vertices, const LearnSettings& settings) {
    const std::uint64_t limit = kMaxSampleBytes / (sizeof(double) * 3 * std::uint64_t{vertices});
    const std::size_t count = std::min<std::uint64_t>({poses, settings.max_poses, limit});
    for (std::size_t k = 0; k < count; ++k) input_.poses.push_back(static_cast<Index>(k * poses / count));
  }
  std::size_t count() const { return input_.poses.size(); }

  /// Call once the charts are built, before visit.
  void begin(const std::shared_ptr<const ChartLibrary>& charts) {
    meter_.emplace(charts);
    input_.nodes = predictable_nodes(*charts);
    const auto columns = static_cast<Eigen::Index>(count());
    input_.samples.resize(3 * Eigen::Index{charts->slots()->hierarchy()->topology().vertex_count()}, columns);
    input_.margins.resize(static_cast<Eigen::Index>(input_.nodes.size()), columns);
  }
  /// Adds a pose if it is selected. Call with all poses, ascending.
  void visit(Index pose, std::span<const double> positions) {
    if (collected_ == count() || input_.poses[collected_] != pose) return;
    const auto column = static_cast<Eigen::Index>(collected_++);
    std::copy(positions.begin(), positions.end(), input_.samples.col(column).data());
    input_.margins.col(column) = meter_->measure(input_.nodes, positions);
  }
  const LearnInput& input() const { return input_; }

 private:
  LearnInput input_;
  std::optional<MarginMeter> meter_;
  std::size_t collected_ = 0;
};

/// One call of train_model.
class Training {
 public:
  Training(std::span<const TrainPose> poses, const TrainSettings& settings, const TrainHooks& hooks)
      : poses_(poses), settings_(settings), hooks_(hooks) {
    const std::size_t references = settings.references ? settings.references : kReferences;
    reference_count_ = std::min(references, poses.size());
    total_work_ = poses.size() + reference_count_ * kBuildWork;
    if (reference_count_ < poses.size()) total_work_ += poses.size();
    if (!settings.learn) return;
    const Index vertices = poses[0].motion->topology().vertex_count();
    collector_ = std::make_unique<LearnInputCollector>(poses.size(), vertices, settings.learning);
    if (collector_->count() < kMinLearnedPoses) {
      collector_.reset();
    } else {
      total_work_ += collector_->count() * kLearningWork + settings.random_poses * kBuildWork;
    }
  }

  Result<Model> run() {
    const Motion& first = *poses_[0].motion;
    positions_.resize(std::size_t{3} * first.topology().vertex_count());
    begin("building the hierarchy");
    FOLDPROOF_TRY(read_pose(0));
    auto hierarchy = FOLDPROOF_TRY(Hierarchy::build(first.topology(), positions_));
    FOLDPROOF_TRY(require_few_neighbors(hierarchy, first.name()));
    const auto slots =
        std::make_shared<const PatchSlots>(std::make_shared<const Hierarchy>(std::move(hierarchy)));
    const auto references = FOLDPROOF_TRY(choose(*slots));
    return train(slots, references);
  }

 private:
  bool cancelled() const { return hooks_.cancel && hooks_.cancel->load(std::memory_order_relaxed); }
  Result<void> check_cancelled() const {
    if (cancelled()) return fail(ErrorCode::Interrupted, "training", "was stopped", "there is no model");
    return {};
  }

  Result<void> read_pose(Index pose) {
    FOLDPROOF_TRY(check_cancelled());
    return poses_[pose].motion->read_frame(poses_[pose].frame, positions_);
  }

  void begin(const std::string& what) {
    if (hooks_.stage) hooks_.stage(what);
  }

  void finish(std::size_t work) {
    finished_work_ += work;
    if (hooks_.progress) {
      hooks_.progress(static_cast<double>(finished_work_) / static_cast<double>(total_work_));
    }
  }

  Result<std::vector<Index>> choose(const PatchSlots& slots) {
    std::vector<Index> chosen;
    if (reference_count_ == poses_.size()) {
      for (Index k = 0; k < poses_.size(); ++k) chosen.push_back(k);
      return chosen;
    }
    begin(fmt::format("comparing {} poses", poses_.size()));
    const BendDescriptor descriptor(slots);
    std::vector<std::vector<float>> descriptors;
    for (Index k = 0; k < poses_.size(); ++k) {
      FOLDPROOF_TRY(read_pose(k));
      descriptors.push_back(descriptor.of(positions_));
      finish(1);
    }
    return choose_references(descriptors, static_cast<Index>(reference_count_));
  }

  Result<Model> train(const std::shared_ptr<const PatchSlots>& slots, std::span<const Index> references) {
    Trainer trainer(slots, settings_);
    Model model;
    for (const TrainPose& pose : poses_) model.poses.push_back({name_of(pose), false, 0});
    for (std::size_t i = 0; i < references.size(); ++i) {
      const Index k = references[i];
      begin(fmt::format("building charts in pose {} of {}", i + 1, references.size()));
      FOLDPROOF_TRY(read_pose(k));
      trainer.learn(k, positions_);
      model.poses[k].reference = true;
      finish(kBuildWork);
    }
    begin(fmt::format("testing charts in {} pose{}", poses_.size(), poses_.size() == 1 ? "" : "s"));
    if (collector_) collector_->begin(trainer.charts());
    for (Index k = 0; k < poses_.size(); ++k) {
      FOLDPROOF_TRY(read_pose(k));
      model.poses[k].proven = trainer.prove(positions_);
      if (collector_) collector_->visit(k, positions_);
      finish(1);
    }
    model.program = version();
    model.settings = settings_;
    model.charts = trainer.charts();
    FOLDPROOF_TRY(add_learned(model));
    FOLDPROOF_TRY(train_random_poses(trainer, model));
    model.hard_leaves = trainer.hard_leaves();
    return model;
  }

  /// Each coordinate is a sum of four uniform numbers: nearly normal, and at most 3.5 standard deviations.
  Result<void> train_random_poses(Trainer& trainer, Model& model) {
    if (!model.learned) return {};
    const Pca& subspace = model.learned->pca;
    std::mt19937_64 random(1);
    for (Index k = 0; k < settings_.random_poses; ++k) {
      FOLDPROOF_TRY(check_cancelled());
      begin(fmt::format("building charts in random pose {} of {}", k + 1, settings_.random_poses));
      Eigen::VectorXd p = subspace.deviations;
      for (double& coordinate : p) {
        double sum = -2;
        for (int i = 0; i < 4; ++i) sum += static_cast<double>(random() >> 11) * 0x1p-53;
        coordinate *= std::sqrt(3.0) * sum;
      }
      const Eigen::VectorXd x = subspace.reconstruct(p);
      const std::span positions(x.data(), static_cast<std::size_t>(x.size()));
      trainer.learn(static_cast<Index>(model.poses.size()), positions);
      model.poses.push_back({fmt::format("random pose {} of {}", k + 1, settings_.random_poses), true,
                             trainer.prove(positions)});
      finish(kBuildWork);
    }
    return {};
  }

  Result<void> add_learned(Model& model) {
    if (!collector_) {
      model.not_learned = settings_.learn ? "too few poses" : "not requested";
      return {};
    }
    begin(fmt::format("learning from {} poses", collector_->count()));
    LearnHooks hooks;
    hooks.cancel = hooks_.cancel;
    const std::size_t before = finished_work_, work = collector_->count() * kLearningWork;
    hooks.progress = [&](double share) {
      const auto done = static_cast<std::size_t>(std::lround(share * static_cast<double>(work)));
      finish(before + done - finished_work_);
    };
    auto learned = learn(*model.hierarchy(), collector_->input(), settings_.learning, hooks);
    if (learned) {
      model.learned = std::make_shared<const Learned>(std::move(*learned));
    } else if (cancelled()) {
      return tl::unexpected(learned.error());
    } else {
      model.not_learned = learned.error().problem;
    }
    return {};
  }

  std::span<const TrainPose> poses_;
  const TrainSettings& settings_;
  const TrainHooks& hooks_;
  std::size_t reference_count_ = 0, total_work_ = 0, finished_work_ = 0;
  std::unique_ptr<LearnInputCollector> collector_;  // null: nothing is learned
  std::vector<double> positions_;                   // of the pose read last
};

}  // namespace

Result<Model> train_model(std::span<const TrainPose> poses, const TrainSettings& settings,
                          const TrainHooks& hooks) {
  FOLDPROOF_TRY(require_one_mesh(poses));
  FOLDPROOF_TRY(require_shares(settings.learning));
  return Training(poses, settings, hooks).run();
}

}  // namespace foldproof
