#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <random>

#include "model/limits.h"
#include "model/references.h"
#include "model/trainer.h"

namespace foldproof {
namespace {

// Without a number from the user: charts from more poses prove little more, and the file grows.
constexpr Index kReferences = 16;

// What it costs to draw in a pose, in terms of what it costs to look at one.
constexpr std::size_t kDrawingWork = 8;
// The same for learning from one.
constexpr std::size_t kLearningWork = 6;

// Of the poses that learning holds.
constexpr std::uint64_t kMostSampleBytes = std::uint64_t{512} << 20;
constexpr std::size_t kFewestPoses = 3;

std::string name_of(const TrainPose& pose) {
  if (pose.motion->frame_count() == 1) return pose.motion->name();
  return fmt::format("{}, frame {}", pose.motion->name(), pose.frame);
}

Result<void> require_one_mesh(std::span<const TrainPose> poses) {
  if (poses.empty()) return fail("poses", "are none", "name at least one");
  const Motion& first = *poses[0].motion;
  const Motion* last = &first;
  for (const TrainPose& pose : poses) {
    if (std::exchange(last, pose.motion) == pose.motion) continue;
    if (pose.motion->topology() == first.topology()) continue;
    return fail(
        pose.motion->name(),
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
    return fail(what, fmt::format("{} is not a share: above 0 and at most 1", value), "give another");
  };
  if (auto ok = check("energy", learning.size.energy); !ok) return ok;
  if (auto ok = check("key points", learning.key_points.most_share); !ok) return ok;
  return check("first key points", learning.key_points.first_share);
}

/// What learning collects while the poses are looked at.
class Collection {
 public:
  /// Which of so many poses: evenly taken where they are too many.
  Collection(std::size_t poses, Index vertices, const LearnSettings& settings) {
    const std::uint64_t fit = kMostSampleBytes / (sizeof(double) * 3 * std::uint64_t{vertices});
    const std::size_t count = std::min<std::uint64_t>({poses, settings.most_poses, fit});
    for (std::size_t k = 0; k < count; ++k) input_.poses.push_back(static_cast<Index>(k * poses / count));
  }
  std::size_t count() const { return input_.poses.size(); }

  void begin(const std::shared_ptr<const ChartLibrary>& charts) {
    meter_.emplace(charts);
    input_.nodes = predictable_nodes(*charts);
    const auto columns = static_cast<Eigen::Index>(count());
    input_.samples.resize(3 * Eigen::Index{charts->slots()->hierarchy()->topology().vertex_count()}, columns);
    input_.margins.resize(static_cast<Eigen::Index>(input_.nodes.size()), columns);
  }
  void look_at(Index pose, std::span<const double> positions) {
    if (taken_ == count() || input_.poses[taken_] != pose) return;
    const auto column = static_cast<Eigen::Index>(taken_++);
    std::copy(positions.begin(), positions.end(), input_.samples.col(column).data());
    input_.margins.col(column) = meter_->of(input_.nodes, positions);
  }
  const LearnInput& input() const { return input_; }

 private:
  LearnInput input_;
  std::optional<MarginMeter> meter_;
  std::size_t taken_ = 0;
};

/// Training that is under way.
class Run {
 public:
  Run(std::span<const TrainPose> poses, const TrainSettings& settings, const TrainHooks& hooks)
      : poses_(poses), settings_(settings), hooks_(hooks) {
    wanted_ = std::min<std::size_t>(settings.references ? settings.references : kReferences, poses.size());
    expected_ = poses.size() + wanted_ * kDrawingWork + (wanted_ < poses.size() ? poses.size() : 0);
    if (!settings.learn) return;
    collection_ = std::make_unique<Collection>(poses.size(), poses[0].motion->topology().vertex_count(),
                                               settings.learning);
    if (collection_->count() < kFewestPoses) collection_.reset();
    if (collection_) expected_ += collection_->count() * kLearningWork + settings.made * kDrawingWork;
  }

  Result<Model> run() {
    positions_.resize(std::size_t{3} * poses_[0].motion->topology().vertex_count());
    if (auto read = enter(0); !read) return tl::unexpected(read.error());
    auto hierarchy = Hierarchy::build(poses_[0].motion->topology(), positions_);
    const std::string name = poses_[0].motion->name();
    if (!hierarchy) return tl::unexpected(hierarchy.error());
    if (auto ok = require_few_neighbours(*hierarchy, name); !ok) return tl::unexpected(ok.error());
    const auto slots =
        std::make_shared<const PatchSlots>(std::make_shared<const Hierarchy>(std::move(*hierarchy)));
    const auto references = choose(*slots);
    if (!references) return tl::unexpected(references.error());
    return learn(slots, *references);
  }

 private:
  bool cancelled() const { return hooks_.cancel && hooks_.cancel->load(std::memory_order_relaxed); }
  Result<void> go_on() const {
    if (cancelled()) return fail("training", "was stopped", "there is no model");
    return {};
  }

  /// Reads a pose, unless the user has had enough.
  Result<void> enter(Index pose) {
    if (auto ok = go_on(); !ok) return ok;
    return poses_[pose].motion->read_frame(poses_[pose].frame, positions_);
  }

  void finish(std::size_t work) {
    done_ += work;
    if (hooks_.progress) hooks_.progress(static_cast<double>(done_) / static_cast<double>(expected_));
  }

  Result<std::vector<Index>> choose(const PatchSlots& slots) {
    std::vector<Index> chosen;
    if (wanted_ == poses_.size()) {
      for (Index k = 0; k < poses_.size(); ++k) chosen.push_back(k);
      return chosen;
    }
    const BendDescriptor descriptor(slots);
    std::vector<std::vector<float>> descriptors;
    for (Index k = 0; k < poses_.size(); ++k) {
      if (auto read = enter(k); !read) return tl::unexpected(read.error());
      descriptors.push_back(descriptor.of(positions_));
      finish(1);
    }
    return choose_references(descriptors, static_cast<Index>(wanted_));
  }

  Result<Model> learn(const std::shared_ptr<const PatchSlots>& slots, std::span<const Index> references) {
    Trainer trainer(slots, settings_);
    Model model;
    for (const TrainPose& pose : poses_) model.poses.push_back({name_of(pose), false, 0});
    for (const Index k : references) {
      if (auto read = enter(k); !read) return tl::unexpected(read.error());
      trainer.learn(k, positions_);
      model.poses[k].reference = true;
      finish(kDrawingWork);
    }
    if (collection_) collection_->begin(trainer.charts());
    for (Index k = 0; k < poses_.size(); ++k) {
      if (auto read = enter(k); !read) return tl::unexpected(read.error());
      model.poses[k].proven = trainer.prove(positions_);
      if (collection_) collection_->look_at(k, positions_);
      finish(1);
    }
    model.program = version();
    model.settings = settings_;
    model.charts = trainer.charts();
    if (auto learned = add_learned(model); !learned) return tl::unexpected(learned.error());
    if (auto made = learn_from_made(trainer, model); !made) return tl::unexpected(made.error());
    model.hard_leaves = trainer.hard_leaves();
    return model;
  }

  /// Every coordinate is a sum of four uniform numbers: nearly normal, and never farther than 3.5 deviations.
  Result<void> learn_from_made(Trainer& trainer, Model& model) {
    if (!model.learned) return {};
    const Pca& subspace = model.learned->pca;
    std::mt19937_64 random(1);
    for (Index k = 0; k < settings_.made; ++k) {
      if (auto ok = go_on(); !ok) return ok;
      Eigen::VectorXd p = subspace.deviations;
      for (double& coordinate : p) {
        double sum = -2;
        for (int i = 0; i < 4; ++i) sum += static_cast<double>(random() >> 11) * 0x1p-53;
        coordinate *= std::sqrt(3.0) * sum;
      }
      const Eigen::VectorXd x = subspace.rebuild(p);
      const std::span positions(x.data(), static_cast<std::size_t>(x.size()));
      trainer.learn(static_cast<Index>(model.poses.size()), positions);
      model.poses.push_back({fmt::format("made from the subspace, {} of {}", k + 1, settings_.made), true,
                             trainer.prove(positions)});
      finish(kDrawingWork);
    }
    return {};
  }

  Result<void> add_learned(Model& model) {
    if (!collection_) {
      model.not_learned = settings_.learn ? "too few poses" : "not wanted";
      return {};
    }
    LearnHooks hooks;
    hooks.cancel = hooks_.cancel;
    const std::size_t before = done_, work = collection_->count() * kLearningWork;
    hooks.progress = [&](double part) {
      finish(before + static_cast<std::size_t>(std::lround(part * static_cast<double>(work))) - done_);
    };
    auto learned = foldproof::learn(*model.hierarchy(), collection_->input(), settings_.learning, hooks);
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
  std::size_t wanted_ = 0, expected_ = 0, done_ = 0;
  std::unique_ptr<Collection> collection_;
  std::vector<double> positions_;
};

}  // namespace

Result<Model> train_model(std::span<const TrainPose> poses, const TrainSettings& settings,
                          const TrainHooks& hooks) {
  if (auto ok = require_one_mesh(poses); !ok) return tl::unexpected(ok.error());
  if (auto ok = require_shares(settings.learning); !ok) return tl::unexpected(ok.error());
  return Run(poses, settings, hooks).run();
}

}  // namespace foldproof
