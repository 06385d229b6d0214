#include "measure.h"

#include <algorithm>
#include <ctime>
#include <optional>

#include "allocations.h"
#include "base/try.h"
#include "floor.h"
#include "foldproof/model.h"
#include "memory.h"
#include "verify.h"

namespace foldproof::bench {
namespace {

/// Stage times, which foldproof measures by the wall, in proportion to what the bench's clock says of the
/// whole.
StageTimes scaled(const StageTimes& stages, double total) {
  const double factor = stages.total > 0 ? total / stages.total : 1;
  return {total, stages.update * factor, stages.traverse * factor, stages.narrow * factor};
}

Index measured_of(const std::vector<StepChoice>& steps) {
  return static_cast<Index>(
      std::count_if(steps.begin(), steps.end(), [](const StepChoice& step) { return step.measured; }));
}

/// Embree, where it takes part: it is the one that the goals are stated against.
std::string main_family(const std::vector<PeerEntry>& peers) {
  const auto is_embree = [](const PeerEntry& peer) { return peer.family == "Embree"; };
  return std::any_of(peers.begin(), peers.end(), is_embree) ? "Embree" : peers.front().family;
}

/// What is made once per motion.
struct Prepared {
  std::shared_ptr<const Hierarchy> hierarchy;
  std::shared_ptr<const ChartLibrary> charts;  ///< Of the trained model, if any.
};

/// Everyone who takes part in one scene at one step size, fresh, so that nobody profits from an earlier run.
class Race {
 public:
  Race(Motion& motion, const Plan& plan, const Prepared& prepared, SceneRecord& record)
      : plan_(plan),
        topology_(motion.topology()),
        loader_(motion),
        record_(record),
        floor_(*prepared.hierarchy) {
    runners_[0].checker.emplace(std::vector<Object>{prepared.hierarchy});
    if (prepared.charts) runners_[1].checker.emplace(std::vector<Object>{prepared.charts});
    if (plan.plain) runners_[2].checker.emplace(std::vector<Object>{prepared.hierarchy});
    for (const PeerEntry& entry : plan.peers) {
      peers_.push_back(entry.make());
      peers_.back()->prepare(topology_);
    }
    // Smooth rows show what foldproof makes of a motion that bends; one family is enough to compare with.
    for (const PeerEntry& entry : plan.peers)
      active_.push_back(plan.verify || !is_smooth(record.size) || entry.family == main_family(plan.peers));
  }

  Result<void> run(const std::vector<StepChoice>& steps) {
    const Index count = measured_of(steps), before = static_cast<Index>(steps.size()) - count;
    const Index others = std::min(plan_.peer_steps, count);
    // Steps on which all run; the last before those measured is one of them, for them to warm up.
    std::vector<bool> all(steps.size());
    all[before - 1] = true;
    for (Index k = 0; k < others; ++k) all[before + (2 * k + 1) * count / (2 * others)] = true;
    for (Index k = 0; k < before + count; ++k) {
      StepRecord step;
      step.step = steps[k];
      if (auto done = run_step(step, all[k]); !done) return done;
      if (k + 1 == before && !plan_.verify && (plan_.one_variant || is_smooth(record_.size)))
        keep_fastest_variants(step);
      if (k < before)
        keep(record_.warm_up, k, std::move(step));
      else
        keep(record_.steps, k - before, std::move(step));
    }
    return {};
  }

 private:
  struct Runner {
    std::optional<StepChecker> checker;
    StepResult result;
  };

  template <class Call>
  double milliseconds_of(Call call) const {
    const double start = now_milliseconds(plan_.processor_time);
    call();
    return now_milliseconds(plan_.processor_time) - start;
  }

