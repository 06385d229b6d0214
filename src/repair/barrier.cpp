#include "repair/barrier.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "base/try.h"
#include "solver/pair_distances.h"

namespace foldproof {
namespace {

constexpr double kKept = 0.9;    // a pair that is closer in a good pose keeps this share of its gap there,
constexpr double kLeast = 1e-3;  // but not less than this share of the range

// The features of one mesh that stand for those of all objects, in a filter of these.
class MergedFilter final : public PairFilter {
 public:
  MergedFilter(const RepairScene& scene, std::shared_ptr<const PairFilter> filter,
               std::vector<Index> triangles)
      : scene_(scene), filter_(std::move(filter)), triangles_(std::move(triangles)) {}

  bool nodes(Index, Index, Index, Index) const override { return true; }
  bool vertex_face(Index, Index vertex, Index, Index face) const override {
    const Index triangle = triangles_[face];
    if (triangle == kNoIndex) return false;  // a vertex of no triangle
    const Index a = scene_.object_of_vertex(vertex),
                b = scene_.object_of_vertex(scene_.triangles()[triangle][0]);
    return filter_->vertex_face(a, vertex - scene_.begin(a).vertices, b,
                                triangle - scene_.begin(b).triangles);
  }
  bool edge_edge(Index, const Edge& p, Index, const Edge& q) const override {
    const Index a = scene_.object_of_vertex(p[0]), b = scene_.object_of_vertex(q[0]);
    const Index va = scene_.begin(a).vertices, vb = scene_.begin(b).vertices;
    return filter_->edge_edge(a, {p[0] - va, p[1] - va}, b, {q[0] - vb, q[1] - vb});
  }
  bool crossing(Index, Index, Index, Index) const override { return true; }

 private:
  const RepairScene& scene_;
  std::shared_ptr<const PairFilter> filter_;
  std::vector<Index> triangles_;  // of the scene, by triangle of the merged mesh
};

// The scene's number of each triangle of a merged mesh; kNoIndex where it has none.
std::vector<Index> scene_triangles(const RepairScene& scene, std::span<const Triangle> merged) {
  const auto key = [](Triangle t) {
    std::ranges::sort(t);
    if (t[0] == t[1]) t[1] = t[2];
    return t;
  };
  std::map<Triangle, Index> numbers;
  for (Index t = 0; t < scene.triangles().size(); ++t) numbers.emplace(key(scene.triangles()[t]), t);
  std::vector<Index> out;
  for (const Triangle& t : merged) {
    const auto found = numbers.find(key(t));
    out.push_back(found != numbers.end() ? found->second : kNoIndex);
  }
  return out;
}

// Lines and points are other lists than faces there.
Result<CollisionMesh> merged_mesh(const RepairScene& scene, std::span<const double> rest) {
  std::vector<Triangle> faces;
  std::set<Edge> lines;
  CollisionMeshSettings settings;
  settings.points = false;
  for (const Triangle& t : scene.triangles()) {
    const auto [low, high] = std::minmax({t[0], t[1], t[2]});
    if (low == high) {
      settings.points = true;
    } else if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) {
      lines.insert({low, high});
    } else {
      faces.push_back(t);
    }
  }
  std::vector<Index> group;
  for (const std::uint8_t m : scene.movable()) group.push_back(m != 0 ? 0 : 1);
  if (std::ranges::find(group, 1u) != group.end()) {
    const std::array<Index, 2> fixed[] = {{1, 1}};
    settings.filter = FOLDPROOF_TRY(CollisionFilter::groups(std::move(group), fixed));
  }
  return CollisionMesh::make(rest, {lines.begin(), lines.end()}, std::move(faces), settings);
}

NearPair near_pair_of(const ClosePair& close, const BarrierRange& range) {
  return {close.vertices,
          close.weights,
          close.normal,
          close.distance - range.thickness,
          range.range,
          static_cast<double>(close.count),
          close.kind == ClosePair::Kind::EdgeEdge};
}

// Lowers ranges to what is kept of the gaps in the pose x.
void keep_gaps(const BarrierRange& range, std::span<const double> x, std::vector<NearPair*>& pairs) {
  PairBatch batch{};
  NearestBatch nearest;
  const double farthest = range.range / kKept + range.thickness;
  for (std::size_t first = 0; first < pairs.size(); first += 8) {
    const auto some = std::span(pairs).subspan(first, std::min<std::size_t>(8, pairs.size() - first));
    for (std::size_t lane = 0; lane < some.size(); ++lane) {
      const FourPoints p = points_of(x, some[lane]->vertices);
      batch.set(static_cast<int>(lane), p, p);
    }
    for (unsigned left =
             nearest_points(batch, static_cast<int>(some.size()), some[0]->edges, farthest, nearest);
         left != 0; left &= left - 1) {
      const int lane = __builtin_ctz(left);
      NearPair& pair = *some[static_cast<std::size_t>(lane)];
      const double gap = nearest.distance[lane] - range.thickness;
      pair.range = std::min(pair.range, std::max(kKept * gap, kLeast * range.range));
    }
  }
}

}  // namespace

