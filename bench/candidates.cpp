#include "candidates.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include <nlohmann/json.hpp>

#include "base/try.h"
#include "foldproof/solver.h"
#include "measure.h"

namespace foldproof::bench {
namespace {

using nlohmann::json;

// From one pose to the next.
struct Stride {
  const char* name;
  int parts;  // of a frame
};
constexpr Stride kStrides[] = {{"smooth fortieth", 40}, {"Newton iteration", 4000}};
constexpr double kInflations[] = {0.05, 0.3};  // mean edges

struct Row {
  double first = 0, sum = 0, slowest = 0, pairs = 0, peer_pairs = 0;
  Index poses = 0;
  std::map<std::string, double> peers;  // milliseconds, by name; least of each pose's mean
};

double mean_edge(std::span<const Edge> edges, std::span<const double> x) {
  double sum = 0;
  const auto at = [&](Index v) { return Vec3::load(&x[3 * std::size_t{v}]); };
  for (const Edge& e : edges) sum += (at(e[0]) - at(e[1])).norm();
  return sum / static_cast<double>(edges.size());
}

// Peers see the pose as a step that stands still, and make their trees for it.
class PeersHere {
 public:
  PeersHere(const CandidatePlan& plan, const Topology& topology, double inflation) : plan_(plan) {
    for (const PeerEntry& entry : plan.peers) {
      peers_.push_back(entry.make());
      peers_.back()->prepare(topology);
      peers_.back()->inflate(inflation);
    }
  }
  // They make their trees and allocate what they need.
  void warm_up(std::span<const double> x) {
    for (auto& peer : peers_) peer->step(x, x);
  }
  Result<void> take(std::span<const double> x, Row& row) {
    std::size_t pairs = 0;  // of the first
    for (std::size_t k = 0; k < peers_.size(); ++k) {
      const std::string& name = plan_.peers[k].name;
      const double start = now_milliseconds(plan_.processor_time);
      const Candidates& found = peers_[k]->step(x, x);
      row.peers[name] += (now_milliseconds(plan_.processor_time) - start) / plan_.peer_poses;
      const std::size_t here = found.vertex_face.size() + found.edge_edge.size();
      if (k == 0) pairs = here;
      if (here != pairs) return fail(name, fmt::format("has {} pairs, others {}", here, pairs), "mend it");
    }
    row.peer_pairs += static_cast<double>(pairs) / plan_.peer_poses;
    return {};
  }

 private:
  const CandidatePlan& plan_;
  std::vector<std::unique_ptr<Peer>> peers_;
};

Result<Row> measure_row(Motion& motion, const Stride& stride, double inflation, const CandidatePlan& plan) {
  const Topology& topology = motion.topology();
  StepLoader loader(motion);
  const Index middle = motion.frame_count() / 2;
  const auto load = [&](Index k) {
    const auto parts = static_cast<Index>(stride.parts);
    return loader.load({middle + k / parts, static_cast<int>(k % parts), stride.parts, true});
  };
  FOLDPROOF_TRY(load(0));
  const auto triangles = topology.triangles();
  auto mesh = FOLDPROOF_TRY(CollisionMesh::make(loader.x0(), {}, {triangles.begin(), triangles.end()}));
  const double distance = inflation * mean_edge(mesh.edges(), loader.x0());
  ContactChecker checker(std::make_shared<const CollisionMesh>(std::move(mesh)));
  PeersHere peers(plan, topology, distance);
  foldproof::Candidates found;
  Row row;
  for (Index k = 0; k < plan.warm_up + plan.poses; ++k) {
    FOLDPROOF_TRY(load(k));
    const double start = now_milliseconds(plan.processor_time);
    FOLDPROOF_TRY(checker.candidates(loader.x0(), distance, found));
    const double took = now_milliseconds(plan.processor_time) - start;
    if (k == 0) row.first = took;
    if (k + 1 == plan.warm_up) peers.warm_up(loader.x0());
    if (k < plan.warm_up) continue;
    ++row.poses;
    row.sum += took;
    row.slowest = std::max(row.slowest, took);
    if ((k - plan.warm_up) % (plan.poses / plan.peer_poses) != 0) continue;
    row.pairs += static_cast<double>(found.size()) / plan.peer_poses;
    FOLDPROOF_TRY(peers.take(loader.x0(), row));
  }
  // Peers' boxes are in single precision, and round to nearest.
  if (!plan.peers.empty() && std::abs(row.pairs / row.peer_pairs - 1) > 1e-3)
    return fail(stride.name, fmt::format("has {} pairs, but {} with near boxes", row.pairs, row.peer_pairs),
                "report this, please");
  return row;
}

}  // namespace

Result<json> measure_candidates(const std::vector<SceneInfo>& scenes, const CandidatePlan& plan) {
  json rows = json::array();
  for (const SceneInfo& scene : scenes) {
    if (scene.kind != SceneKind::Motion) continue;
    auto motion = FOLDPROOF_TRY(open_scene(scene));
    for (const Stride& stride : kStrides) {
      for (const double inflation : kInflations) {
        const auto row = FOLDPROOF_TRY(measure_row(*motion, stride, inflation, plan));
        rows.push_back({{"name", scene.name},
                        {"stride", stride.name},
                        {"inflation", inflation},
                        {"pairs", row.pairs},
                        {"milliseconds", row.sum / row.poses},
                        {"slowest_milliseconds", row.slowest},
                        {"first_milliseconds", row.first},
                        {"peers", row.peers}});
      }
    }
  }
  return rows;
}

}  // namespace foldproof::bench
