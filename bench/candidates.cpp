#include "candidates.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "foldproof/solver.h"
#include "measure.h"

namespace foldproof::bench {
namespace {

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
  double mean() const { return sum / poses; }
};

double mean_edge(std::span<const Edge> edges, std::span<const double> x) {
  double sum = 0;
  const auto at = [&](Index v) { return Eigen::Map<const Vec3>(&x[3 * std::size_t{v}]); };
  for (const Edge& e : edges) sum += (at(e[0]) - at(e[1])).norm();
  return sum / static_cast<double>(edges.size());
}

// Peers see the pose as a step that stands still, and are rebuilt for it.
class PeersHere {
 public:
  PeersHere(const CandidatePlan& plan, const Topology& topology, double inflation) : plan_(plan) {
    for (const PeerEntry& entry : plan.peers) {
      peers_.push_back(entry.make());
      peers_.back()->prepare(topology);
      peers_.back()->inflate(inflation);
    }
  }
  void take(std::span<const double> x, Row& row) {
    for (std::size_t k = 0; k < peers_.size(); ++k) {
      const double start = now_milliseconds(plan_.processor_time);
      const Candidates& found = peers_[k]->step(x, x);
      row.peers[plan_.peers[k].name] += (now_milliseconds(plan_.processor_time) - start) / plan_.peer_poses;
      if (k == 0)
        row.peer_pairs +=
            static_cast<double>(found.vertex_face.size() + found.edge_edge.size()) / plan_.peer_poses;
    }
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
  if (auto done = load(0); !done) return tl::unexpected(done.error());
  const auto triangles = topology.triangles();
  auto mesh = CollisionMesh::make(loader.x0(), {}, {triangles.begin(), triangles.end()});
  if (!mesh) return tl::unexpected(mesh.error());
  const double distance = inflation * mean_edge(mesh->edges(), loader.x0());
  ContactChecker checker(std::make_shared<const CollisionMesh>(std::move(*mesh)));
  PeersHere peers(plan, topology, distance);
  foldproof::Candidates found;
  Row row;
  for (Index k = 0; k < plan.warm_up + plan.poses; ++k) {
    if (auto done = load(k); !done) return tl::unexpected(done.error());
    const double start = now_milliseconds(plan.processor_time);
    if (auto done = checker.candidates(loader.x0(), distance, found); !done)
      return tl::unexpected(done.error());
    const double took = now_milliseconds(plan.processor_time) - start;
    if (k == 0) row.first = took;
    if (k < plan.warm_up) continue;
    ++row.poses;
    row.sum += took;
    row.slowest = std::max(row.slowest, took);
    if ((k - plan.warm_up) % (plan.poses / plan.peer_poses) != 0) continue;
    row.pairs += static_cast<double>(found.size()) / plan.peer_poses;
    peers.take(loader.x0(), row);
  }
  // Peers' boxes are in single precision, and round to nearest.
  if (!plan.peers.empty() && std::abs(row.pairs / row.peer_pairs - 1) > 1e-3)
    return fail(stride.name, fmt::format("has {} pairs, but {} with near boxes", row.pairs, row.peer_pairs),
                "report this, please");
  return row;
}

}  // namespace

Result<Table> measure_candidates(const std::vector<SceneInfo>& scenes, const CandidatePlan& plan) {
  Table table{{"candidates, ms a pose", "pose to pose", "inflation", "pairs", "foldproof", "slowest", "first",
               "fastest peer", "peer/foldproof", "its name"},
              {}};
  double logs = 0;
  int count = 0;
  for (const SceneInfo& scene : scenes) {
    if (scene.kind != SceneKind::Motion) continue;
    auto motion = open_scene(scene);
    if (!motion) return tl::unexpected(motion.error());
    for (const Stride& stride : kStrides) {
      for (const double inflation : kInflations) {
        const auto row = measure_row(**motion, stride, inflation, plan);
        if (!row) return tl::unexpected(row.error());
        const auto fastest =
            std::min_element(row->peers.begin(), row->peers.end(),
                             [](const auto& a, const auto& b) { return a.second < b.second; });
        const bool any = fastest != row->peers.end();
        if (any) {
          logs += std::log(fastest->second / row->mean());
          ++count;
        }
        table.rows.push_back(
            {scene.name, stride.name, fmt::format("{}", inflation), fmt::format("{:.0f}", row->pairs),
             fmt::format("{:.2f}", row->mean()), fmt::format("{:.2f}", row->slowest),
             fmt::format("{:.1f}", row->first), any ? fmt::format("{:.1f}", fastest->second) : "",
             any ? fmt::format("{:.1f}", fastest->second / row->mean()) : "", any ? fastest->first : ""});
      }
    }
  }
  if (count > 1) {
    std::vector<std::string> mean(table.headers.size());
    mean[0] = fmt::format("geometric mean of {}", count);
    mean[8] = fmt::format("{:.1f}", std::exp(logs / count));
    table.rows.push_back({});
    table.rows.push_back(std::move(mean));
  }
  return table;
}

}  // namespace foldproof::bench
