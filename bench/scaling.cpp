#include "scaling.h"

#include <algorithm>
#include <deque>
#include <thread>

#include <nlohmann/json.hpp>

#include "base/parallel.h"
#include "base/try.h"
#include "foldproof/model.h"
#include "report.h"
#include "verify.h"

namespace foldproof::bench {
namespace {

using nlohmann::json;

struct PoseSet {
  const char* name;
  std::vector<std::string> files;
};

const std::vector<PoseSet>& pose_sets() {
  static const std::vector<PoseSet> sets = {
      {"hand-train", {"hand/hand-train.obj", "hand/hand-train.pc2"}},
      {"elephant-poses", {"elephant/elephant-poses.obj", "elephant/elephant-poses.pc2"}},
      {"horse-poses", {"horse-poses/pose_*.obj"}},
      {"lion-poses", {"lion-poses/pose_*.obj"}}};
  return sets;
}

Result<json> train_on(const SceneInfo& scene) {
  auto motion = FOLDPROOF_TRY(open_scene(scene));
  std::vector<TrainPose> poses;
  for (Index frame = 0; frame < motion->frame_count(); ++frame) poses.push_back({motion.get(), frame});
  const double wall = now_milliseconds(false), processor = now_milliseconds(true);
  const auto model = FOLDPROOF_TRY(train_model(poses, {}));
  const double wall_seconds = (now_milliseconds(false) - wall) / 1e3;
  const double processor_seconds = (now_milliseconds(true) - processor) / 1e3;
  const ModelSummary summary = summarize(model);
  return json{{"name", scene.name},
              {"triangles", motion->topology().triangles().size()},
              {"poses", motion->frame_count()},
              {"references", summary.references},
              {"wall_seconds", wall_seconds},
              {"processor_seconds", processor_seconds},
              {"proven", summary.proven}};
}

/// A checker that has so many threads.
class Team {
 public:
  Team(const std::shared_ptr<const Hierarchy>& hierarchy, int threads)
      : threads_(threads), checker_({hierarchy}) {}
  Result<void> take(const StepLoader& loader, bool measured) {
    const ThreadLimit limit(threads_);
    const double processor = now_milliseconds(true);
    const double start = now_milliseconds(false);
    Result<void> done = checker_.check(loader.x0(), loader.x1(), {}, result_);
    if (!measured) return done;
    ++steps_;
    wall_ += now_milliseconds(false) - start;
    processor_ += now_milliseconds(true) - processor;
    return done;
  }
  const StepResult& result() const { return result_; }
  json figures() const {
    return {{"threads", threads_}, {"milliseconds", wall_ / steps_}, {"processors", processor_ / wall_}};
  }

 private:
  int threads_;
  StepChecker checker_;
  StepResult result_;
  int steps_ = 0;
  double wall_ = 0, processor_ = 0;
};

Result<json> measure_threads(Motion& motion, StepSize size, const Plan& plan) {
  auto hierarchy = FOLDPROOF_TRY(build_hierarchy(motion, plan.hierarchy));
  const int processors = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  std::deque<Team> teams;
  for (int threads = 1; threads <= processors; threads *= 2) teams.emplace_back(hierarchy, threads);
  StepLoader loader(motion);
  const auto steps = choose_steps(motion.frame_count(), size, plan.sampling);
  for (std::size_t k = 0; k < steps.size(); ++k) {
    FOLDPROOF_TRY(loader.load(steps[k]));
    // Who goes later finds the positions in the cache: turn about.
    for (std::size_t t = 0; t < teams.size(); ++t)
      FOLDPROOF_TRY(teams[(k + t) % teams.size()].take(loader, steps[k].measured));
    for (const Team& team : teams)
      if (!same_answer(team.result(), teams.front().result()))
        return fail("--thread-scaling", "the answer depends on the number of threads", "report this, please");
  }
  json figures = json::array();
  for (const Team& team : teams) figures.push_back(team.figures());
  const auto measured =
      std::count_if(steps.begin(), steps.end(), [](const StepChoice& s) { return s.measured; });
  return json{{"step", size_name(size)},
              {"triangles", motion.topology().triangles().size()},
              {"steps", measured},
              {"teams", figures}};
}

}  // namespace

Result<json> measure_growth(Plan plan) {
  plan.sizes = {StepSize::Tenth};
  plan.peers.clear();
  plan.trained = plan.plain = false;
  std::vector<SceneInfo> scenes;
  std::copy_if(
      growth_scenes().begin(), growth_scenes().end(), std::back_inserter(scenes),
      [&](const SceneInfo& scene) { return is_available(scene) && scene.triangles <= plan.growth_largest; });
  return measure_scenes(scenes, plan);
}

Result<json> measure_threads(const Plan& plan) {
  if (std::thread::hardware_concurrency() < 2)
    return fail("--thread-scaling", "this machine has one processor", "run it on one with two");
  json rows = json::array();
  for (const SceneInfo& scene : growth_scenes()) {
    const Index n = scene.triangles;
    const bool wanted = n > 199'000 && (n < 300'000 || n > 1'500'000) && n <= plan.growth_largest;
    if (!wanted || !is_available(scene)) continue;
    auto motion = FOLDPROOF_TRY(open_scene(scene));
    for (const StepSize size : {StepSize::Full, StepSize::Tenth}) {
      auto row = FOLDPROOF_TRY(measure_threads(*motion, size, plan));
      row["name"] = scene.name;
      rows.push_back(std::move(row));
    }
  }
  return rows;
}

Result<json> measure_training() {
  json rows = json::array();
  for (const PoseSet& set : pose_sets()) {
    const SceneInfo scene{set.name, SceneKind::Motion, set.files};
    if (!is_available(scene)) continue;
    auto row = FOLDPROOF_TRY(train_on(scene));
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace foldproof::bench
