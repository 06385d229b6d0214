#include "repair/barrier.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <set>

#include "base/try.h"
#include "solver/pair_distances.h"

namespace foldproof {
namespace {

constexpr double kKept = 0.9;    // a pair that is closer in a good pose keeps this share of its gap there,
constexpr double kLeast = 1e-3;  // but not less than this share of the range
constexpr double kSlack = 0.5;   // of the list, in ranges

// Names a triangle by its vertices, in whatever order; a line and a point, too.
Triangle key_of(Triangle t) {
  std::ranges::sort(t);
  if (t[0] == t[1]) t[1] = t[2];
  return t;
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

// Calls visit(pair, nearest, lane) for the pairs that are wanted and, in the pose x, not proven farther
// apart.
template <class Wanted, class Visit>
void measure(std::span<Candidate> pairs, std::span<const double> x, double farthest, const Wanted& wanted,
             const Visit& visit) {
  PairBatch batch{};
  NearestBatch nearest;
  std::array<Candidate*, 8> lanes{};
  int count = 0;
  const auto flush = [&] {
    const bool edges = count > 0 && lanes[0]->pair.edges;
    unsigned left = count > 0 ? maybe_near(batch, count, edges, farthest) : 0;
    if (left != 0) left &= nearest_points(batch, count, edges, farthest, nearest);
    for (; left != 0; left &= left - 1) {
      const int lane = std::countr_zero(left);
      visit(*lanes[static_cast<std::size_t>(lane)], nearest, lane);
    }
    count = 0;
  };
  for (Candidate& candidate : pairs) {
    if (!wanted(candidate)) continue;
    if (count == 8 || (count > 0 && lanes[0]->pair.edges != candidate.pair.edges)) flush();
    const FourPoints p = points_of(x, candidate.pair.v);
    batch.set(count, p, p);
    lanes[static_cast<std::size_t>(count++)] = &candidate;
  }
  flush();
}

NearPair near_pair_of(const Candidate& candidate, const NearestBatch& nearest, int lane, double thickness) {
  const ClosePair close = close_pair(candidate.pair.v, candidate.pair.edges, nearest, lane);
  return {close.vertices, close.weights, close.normal, close.distance - thickness, candidate.range};
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

void BarrierRange::limit(std::span<Candidate> pairs) const {
  const auto keep_gap = [&](Candidate& pair, const NearestBatch& nearest, int lane) {
    const double gap = nearest.distance[lane] - thickness;
    pair.range = std::min(pair.range, std::max(kKept * gap, kLeast * range));
  };
  const auto is_good = [&](const Candidate& candidate) {
    return std::ranges::none_of(candidate.pair.v, [&](Index v) { return touched[v] != 0; });
  };
  const double farthest = range / kKept + thickness;
  for (Candidate& pair : pairs) pair.range = range;
  if (!rest.empty())
    measure(
        pairs, rest, farthest, [](const Candidate&) { return true; }, keep_gap);
  if (!target.empty()) measure(pairs, target, farthest, is_good, keep_gap);
}

std::optional<NearPair> internal::near_pair(const FeaturePair& pair, const FourPoints& p, double range,
                                            double thickness, double share) {
  PairBatch batch{};
  NearestBatch nearest;
  batch.set(0, p, p);
  if (nearest_points(batch, 1, pair.edges, range + thickness, nearest) == 0) return std::nullopt;
  NearPair near = near_pair_of({pair, range, 0}, nearest, 0, thickness);
  if (!(near.gap > 0 && near.gap < near.range)) return std::nullopt;
  for (double& w : near.w) w *= share;
  return near;
}

Result<NearPairs> NearPairs::make(const RepairScene& scene, std::span<const double> rest,
                                  const std::shared_ptr<const PairFilter>& filter) {
  const auto mesh = std::make_shared<const CollisionMesh>(FOLDPROOF_TRY(merged_mesh(scene, rest)));
  NearPairs pairs(scene);
  pairs.checker_ = std::make_unique<ContactChecker>(mesh);
  // Its points may be vertices of no triangle.
  if (filter == scene.filter() && scene.given_filter() == nullptr && mesh->codim_points().empty())
    return pairs;
  pairs.filter_ = filter;
  for (Index t = 0; t < scene.triangles().size(); ++t)
    pairs.triangles_.emplace(key_of(scene.triangles()[t]), t);
  return pairs;
}

bool NearPairs::is_ignored(const FeaturePair& pair) const {
  if (filter_ == nullptr) return false;
  const auto& [a0, a1, b0, b1] = pair.v;
  const Index a = scene_->object_of_vertex(a0), first_a = scene_->begin(a).vertices;
  const Index b = scene_->object_of_vertex(b0), first_b = scene_->begin(b).vertices;
  if (pair.edges)
    return !filter_->edge_edge(a, {a0 - first_a, a1 - first_a}, b, {b0 - first_b, b1 - first_b});
  const auto face = triangles_.find(key_of({a1, b0, b1}));
  return face == triangles_.end() ||
         !filter_->vertex_face(a, a0 - first_a, b, face->second - scene_->begin(b).triangles);
}

void NearPairs::start(const BarrierRange& range) {
  range_ = range;
  listed_at_.clear();
}

// Whether no vertex was moved by more than half of a length, in ranges, since the list was made.
bool NearPairs::is_near(std::span<const double> x, double length) const {
  if (listed_at_.empty()) return false;
  const double most = length * range_.range / 2;
  for (Index v = 0; v < x.size() / 3; ++v) {
    const double square = (at(x, v) - at(listed_at_, v)).squaredNorm();
    if (square > most * most || (square > 0 && may_move_[v] == 0)) return false;
  }
  return true;
}

bool NearPairs::knows_touching(std::span<const double> x) const { return is_near(x, 1 + kSlack); }

bool NearPairs::was_moved(std::span<const double> x, Index v) const {
  return range_.target.empty() || range_.touched[v] != 0 || at(x, v) != at(range_.target, v);
}

Result<void> NearPairs::list(std::span<const double> x, std::span<const std::uint8_t> active) {
  const bool is_first = listed_at_.empty();  // of the frame; what moved in the last one is likely to move
  may_move_.resize(x.size() / 3, 0);
  for (Index v = 0; v < may_move_.size(); ++v) {
    const bool is_active = !active.empty() && active[v] != 0;
    may_move_[v] = is_active || was_moved(x, v) || (is_first && may_move_[v] != 0);
  }
  const double gap = (1 + kSlack) * range_.range;
  FOLDPROOF_TRY(checker_->candidates(x, gap + range_.thickness, found_));
  const CollisionMesh& mesh = checker_->mesh();
  list_.clear();
  const auto add = [&](bool edges, const std::array<Index, 4>& v) {
    if (std::ranges::any_of(v, [&](Index i) { return may_move_[i] != 0; }))
      list_.push_back({{edges, v}, 0, std::numeric_limits<double>::infinity()});
  };
  for (const auto& [v, face] : found_.vertex_face) {
    const Triangle& t = mesh.faces()[face];
    add(false, {v, t[0], t[1], t[2]});
  }
  for (const auto& [edge, v] : found_.edge_vertex) {
    const Edge& e = mesh.edges()[edge];
    add(false, {v, e[0], e[1], e[1]});
  }
  for (const auto& [a, b] : found_.vertex_vertex) add(false, {a, b, b, b});
  for (const auto& [a, b] : found_.edge_edge) {
    const Edge &e = mesh.edges()[a], &f = mesh.edges()[b];
    add(true, {e[0], e[1], f[0], f[1]});
  }
  measure(
      list_, x, gap + range_.thickness, [](const Candidate&) { return true; },
      [&](Candidate& candidate, const NearestBatch& nearest, int lane) {
        candidate.gap = std::max(0.0, nearest.distance[lane] - range_.thickness);
      });
  std::erase_if(list_, [&](const Candidate& candidate) {
    return !(candidate.gap < gap) || is_ignored(candidate.pair);
  });
  range_.limit(list_);
  listed_at_.assign(x.begin(), x.end());
  return {};
}

Result<void> NearPairs::find(std::span<const double> x, std::span<const std::uint8_t> active,
                             std::vector<NearPair>& out) {
  if (!is_near(x, kSlack)) FOLDPROOF_TRY(list(x, active));
  out.clear();
  const bool is_where_listed = std::equal(x.begin(), x.end(), listed_at_.begin());
  const auto may_be_near = [&](const Candidate& candidate) {
    if (is_where_listed && candidate.gap >= candidate.range) return false;
    return active.empty() || std::ranges::any_of(candidate.pair.v, [&](Index v) { return active[v] != 0; });
  };
  measure(list_, x, range_.range + range_.thickness, may_be_near,
          [&](const Candidate& candidate, const NearestBatch& nearest, int lane) {
            const NearPair near = near_pair_of(candidate, nearest, lane, range_.thickness);
            if (near.gap > 0 && near.gap < near.range) out.push_back(near);
          });
  return {};
}

void NearPairs::may_touch(std::span<const double> x, std::vector<FeaturePair>& out) const {
  const auto moved = [&](Index v) { return at(x, v) - at(listed_at_, v); };
  for (const Candidate& candidate : list_) {
    const FeaturePair& pair = candidate.pair;
    const std::size_t n = pair.edges ? 2 : 1;
    const double square = candidate.gap * candidate.gap;
    bool may = false;
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t k = n; k < 4; ++k)
        may |= (moved(pair.v[i]) - moved(pair.v[k])).squaredNorm() >= square;
    }
    if (may) out.push_back(pair);
  }
}

}  // namespace foldproof