double internal::barrier(double gap, double range) {
  const double y = gap / range;
  return y >= 1 ? 0 : -(y - 1) * (y - 1) * std::log(y);
}

double internal::barrier_slope(double gap, double range) {
  const double y = gap / range;
  return y >= 1 ? 0 : -(2 * (y - 1) * std::log(y) + (y - 1) * (y - 1) / y) / range;
}

double internal::barrier_curvature(double gap, double range) {
  const double y = gap / range;
  return y >= 1 ? 0 : -(2 * std::log(y) + 4 * (y - 1) / y - (y - 1) * (y - 1) / (y * y)) / (range * range);
}

void BarrierRange::limit(std::vector<NearPair>& pairs) const {
  const auto is_far = [](const NearPair& pair) { return !(pair.gap > 0 && pair.gap < pair.range); };
  std::erase_if(pairs, is_far);
  std::vector<NearPair*> all, good;
  for (const bool edges : {false, true}) {
    all.clear();
    good.clear();
    for (NearPair& pair : pairs) {
      if (pair.edges != edges) continue;
      all.push_back(&pair);
      if (std::ranges::none_of(pair.vertices, [&](Index v) { return touched[v] != 0; }))
        good.push_back(&pair);
    }
    if (!rest.empty()) keep_gaps(*this, rest, all);
    if (!target.empty()) keep_gaps(*this, target, good);
  }
  std::erase_if(pairs, is_far);
}

std::optional<NearPair> internal::near_pair(const FeaturePair& pair, const FourPoints& p,
                                            const BarrierRange& range, double share) {
  PairBatch batch{};
  NearestBatch nearest;
  batch.set(0, p, p);
  if (nearest_points(batch, 1, pair.edges, range.range + range.thickness, nearest) == 0) return std::nullopt;
  std::vector<NearPair> near{near_pair_of(close_pair(pair.v, pair.edges, nearest, 0), range)};
  range.limit(near);
  if (near.empty()) return std::nullopt;
  for (double& w : near[0].w) w *= share;
  return near[0];
}

Result<NearPairs> NearPairs::make(const RepairScene& scene, std::span<const double> rest,
                                  const std::vector<Index>& zones) {
  const auto mesh = std::make_shared<const CollisionMesh>(FOLDPROOF_TRY(merged_mesh(scene, rest)));
  auto triangles = scene_triangles(scene, mesh->hierarchy()->topology().triangles());
  const bool has_others = std::ranges::find(triangles, kNoIndex) != triangles.end();
  std::shared_ptr<const PairFilter> filter;
  if (scene.given_filter() != nullptr || !zones.empty() || has_others)
    filter = std::make_shared<MergedFilter>(scene, scene.filter_with(zones), std::move(triangles));
  NearPairs pairs;
  pairs.checker_ = std::make_unique<ContactChecker>(mesh, ContactSettings(), std::move(filter));
  return pairs;
}

Result<void> NearPairs::find(std::span<const double> x, const BarrierRange& range,
                             std::span<const std::uint8_t> active, std::vector<NearPair>& out) {
  FOLDPROOF_TRY(checker_->close_pairs(x, range.range + range.thickness, close_, active));
  out.clear();
  for (const ClosePair& close : close_) out.push_back(near_pair_of(close, range));
  range.limit(out);
  return {};
}

}  // namespace foldproof
