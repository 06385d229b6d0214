#include "measure.h"

#include <algorithm>
#include <ctime>
#include <optional>

#include "memory.h"
#include "verify.h"

namespace foldproof::bench {
namespace {

double now_milliseconds(bool processor_time) {
  timespec now{};
  clock_gettime(processor_time ? CLOCK_PROCESS_CPUTIME_ID : CLOCK_MONOTONIC, &now);
  return static_cast<double>(now.tv_sec) * 1e3 + static_cast<double>(now.tv_nsec) / 1e6;
}

/// Stage times, which foldproof measures by the wall, in proportion to what the bench's clock says of the
/// whole.
StageTimes scaled(const StageTimes& stages, double total) {
  const double factor = stages.total > 0 ? total / stages.total : 1;
  return {total, stages.update * factor, stages.traverse * factor, stages.narrow * factor};
}

/// Everyone who takes part in one scene at one step size, fresh, so that nobody profits from an earlier run.
class Race {
 public:
  Race(Motion& motion, const Plan& plan, SceneRecord& record)
      : plan_(plan), topology_(motion.topology()), loader_(motion), record_(record) {
    for (const PeerEntry& entry : plan.peers) {
      peers_.push_back(entry.make());
      peers_.back()->prepare(topology_);
    }
  }

  Result<void> build(Motion& motion) {
    std::vector<double> first(std::size_t{topology_.vertex_count()} * 3);
    if (auto read = motion.read_frame(0, first); !read) return read;
    Result<void> built;
    record_.build_milliseconds =
        milliseconds_of([&] { built = foldproof_.build(topology_, first, plan_.hierarchy); });
    return built;
  }

  Result<void> run(const std::vector<StepChoice>& steps) {
    for (std::size_t k = 0; k < steps.size(); ++k) {
      if (auto loaded = loader_.load(steps[k]); !loaded) return loaded;
      StepRecord step;
      if (auto done = run_step(step, k == 0); !done) return done;
      step.step = steps[k];
      if (k > 0) keep(k - 1, std::move(step));
    }
    return {};
  }

 private:
  template <class Call>
  double milliseconds_of(Call call) const {
    const double start = now_milliseconds(plan_.processor_time);
    call();
    return now_milliseconds(plan_.processor_time) - start;
  }

  Result<void> run_step(StepRecord& step, bool warm_up) {
    Result<void> done;
    step.milliseconds = milliseconds_of([&] { done = foldproof_.step(loader_.x0(), loader_.x1()); });
    if (!done) return done;
    const StepResult& result = foldproof_.result();
    step.work = result.work;
    step.stages = scaled(result.milliseconds, step.milliseconds);
    step.collisions_vf = result.vertex_face.size();
    step.collisions_ee = result.edge_edge.size();
    std::optional<Verifier> verifier;
    if (plan_.verify && !warm_up) verifier.emplace(topology_, loader_.x0(), loader_.x1());
    for (std::size_t p = 0; p < peers_.size(); ++p) {
      const Candidates* candidates = nullptr;
      StepRecord::OfPeer of_peer;
      of_peer.milliseconds =
          milliseconds_of([&] { candidates = &peers_[p]->step(loader_.x0(), loader_.x1()); });
      of_peer.candidates_vf = candidates->vertex_face.size();
      of_peer.candidates_ee = candidates->edge_edge.size();
      step.peers.push_back(of_peer);
      if (!verifier) continue;
      if (auto same = verifier->add_peer(plan_.peers[p].name, *candidates); !same) return same;
    }
    return verifier ? verifier->check_answer(result) : done;
  }

  /// A later round only replaces times that it improves on.
  void keep(std::size_t place, StepRecord step) {
    if (place == record_.steps.size()) {
      record_.steps.push_back(std::move(step));
      return;
    }
    StepRecord& best = record_.steps[place];
    if (step.milliseconds < best.milliseconds) {
      best.milliseconds = step.milliseconds;
      best.stages = step.stages;
    }
    for (std::size_t p = 0; p < best.peers.size(); ++p)
      best.peers[p].milliseconds = std::min(best.peers[p].milliseconds, step.peers[p].milliseconds);
  }

  const Plan& plan_;
  const Topology& topology_;
  StepLoader loader_;
  SceneRecord& record_;
  FoldproofRunner foldproof_;
  std::vector<std::unique_ptr<Peer>> peers_;
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

}  // namespace

Result<void> FoldproofRunner::build(const Topology& topology, std::span<const double> positions,
                                    const HierarchySettings& settings) {
  auto hierarchy = Hierarchy::build(topology, positions, settings);
  if (!hierarchy) return tl::unexpected(hierarchy.error());
  checker_.emplace(std::vector{std::make_shared<const Hierarchy>(std::move(*hierarchy))});
  return {};
}

Result<void> FoldproofRunner::step(std::span<const double> x0, std::span<const double> x1) {
  return checker_->check({&x0, 1}, {&x1, 1}, {}, result_);
}

Result<std::vector<SceneRecord>> measure(const SceneInfo& scene, const Plan& plan) {
  auto motion = open_scene(scene);
  if (!motion) return tl::unexpected(motion.error());
  const Topology& topology = (*motion)->topology();
  if ((*motion)->frame_count() < 2) return fail(scene.name, "has a single frame", "a step needs two");
  std::vector<SceneRecord> records;
  for (const StepSize size : plan.sizes) {
    SceneRecord record;
    record.name = scene.name;
    record.kind = scene.kind;
    record.size = size;
    record.vertices = topology.vertex_count();
    record.edges = static_cast<Index>(topology.edges().size());
    record.triangles = static_cast<Index>(topology.triangles().size());
    record.frames = (*motion)->frame_count();
    {
      Race race(**motion, plan, record);
      if (auto built = race.build(**motion); !built) return tl::unexpected(built.error());
      const auto steps = choose_steps(record.frames, size, plan.sampling);
      for (int round = 0; round < plan.rounds; ++round)
        if (auto done = race.run(steps); !done) return tl::unexpected(done.error());
    }
    if (plan.memory)
      if (auto done = measure_memory(scene, plan, record); !done) return tl::unexpected(done.error());
    records.push_back(std::move(record));
  }
  return records;
}

}  // namespace foldproof::bench
