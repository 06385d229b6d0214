#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "certificate/scaffold.h"

namespace foldproof::internal {
namespace {

// The smallest cosine between a triangle's normal and the direction of projection. Steeper triangles become
// too thin in the plane to prove much.
constexpr float kMinCosine = 0.15f;

// The largest uv coordinate of a patch. The margin to the square keeps scaffold triangles from being thin.
constexpr float kMaxUv = 18000;

using Vec3f = Eigen::Vector3f;

Vec3f at(const std::array<float, 3>& p) { return {p[0], p[1], p[2]}; }

// Exact where the numbers are floats.
Vec3f in_floats(const Vec3& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

}  // namespace

struct Parametrizer::Scratch {
  std::vector<Vec3f> normals;
  std::vector<Vec3f> projected;
  ScaffoldBuilder scaffold;
  HalfEdgeSet half_edges;
};

Parametrizer::Parametrizer() : scratch_(new Scratch) {}
Parametrizer::~Parametrizer() = default;
Parametrizer::Parametrizer(Parametrizer&&) noexcept = default;

namespace {

// A direction that all triangles face: their mean normal, moved towards the normal that deviates most, round
// by round. Zero where that finds none.
Vec3f facing_direction(const Patch& patch, std::span<const std::array<float, 3>> x,
                       std::vector<Vec3f>& normals) {
  normals.clear();
  Vec3f mean = Vec3f::Zero();
  for (const auto& t : patch.triangles) {
    const Vec3f area = (at(x[t[1]]) - at(x[t[0]])).cross(at(x[t[2]]) - at(x[t[0]]));
    const float size = area.norm();
    if (!(size > 0)) return Vec3f::Zero();
    mean += area;
    normals.push_back(area / size);
  }
  mean.normalize();
  for (int round = 0; round < 12; ++round) {
    const Vec3f* worst = &normals[0];
    for (const Vec3f& n : normals) {
      if (n.dot(mean) < worst->dot(mean)) worst = &n;
    }
    const float cosine = worst->dot(mean);
    if (cosine > 0.6f || (round == 0 && cosine < -0.8f)) break;
    mean = (mean + *worst * (1.2f / static_cast<float>(round + 2))).normalized();
  }
  for (const Vec3f& n : normals) {
    if (!(n.dot(mean) > kMinCosine)) return Vec3f::Zero();
  }
  return mean;
}

// Projects along `facing` and rounds to integers.
void project(std::span<const std::array<float, 3>> x, const Vec3f& facing, std::vector<Vec3f>& projected,
             UvMap& out) {
  const Vec3f u = facing.unitOrthogonal(), w = facing.cross(u);
  projected.clear();
  Vec3f low = Vec3f::Constant(std::numeric_limits<float>::infinity()), high = -low;
  for (const auto& p : x) {
    const Vec3f d = at(p) - at(x[0]);
    projected.emplace_back(d.dot(u), d.dot(w), d.dot(facing));
    low = low.cwiseMin(projected.back());
    high = high.cwiseMax(projected.back());
  }
  const Vec3f middle = (low + high) / 2;
  const float scale = kMaxUv / ((high - low).maxCoeff() / 2);
  for (const Vec3f& p : projected) {
    const Vec3f q = (p - middle) * scale;
    const auto round = [](float c) {
      return static_cast<std::int16_t>(std::clamp(c, -kMaxUv, kMaxUv) + (c < 0 ? -0.5f : 0.5f));
    };
    out.uvs.push_back({round(q.x()), round(q.y())});
    out.heights.push_back(round(q.z()));
  }
}

}  // namespace

Vec3 Parametrizer::facing(const Patch& patch, std::span<const std::array<float, 3>> positions) {
  return Vec3::load(facing_direction(patch, positions, scratch_->normals).data());
}

bool Parametrizer::faces(const Vec3& direction, const std::array<std::array<float, 3>, 3>& corners) {
  const Vec3f area = (at(corners[1]) - at(corners[0])).cross(at(corners[2]) - at(corners[0]));
  return area.dot(in_floats(direction)) > kMinCosine * area.norm();
}

ChartOutcome Parametrizer::build(const Patch& patch, std::span<const std::array<float, 3>> positions,
                                 const Vec3& facing, UvMap& out) {
  out.uvs.clear();
  out.heights.clear();
  out.scaffold.clear();
  if (patch.vertices.size() > 0xFFF0) return ChartOutcome::TooLarge;
  const Vec3f direction = in_floats(facing);
  if (direction.isZero()) return ChartOutcome::TooCurved;
  project(positions, direction, scratch_->projected, out);
  if (!scratch_->scaffold.build(patch, out) || !chart_is_valid(patch, out, scratch_->half_edges))
    return ChartOutcome::Overlapping;
  return ChartOutcome::Made;
}

}  // namespace foldproof::internal
