#include "certificate/contacts.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "oracle/brute_force.h"
#include "oracle/judge.h"

namespace foldproof::testing {

using oracle::Kind;

std::vector<FeaturePair> all_pairs(const Patch& patch) {
  std::set<std::uint16_t> vertices;
  std::set<std::array<std::uint16_t, 2>> edge_set;
  for (const auto& t : patch.triangles) {
    for (int k = 0; k < 3; ++k) {
      vertices.insert(t[k]);
      edge_set.insert({std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3])});
    }
  }
  std::vector<FeaturePair> pairs;
  for (const std::uint16_t v : vertices) {
    for (const auto& t : patch.triangles) {
      if (v != t[0] && v != t[1] && v != t[2]) pairs.push_back({Kind::VertexFace, {v, t[0], t[1], t[2]}});
    }
  }
  const std::vector<std::array<std::uint16_t, 2>> edges(edge_set.begin(), edge_set.end());
  for (std::size_t i = 0; i < edges.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const auto &a = edges[i], &b = edges[j];
      if (a[0] != b[0] && a[0] != b[1] && a[1] != b[0] && a[1] != b[1])
        pairs.push_back({Kind::EdgeEdge, {a[0], a[1], b[0], b[1]}});
    }
  }
  return pairs;
}

FourPoints points_of(const FeaturePair& pair, std::span<const Vec3> x) {
  return {x[pair.vertices[0]], x[pair.vertices[1]], x[pair.vertices[2]], x[pair.vertices[3]]};
}

double rough_distance(const FeaturePair& pair, std::span<const Vec3> x0, std::span<const Vec3> x1) {
  const FourPoints from = points_of(pair, x0), to = points_of(pair, x1);
  const auto distance_at = [&](double t) {
    FourPoints x;
    for (int k = 0; k < 4; ++k) x[k] = (1 - t) * from[k] + t * to[k];
    return (pair.kind == Kind::VertexFace ? vertex_face_closest(x) : edge_edge_closest(x)).distance;
  };
  constexpr int kSamples = 9;
  double nearest_time = 0, nearest = distance_at(0);
  for (int k = 1; k < kSamples; ++k) {
    const double t = double(k) / (kSamples - 1), d = distance_at(t);
    if (d < nearest) std::tie(nearest_time, nearest) = std::pair(t, d);
  }
  for (double step = 0.5 / (kSamples - 1); step > 1e-4; step /= 2) {
    for (const double t : {nearest_time - step, nearest_time + step}) {
      if (t < 0 || t > 1) continue;
      const double d = distance_at(t);
      if (d < nearest) std::tie(nearest_time, nearest) = std::pair(t, d);
    }
  }
  return nearest;
}

bool comes_within(const FeaturePair& pair, std::span<const Vec3> x0, std::span<const Vec3> x1, double gap) {
  const FourPoints from = points_of(pair, x0), to = points_of(pair, x1);
  if (gap == 0) return oracle::touches(pair.kind, from, to);
  return oracle::approach(pair.kind, from, to, gap, gap * 0x1p-24) == oracle::Approach::Within;
}

std::string find_contact(const Patch& patch, std::span<const Vec3> x0, std::span<const Vec3> x1, double gap) {
  CcdSettings settings;
  settings.thickness = gap;
  for (const FeaturePair& pair : all_pairs(patch)) {
    const FourPoints from = points_of(pair, x0), to = points_of(pair, x1);
    const CcdResult result = oracle::narrow_phase(pair.kind, from, to, settings);
    if (result.answer == Answer::Separated || !comes_within(pair, x0, x1, gap)) continue;
    return oracle::describe(pair.kind, from, to, settings);
  }
  return {};
}

namespace {

using Corners = std::array<std::uint16_t, 3>;

bool boxes_separated(const Corners& a, const Corners& b, std::span<const Vec3> x) {
  const Vec3 a_low = x[a[0]].cwiseMin(x[a[1]]).cwiseMin(x[a[2]]),
             a_high = x[a[0]].cwiseMax(x[a[1]]).cwiseMax(x[a[2]]);
  const Vec3 b_low = x[b[0]].cwiseMin(x[b[1]]).cwiseMin(x[b[2]]),
             b_high = x[b[0]].cwiseMax(x[b[1]]).cwiseMax(x[b[2]]);
  for (int axis = 0; axis < 3; ++axis) {
    if (a_low[axis] > b_high[axis] || b_low[axis] > a_high[axis]) return true;
  }
  return false;
}

}  // namespace

std::string find_crossing(const Patch& patch, std::span<const Vec3> x) {
  std::vector<double> positions;
  for (const Vec3& p : x) positions.insert(positions.end(), {p.x(), p.y(), p.z()});
  for (std::size_t i = 0; i < patch.triangles.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const auto &a = patch.triangles[i], &b = patch.triangles[j];
      if (boxes_separated(a, b, x)) continue;
      if (oracle::triangles_cross({a[0], a[1], a[2]}, {b[0], b[1], b[2]}, positions))
        return fmt::format("triangles {} and {} cross", i, j);
    }
  }
  return {};
}

}  // namespace foldproof::testing
