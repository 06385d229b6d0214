#include "repair/barrier.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/try.h"

namespace foldproof {
namespace {

// Where on the segment pq the origin is nearest, in [0,1].
double nearest_on_segment(const Vec3& p, const Vec3& q) {
  const Vec3 s = q - p;
  const double length = s.squaredNorm();
  return length > 0 ? std::clamp(-p.dot(s) / length, 0.0, 1.0) : 0.0;
}

struct Shortest {
  Weights best{{}, {}};
  double square = std::numeric_limits<double>::infinity();
  void consider(const std::array<double, 4>& w, const FourPoints& x) {
    const Vec3 d = w[0] * x[0] + w[1] * x[1] + w[2] * x[2] + w[3] * x[3];
    if (d.squaredNorm() >= square) return;
    square = d.squaredNorm();
    best = {w, d};
  }
};

// Determinants below this share of their terms belong to degenerate triangles or parallel edges.
constexpr double kDegenerate = 1e-12;

Weights vertex_face_weights(const FourPoints& x) {
  Shortest nearest;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t a = 1 + k, b = 1 + (k + 1) % 3;
    const double s = nearest_on_segment(x[a] - x[0], x[b] - x[0]);
    std::array<double, 4> w{1, 0, 0, 0};
    w[a] = s - 1;
    w[b] = -s;
    nearest.consider(w, x);
  }
  const Vec3 u = x[2] - x[1], v = x[3] - x[1], r = x[0] - x[1];
  const double uu = u.dot(u), uv = u.dot(v), vv = v.dot(v), det = uu * vv - uv * uv;
  if (det > kDegenerate * uu * vv) {
    const double s = (vv * u.dot(r) - uv * v.dot(r)) / det, t = (uu * v.dot(r) - uv * u.dot(r)) / det;
    if (s >= 0 && t >= 0 && s + t <= 1) nearest.consider({1, s + t - 1, -s, -t}, x);
  }
  return nearest.best;
}

Weights edge_edge_weights(const FourPoints& x) {
  Shortest nearest;
  for (std::size_t k = 0; k < 2; ++k) {
    const double t = nearest_on_segment(x[2] - x[k], x[3] - x[k]);
    const double s = nearest_on_segment(x[0] - x[2 + k], x[1] - x[2 + k]);
    nearest.consider({k == 0 ? 1.0 : 0.0, k == 1 ? 1.0 : 0.0, t - 1, -t}, x);
    nearest.consider({1 - s, s, k == 0 ? -1.0 : 0.0, k == 1 ? -1.0 : 0.0}, x);
  }
  const Vec3 a = x[1] - x[0], b = x[3] - x[2], r = x[0] - x[2];
  const double aa = a.dot(a), ab = a.dot(b), bb = b.dot(b), det = aa * bb - ab * ab;
  if (det > kDegenerate * aa * bb) {
    const double s = (ab * b.dot(r) - bb * a.dot(r)) / det, t = (aa * b.dot(r) - ab * a.dot(r)) / det;
    if (s >= 0 && s <= 1 && t >= 0 && t <= 1) nearest.consider({1 - s, s, t - 1, -t}, x);
  }
  return nearest.best;
}

// Whether the boxes of the two features are farther apart than `distance`.
bool boxes_apart(bool edges, const FourPoints& x, double distance) {
  const std::size_t n = edges ? 2 : 1;
  Vec3 low_a = x[0], high_a = x[0], low_b = x[3], high_b = x[3];
  if (edges) low_a = low_a.cwiseMin(x[1]), high_a = high_a.cwiseMax(x[1]);
  for (std::size_t k = n; k < 3; ++k) low_b = low_b.cwiseMin(x[k]), high_b = high_b.cwiseMax(x[k]);
  return std::max((low_a - high_b).maxCoeff(), (low_b - high_a).maxCoeff()) > distance;
}

constexpr double kKept = 0.9;    // a pair that is closer in a good pose keeps this share of its gap there,
constexpr double kLeast = 1e-3;  // but not less than this share of the range

}  // namespace

Weights internal::closest_weights(bool edges, const FourPoints& x) {
  return edges ? edge_edge_weights(x) : vertex_face_weights(x);
}

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

double BarrierRange::of(const FeaturePair& pair) const {
  double least = range;
  const auto keep = [&](std::span<const double> x) {
    const FourPoints p = points_of(x, pair);
    if (boxes_apart(pair.edges, p, range / kKept + thickness)) return;
    const double gap = closest_weights(pair.edges, p).difference.norm() - thickness;
    least = std::min(least, std::max(kKept * gap, kLeast * range));
  };
  if (!rest.empty()) keep(rest);
  if (!target.empty() && std::ranges::none_of(pair.v, [&](Index v) { return touched[v] != 0; })) keep(target);
  return least;
}

