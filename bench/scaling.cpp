#include "scaling.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <thread>

#include "base/parallel.h"
#include "foldproof/model.h"
#include "summary.h"

namespace foldproof::bench {
namespace {

std::string shape_of(const SceneRecord& record) { return record.name.substr(0, record.name.find('-')); }

double nanoseconds_a_triangle(const SceneRecord& record) {
  return foldproof_of(record, Way::Certificates) * 1e6 / record.triangles;
}

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

Result<TrainingRecord> train_on(const SceneInfo& scene) {
  auto motion = open_scene(scene);
  if (!motion) return tl::unexpected(motion.error());
  std::vector<TrainPose> poses;
  for (Index frame = 0; frame < (*motion)->frame_count(); ++frame) poses.push_back({motion->get(), frame});
  const double wall = now_milliseconds(false), processor = now_milliseconds(true);
  const auto model = train_model(poses, {});
  if (!model) return tl::unexpected(model.error());
  TrainingRecord record;
  record.wall_seconds = (now_milliseconds(false) - wall) / 1e3;
  record.processor_seconds = (now_milliseconds(true) - processor) / 1e3;
  record.name = scene.name;
  record.triangles = static_cast<Index>((*motion)->topology().triangles().size());
  record.poses = (*motion)->frame_count();
  const ModelSummary summary = summarize(*model);
  record.references = summary.references;
  record.proven = summary.proven;
  return record;
}

/// A checker that has so many threads.
class Team {
 public:
  Team(const std::shared_ptr<const Hierarchy>& hierarchy, int threads)
      : threads_(threads), checker_({hierarchy}) {}
  Result<double> milliseconds(const StepLoader& loader) {
    const ThreadLimit limit(threads_);
    const double processor = now_milliseconds(true);
    const double start = now_milliseconds(false);
    const Result<void> done = checker_.check(loader.x0(), loader.x1(), {}, result_);
    const double end = now_milliseconds(false);
    if (!done) return tl::unexpected(done.error());
    wall_ += end - start;
    processor_ += now_milliseconds(true) - processor;
    return end - start;
  }
  double processors() const { return processor_ / wall_; }

