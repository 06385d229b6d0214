#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "certificate/library.h"
#include "learned/certificates.h"
#include "model/format.h"

namespace foldproof {

const std::shared_ptr<const Hierarchy>& Model::hierarchy() const { return charts->slots()->hierarchy(); }
std::size_t Model::chart_count() const { return charts->charts().size(); }

std::uint64_t topology_hash(const Topology& topology) {
  std::uint64_t hash = 0xcbf29ce484222325u;
  const auto mix = [&](Index number) {
    for (int byte = 0; byte < 4; ++byte) {
      hash = (hash ^ (number >> (8 * byte) & 0xff)) * 0x100000001b3u;
    }
  };
  mix(topology.vertex_count());
  for (const Triangle& t : topology.triangles()) {
    for (const Index v : t) mix(v);
  }
  if (topology.line_count() > 0 || topology.point_count() > 0) {
    mix(topology.line_count());
    mix(topology.point_count());
  }
  return hash;
}

namespace {

/// Whether `merged` turns the one's triangles into the other's.
bool becomes(const Topology& one, const Topology& other, std::span<const Index> merged) {
  if (one.vertex_count() != merged.size()) return false;
  const auto from = one.triangles(), to = other.triangles();
  return std::equal(from.begin(), from.end(), to.begin(), to.end(),
                    [&](const Triangle& s, const Triangle& t) {
                      return merged[s[0]] == t[0] && merged[s[1]] == t[1] && merged[s[2]] == t[2];
                    });
}

}  // namespace

Result<void> require_learned(const Model& model) {
  if (model.learned) return {};
  return fail(ErrorCode::NotLearned, model.name.empty() ? "model" : model.name, "has learned no shapes",
              "train it again with at least 3 poses that differ");
}

Result<void> require_model_of(const Model& model, const Topology& topology, const std::string& mesh,
                              std::span<const Index> merged) {
  const Topology& own = model.hierarchy()->topology();
  if (own == topology) return {};
  const std::string name = model.name.empty() ? "model" : model.name;
  if (becomes(own, topology, merged)) {
    return fail(
        ErrorCode::InvalidMesh, name,
        fmt::format("was trained on triangles whose seams were not merged, and those of {} are", mesh),
        "check with --no-weld, or train it again");
  }
  const auto size = [](const Topology& t) {
    const std::string others = t.face_count() == t.triangles().size()
                                   ? ""
                                   : fmt::format(", {} lines and {} points", t.line_count(), t.point_count());
    return fmt::format("{} triangles{} over {} vertices", t.face_count(), others, t.vertex_count());
  };
  std::string problem =
      fmt::format("is a model of another mesh: {}, but {} has {}", size(own), mesh, size(topology));
  if (own.vertex_count() == topology.vertex_count() &&
      own.triangles().size() == topology.triangles().size()) {
    const auto [mine, theirs] =
        std::mismatch(own.triangles().begin(), own.triangles().end(), topology.triangles().begin());
    if (mine != own.triangles().end()) {
      problem = fmt::format("is a model of another mesh: triangle {} of {} has other vertices",
                            mine - own.triangles().begin(), mesh);
    }
  }
  return fail(ErrorCode::InvalidMesh, name, problem, "train a model on this one");
}

namespace {

// A chart's steepness in the pose it was built in; see ModelSummary::Level.
double chart_kappa(const ChartLibrary& library, const ChartLibrary::Chart& chart) {
  const auto points = library.points(chart);
  const auto triangles = library.triangles(chart);
  double steepest = 0;  // squared tangent
  for (const auto& t : triangles.first(patch_triangles(*library.slots(), chart.slot, library.ring(chart)))) {
    const auto side = [&](int to) {
      const auto &a = points[t[0]], &b = points[t[to]];
      return Vec3(b[0] - a[0], b[1] - a[1], b[2] - a[2]);
    };
    const Vec3 normal = side(1).cross(side(2));  // exact: products of numbers below 2^17
    const double across = normal.x() * normal.x() + normal.y() * normal.y(), up = normal.z() * normal.z();
    steepest = std::max(steepest, across / up);
  }
  return std::sqrt(1 + steepest) * (1 + 0x1p-48);
}

/// Kappas of one level's charts.
struct Kappas {
  std::vector<double> all;
  void fill(ModelSummary::Level& level) {
    level.charts = static_cast<Index>(all.size());
    if (all.empty()) return;
    const auto middle = all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2);
    std::nth_element(all.begin(), middle, all.end());
    level.kappa_median = *middle;
    level.kappa_max = *std::max_element(middle, all.end());
  }
};

}  // namespace

ModelSummary summarize(const Model& model) {
  const ChartLibrary& library = *model.charts;

  const std::vector<Index> depth = depths_of(*model.hierarchy());
  ModelSummary summary;
  summary.levels.resize(*std::max_element(depth.begin(), depth.end()) + 1);
  const auto level_of = [&](Index slot) -> ModelSummary::Level& {
    return library.slots()->is_pair(slot) ? summary.pairs : summary.levels[depth[slot]];
  };
  for (Index slot = 0; slot < library.slots()->count(); ++slot) {
    ++level_of(slot).slots;
    level_of(slot).charted += library.first(slot) != kNoIndex;
  }
  summary.pairs.slots /= 2;  // each pair has two slots, and uses one of them
  std::vector<Kappas> kappas(summary.levels.size() + 1);
  for (const ChartLibrary::Chart& chart : library.charts()) {
    const std::size_t level =
        library.slots()->is_pair(chart.slot) ? summary.levels.size() : depth[chart.slot];
    kappas[level].all.push_back(chart_kappa(library, chart));
  }
  for (std::size_t k = 0; k < summary.levels.size(); ++k) kappas[k].fill(summary.levels[k]);
  kappas.back().fill(summary.pairs);
  for (const TrainedPose& pose : model.poses) {
    summary.references += pose.reference;
    summary.proven += pose.proven / static_cast<double>(model.poses.size());
  }
  return summary;
}

}  // namespace foldproof