std::optional<NearPair> internal::near_pair(const FeaturePair& pair, const FourPoints& p,
                                            const BarrierRange& range, double share) {
  if (boxes_apart(pair.edges, p, range.range + range.thickness)) return std::nullopt;
  const Weights nearest = closest_weights(pair.edges, p);
  const double distance = nearest.difference.norm(), gap = distance - range.thickness;
  if (!(gap > 0) || gap >= range.range) return std::nullopt;
  const double own = range.of(pair);
  if (gap >= own) return std::nullopt;
  NearPair near{pair, nearest.w, nearest.difference / distance, gap, own};
  for (double& w : near.w) w *= share;
  return near;
}

Result<NearPairs> NearPairs::make(const RepairScene& scene, std::span<const double> rest) {
  NearPairs pairs(scene);
  pairs.filter_ = scene.filter();
  std::vector<Triangle> faces;
  std::vector<Edge> lines;
  for (Index t = 0; t < scene.triangles().size(); ++t) {
    const Triangle& v = scene.triangles()[t];
    if (v[0] == v[1] && v[1] == v[2]) {
      pairs.points_.resize(scene.vertex_count(), kNoIndex);
      pairs.points_[v[0]] = t;
    } else if (v[0] == v[1] || v[1] == v[2] || v[2] == v[0]) {
      const auto [low, high] = std::minmax({v[0], v[1], v[2]});
      pairs.lines_.emplace_back(Edge{low, high}, t);
    } else {
      faces.push_back(v);
      pairs.faces_.push_back(t);
    }
  }
  std::ranges::sort(pairs.lines_);
  for (const auto& [line, triangle] : pairs.lines_) {
    if (lines.empty() || lines.back() != line) lines.push_back(line);
  }
  std::vector<Index> group(scene.vertex_count());
  for (Index v = 0; v < group.size(); ++v) group[v] = scene.is_movable(v) ? 0 : 1;
  CollisionMeshSettings settings;
  settings.points = !pairs.points_.empty();
  if (std::ranges::find(group, 1u) != group.end()) {
    const std::array<Index, 2> fixed[] = {{1, 1}};
    settings.filter = FOLDPROOF_TRY(CollisionFilter::groups(std::move(group), fixed));
  }
  auto mesh = FOLDPROOF_TRY(CollisionMesh::make(rest, std::move(lines), std::move(faces), settings));
  pairs.checker_ = std::make_unique<ContactChecker>(std::make_shared<const CollisionMesh>(std::move(mesh)));
  return pairs;
}

Index NearPairs::triangle_with(const Edge& line) const {
  const Edge sorted{std::min(line[0], line[1]), std::max(line[0], line[1])};
  return std::ranges::lower_bound(lines_, sorted, {}, &std::pair<Edge, Index>::first)->second;
}

bool NearPairs::is_tested(const FeaturePair& pair, Index face) const {
  const Index a = scene_->object_of_vertex(pair.v[0]), b = scene_->object_of_vertex(pair.v[3]);
  const RepairSceneObject &in_a = scene_->begin(a), &in_b = scene_->begin(b);
  if (!pair.edges) return filter_->vertex_face(a, pair.v[0] - in_a.vertices, b, face - in_b.triangles);
  const auto edge = [](Index p, Index q) { return Edge{std::min(p, q), std::max(p, q)}; };
  return filter_->edge_edge(a, edge(pair.v[0] - in_a.vertices, pair.v[1] - in_a.vertices), b,
                            edge(pair.v[2] - in_b.vertices, pair.v[3] - in_b.vertices));
}

void NearPairs::add(const FeaturePair& pair, std::span<const double> x, const BarrierRange& range, Index face,
                    std::vector<NearPair>& out) const {
  const auto near = near_pair(pair, points_of(x, pair), range);
  if (near && is_tested(pair, face)) out.push_back(*near);
}

Result<void> NearPairs::find(std::span<const double> x, const BarrierRange& range,
                             std::vector<NearPair>& out) {
  out.clear();
  FOLDPROOF_TRY(checker_->candidates(x, range.range + range.thickness, candidates_));
  const auto edges = checker_->mesh().edges();
  for (const auto& [v, f] : candidates_.vertex_face) {
    const Triangle& t = checker_->mesh().faces()[f];
    add({false, {v, t[0], t[1], t[2]}}, x, range, faces_[f], out);
  }
  for (const auto& [a, b] : candidates_.edge_edge)
    add({true, {edges[a][0], edges[a][1], edges[b][0], edges[b][1]}}, x, range, kNoIndex, out);
  if (points_.empty()) return {};
  for (const auto& [e, v] : candidates_.edge_vertex) {
    if (points_[v] != kNoIndex)
      add({false, {v, edges[e][0], edges[e][1], edges[e][1]}}, x, range, triangle_with(edges[e]), out);
  }
  for (const auto& [a, b] : candidates_.vertex_vertex) {
    if (points_[a] != kNoIndex && points_[b] != kNoIndex)
      add({false, {a, b, b, b}}, x, range, points_[b], out);
  }
  return {};
}

}  // namespace foldproof