 private:
  int threads_;
  StepChecker checker_;
  StepResult result_;
  double wall_ = 0, processor_ = 0;
};

Result<ThreadRecord> measure_threads(const SceneInfo& scene, const Plan& plan) {
  auto motion = open_scene(scene);
  if (!motion) return tl::unexpected(motion.error());
  auto hierarchy = build_hierarchy(**motion, plan.hierarchy);
  if (!hierarchy) return tl::unexpected(hierarchy.error());
  Team teams[] = {{*hierarchy, 1}, {*hierarchy, 2}};
  std::vector<double> times[2];
  StepLoader loader(**motion);
  const auto steps = choose_steps((*motion)->frame_count(), StepSize::Tenth, plan.sampling);
  for (std::size_t k = 0; k < steps.size(); ++k) {
    if (auto loaded = loader.load(steps[k]); !loaded) return tl::unexpected(loaded.error());
    // Whoever goes second finds the positions in the cache: turn about.
    for (const std::size_t t : {k % 2, 1 - k % 2}) {
      const auto ms = teams[t].milliseconds(loader);
      if (!ms) return tl::unexpected(ms.error());
      if (steps[k].measured) times[t].push_back(*ms);
    }
  }
  ThreadRecord record;
  record.name = scene.name;
  record.triangles = static_cast<Index>((*motion)->topology().triangles().size());
  record.steps = static_cast<Index>(times[0].size());
  record.one = mean(times[0]);
  record.two = mean(times[1]);
  record.processors = teams[1].processors();
  return record;
}

}  // namespace

Result<std::vector<SceneRecord>> measure_growth(Plan plan) {
  plan.sizes = {StepSize::Tenth};
  plan.peers.clear();
  plan.trained = plan.plain = false;
  std::vector<SceneRecord> records;
  for (const SceneInfo& scene : growth_scenes()) {
    if (!is_available(scene) || scene.triangles > plan.growth_largest) continue;
    auto measured = measure(scene, plan);
    if (!measured) return tl::unexpected(measured.error());
    std::move(measured->begin(), measured->end(), std::back_inserter(records));
  }
  return records;
}

Table growth_table(const std::vector<SceneRecord>& records) {
  Table table{{"nanoseconds a triangle, tenth steps", "triangles", "colliding", "floor", "foldproof",
               "x floor", "first step", "build", "KB/triangle"},
              {}};
  for (const SceneRecord& record : records) {
    const auto per_triangle = [&](double ms) {
      const double ns = ms * 1e6 / record.triangles;
      return fmt::format("{:.{}f}", ns, ns < 100 ? 1 : 0);
    };
    const double ours = foldproof_of(record, Way::Certificates), floor = floor_of(record);
    const double kilobytes = kilobytes_per_triangle(record, "foldproof");
    table.rows.push_back({shape_of(record), fmt::format("{}", record.triangles),
                          fmt::format("{} of {}", colliding_steps(record), record.steps.size()),
                          per_triangle(floor), per_triangle(ours), fmt::format("{:.1f}", ours / floor),
                          per_triangle(record.first().of(Way::Certificates).milliseconds),
                          per_triangle(record.build_milliseconds),
                          std::isnan(kilobytes) ? "-" : fmt::format("{:.2f}", kilobytes)});
  }
  return table;
}

double growth_of(const std::vector<SceneRecord>& records, const std::string& shape) {
  const SceneRecord *below = nullptr, *above = nullptr, *largest = nullptr;
  for (const SceneRecord& record : records) {
    if (shape_of(record) != shape) continue;
    largest = &record;
    if (record.triangles <= 20'000) below = &record;
    if (record.triangles >= 20'000 && above == nullptr) above = &record;
  }
  // The hand is no coarser than 70,000: its smallest has to do.
  if (below == nullptr) below = above;
  if (below == nullptr || above == nullptr || largest->triangles < 1'000'000) return NAN;
  const double span = std::log(static_cast<double>(above->triangles) / below->triangles);
  const double share = span > 0 ? std::log(20'000.0 / below->triangles) / span : 0;
  const double at_small =
      nanoseconds_a_triangle(*below) * (1 - share) + nanoseconds_a_triangle(*above) * share;
  return nanoseconds_a_triangle(*largest) / at_small;
}

Result<std::vector<ThreadRecord>> measure_threads(const Plan& plan) {
  if (std::thread::hardware_concurrency() < 2)
    return fail("--thread-scaling", "this machine has one processor", "run it on one with two");
  std::vector<ThreadRecord> records;
  for (const SceneInfo& scene : growth_scenes()) {
    const Index n = scene.triangles;
    const bool wanted = n > 199'000 && (n < 300'000 || n > 1'500'000) && n <= plan.growth_largest;
    if (!wanted || !is_available(scene)) continue;
    auto record = measure_threads(scene, plan);
    if (!record) return tl::unexpected(record.error());
    records.push_back(std::move(*record));
  }
  return records;
}

Table thread_table(const std::vector<ThreadRecord>& records) {
  Table table{{"milliseconds a tenth step", "triangles", "steps", "one thread", "two threads", "speed-up",
               "processors"},
              {}};
  for (const ThreadRecord& r : records)
    table.rows.push_back({r.name.substr(0, r.name.find('-')), fmt::format("{}", r.triangles),
                          fmt::format("{}", r.steps), fmt::format("{:.2f}", r.one),
                          fmt::format("{:.2f}", r.two), fmt::format("{:.2f}", r.one / r.two),
                          fmt::format("{:.2f}", r.processors)});
  return table;
}

Result<std::vector<TrainingRecord>> measure_training() {
  std::vector<TrainingRecord> records;
  for (const PoseSet& set : pose_sets()) {
    const SceneInfo scene{set.name, SceneKind::Motion, set.files};
    if (!is_available(scene)) continue;
    auto record = train_on(scene);
    if (!record) return tl::unexpected(record.error());
    records.push_back(std::move(*record));
  }
  return records;
}

Table training_table(const std::vector<TrainingRecord>& records) {
  Table table{{"training", "triangles", "poses", "references", "wall s", "processor s", "proven %"}, {}};
  for (const TrainingRecord& r : records)
    table.rows.push_back({r.name, fmt::format("{}", r.triangles), fmt::format("{}", r.poses),
                          fmt::format("{}", r.references), fmt::format("{:.2f}", r.wall_seconds),
                          fmt::format("{:.2f}", r.processor_seconds), fmt::format("{:.1f}", 100 * r.proven)});
  return table;
}

}  // namespace foldproof::bench