  Result<void> run_step(StepRecord& step, bool all) {
    if (auto loaded = loader_.load(step.step); !loaded) return loaded;
    step.floor_milliseconds = milliseconds_of([&] { floor_.fit(loader_.x1()); });
    for (const Way way : kWays) {
      // What learns sees every step; who does not may miss some, and leaves the caches alone.
      if (way == Way::Plain && !all) continue;
      if (auto done = run_way(way, step); !done) return done;
      const Runner& runner = runners_[static_cast<std::size_t>(way)];
      if (way != Way::Certificates && runner.checker && !same_answer(runners_[0].result, runner.result))
        return fail(record_.name,
                    way == Way::Trained ? "has another answer with a model"
                                        : "has another answer without certificates",
                    "report this, please");
    }
    const StepResult& result = runners_[0].result;
    step.collisions_vf = result.vertex_face_count;
    step.collisions_ee = result.edge_edge_count;
    if (!all) return {};
    std::optional<Verifier> verifier;
    if (plan_.verify && step.step.measured) verifier.emplace(topology_, loader_.x0(), loader_.x1());
    if (auto done = run_peers(step, verifier); !done) return done;
    return verifier ? verifier->check_answer(result) : Result<void>{};
  }

  Result<void> run_way(Way way, StepRecord& step) {
    const auto place = static_cast<std::size_t>(way);
    Runner& runner = runners_[place];
    if (!runner.checker) return {};
    StepRecord::OfFoldproof& of = step.ways[place];
    StepSettings settings;
    settings.certificates = way != Way::Plain;
    Result<void> done;
    const auto before = allocation_count();
    of.milliseconds = milliseconds_of(
        [&] { done = runner.checker->check(loader_.x0(), loader_.x1(), settings, runner.result); });
    of.allocations = allocation_count() - before;
    of.work = runner.result.work;
    of.searched = runner.result.search_steps;
    of.stages = scaled(runner.result.milliseconds, of.milliseconds);
    return done;
  }

  Result<void> run_peers(StepRecord& step, std::optional<Verifier>& verifier) {
    for (std::size_t p = 0; p < peers_.size(); ++p) {
      StepRecord::OfPeer& of = step.peers.emplace_back();
      if (!active_[p]) continue;
      if (!step.step.measured) peers_[p]->step(loader_.x0(), loader_.x1());  // makes trees and allocates
      const Candidates* candidates = nullptr;
      of.milliseconds = milliseconds_of([&] { candidates = &peers_[p]->step(loader_.x0(), loader_.x1()); });
      of.candidates_vf = candidates->vertex_face.size();
      of.candidates_ee = candidates->edge_edge.size();
      if (!verifier) continue;
      if (auto same = verifier->add_peer(plan_.peers[p].name, *candidates); !same) return same;
    }
    return {};
  }

  void keep_fastest_variants(const StepRecord& step) {
    for (std::size_t p = 0; p < peers_.size(); ++p)
      for (std::size_t q = 0; q < peers_.size(); ++q)
        if (plan_.peers[p].family == plan_.peers[q].family &&
            step.peers[q].milliseconds < step.peers[p].milliseconds)
          active_[p] = false;
  }

  /// A later round only replaces times that it improves on.
  static void keep(std::vector<StepRecord>& steps, std::size_t place, StepRecord step) {
    if (place == steps.size()) {
      steps.push_back(std::move(step));
      return;
    }
    StepRecord& best = steps[place];
    best.floor_milliseconds = std::min(best.floor_milliseconds, step.floor_milliseconds);
    for (std::size_t w = 0; w < kWays.size(); ++w)
      if (step.ways[w].milliseconds < best.ways[w].milliseconds) best.ways[w] = step.ways[w];
    for (std::size_t p = 0; p < best.peers.size(); ++p)
      if (std::isnan(best.peers[p].milliseconds) || step.peers[p].milliseconds < best.peers[p].milliseconds)
        best.peers[p] = step.peers[p];
  }

  const Plan& plan_;
  const Topology& topology_;
  StepLoader loader_;
  SceneRecord& record_;
  Floor floor_;
  std::array<Runner, kWays.size()> runners_;  // by Way
  std::vector<std::unique_ptr<Peer>> peers_;
  std::vector<bool> active_;
};

Result<void> measure_memory(const SceneInfo& scene, const Plan& plan, SceneRecord& record) {
  std::vector<std::string> names = {"foldproof"};
  if (plan.peer_memory)
    for (const PeerEntry& peer : plan.peers) names.push_back(peer.name);
  for (const std::string& name : names) {
    const auto bytes =
        peak_bytes_in_child({scene.name, name, record.size, plan.sampling, plan.hierarchy, plan.threads});
    if (!bytes) return tl::unexpected(bytes.error());
    record.peak_bytes[name] = *bytes;
  }
  return {};
}

/// Trains on every tenth frame, where there are enough of them to speak of.
Result<void> train(Motion& motion, const Plan& plan, Prepared& prepared, SceneRecord& record) {
  std::vector<TrainPose> poses;
  for (Index frame = 0; frame < motion.frame_count(); frame += 10) poses.push_back({&motion, frame});
  if (poses.size() < 2) return {};
  TrainSettings settings;
  settings.learn = false;
  const double start = now_milliseconds(plan.processor_time);
  auto model = FOLDPROOF_TRY(train_model(poses, settings));
  record.train_seconds = (now_milliseconds(plan.processor_time) - start) / 1e3;
  record.references = summarize(model).references;
  prepared.charts = model.charts;
  return {};
}

Result<void> prepare(const SceneInfo& scene, Motion& motion, const Plan& plan, Prepared& prepared,
                     SceneRecord& record) {
  const Topology& topology = motion.topology();
  if (motion.frame_count() < 2) return fail(scene.name, "has a single frame", "a step needs two");
  record.name = scene.name;
  record.kind = scene.kind;
  record.vertices = topology.vertex_count();
  record.edges = static_cast<Index>(topology.edges().size());
  record.triangles = static_cast<Index>(topology.triangles().size());
  record.frames = motion.frame_count();
  const double start = now_milliseconds(plan.processor_time);
  auto hierarchy = FOLDPROOF_TRY(build_hierarchy(motion, plan.hierarchy));
  record.build_milliseconds = now_milliseconds(plan.processor_time) - start;
  prepared.hierarchy = std::move(hierarchy);
  return plan.trained ? train(motion, plan, prepared, record) : Result<void>{};
}

}  // namespace

double now_milliseconds(bool processor_time) {
  timespec now{};
  clock_gettime(processor_time ? CLOCK_PROCESS_CPUTIME_ID : CLOCK_MONOTONIC, &now);
  return static_cast<double>(now.tv_sec) * 1e3 + static_cast<double>(now.tv_nsec) / 1e6;
}

Result<std::shared_ptr<const Hierarchy>> build_hierarchy(Motion& motion, const HierarchySettings& settings) {
  std::vector<double> x(std::size_t{motion.topology().vertex_count()} * 3);
  FOLDPROOF_TRY(motion.read_frame(0, x));
  auto hierarchy = FOLDPROOF_TRY(Hierarchy::build(motion.topology(), x, settings));
  return std::make_shared<const Hierarchy>(std::move(hierarchy));
}

Result<std::vector<SceneRecord>> measure(const SceneInfo& scene, const Plan& plan) {
  auto motion = FOLDPROOF_TRY(open_scene(scene));
  Prepared prepared;
  SceneRecord common;
  FOLDPROOF_TRY(prepare(scene, *motion, plan, prepared, common));
  std::vector<SceneRecord> records;
  for (const StepSize size : plan.sizes) {
    if (is_smooth(size) && scene.kind != SceneKind::Motion) continue;
    SceneRecord record = common;
    record.size = size;
    const auto steps = choose_steps(record.frames, size, plan.sampling);
    // A single step tells little: its fastest of some runs with new checkers counts.
    const int rounds = measured_of(steps) == 1 ? std::max(plan.rounds, 3) : plan.rounds;
    for (int round = 0; round < rounds; ++round) {
      Race race(*motion, plan, prepared, record);
      FOLDPROOF_TRY(race.run(steps));
    }
    if (plan.memory) FOLDPROOF_TRY(measure_memory(scene, plan, record));
    records.push_back(std::move(record));
  }
  return records;
}

}  // namespace foldproof::bench
