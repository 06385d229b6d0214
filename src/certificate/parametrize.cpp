#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "certificate/outline.h"

namespace foldproof {
namespace {

// A triangle that faces the plane at a steeper angle than this is too thin in the picture to prove much.
constexpr float kLeastCosine = 0.15f;

// The largest coordinate of a patch. Room is left to the square, so that the triangles between are not thin.
constexpr float kReach = 18000;

using Vec3f = Eigen::Vector3f;

Vec3f at(const std::array<float, 3>& p) { return {p[0], p[1], p[2]}; }

}  // namespace

struct ChartMaker::Scratch {
  std::vector<Vec3f> normals;
  std::vector<Vec3f> turned;
  OutlineFiller filler;
  DirectedSides sides;
};

ChartMaker::ChartMaker() : scratch_(new Scratch) {}
ChartMaker::~ChartMaker() = default;
ChartMaker::ChartMaker(ChartMaker&&) noexcept = default;

namespace {

// The direction that all triangles face: their mean normal, pulled towards those that it faces least. Zero
// when there is none.
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
    const float least = worst->dot(mean);
    if (least > 0.6f || (round == 0 && least < -0.8f)) break;
    mean = (mean + *worst * (1.2f / static_cast<float>(round + 2))).normalized();
  }
  for (const Vec3f& n : normals) {
    if (!(n.dot(mean) > kLeastCosine)) return Vec3f::Zero();
  }
  return mean;
}

// Projects along `facing` and rounds to the grid.
void project(std::span<const std::array<float, 3>> x, const Vec3f& facing, std::vector<Vec3f>& turned,
             Drawing& out) {
  const Vec3f u = facing.unitOrthogonal(), w = facing.cross(u);
  turned.clear();
  Vec3f low = Vec3f::Constant(std::numeric_limits<float>::infinity()), high = -low;
  for (const auto& p : x) {
    const Vec3f d = at(p) - at(x[0]);
    turned.emplace_back(d.dot(u), d.dot(w), d.dot(facing));
    low = low.cwiseMin(turned.back());
    high = high.cwiseMax(turned.back());
  }
  const Vec3f middle = (low + high) / 2;
  const float scale = kReach / ((high - low).maxCoeff() / 2);
  for (const Vec3f& p : turned) {
    const Vec3f q = (p - middle) * scale;
    const auto round = [](float c) {
      return static_cast<std::int16_t>(std::clamp(c, -kReach, kReach) + (c < 0 ? -0.5f : 0.5f));
    };
    out.places.push_back({round(q.x()), round(q.y())});
    out.heights.push_back(round(q.z()));
  }
}

}  // namespace

Vec3f ChartMaker::facing(const Patch& patch, std::span<const std::array<float, 3>> positions) {
  return facing_direction(patch, positions, scratch_->normals);
}

bool ChartMaker::faces(const Vec3f& direction, const Vec3f (&corners)[3]) {
  const Vec3f area = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
  return area.dot(direction) > kLeastCosine * area.norm();
}

ChartOutcome ChartMaker::draw(const Patch& patch, std::span<const std::array<float, 3>> positions,
                              const Vec3f& facing, Drawing& out) {
  out.places.clear();
  out.heights.clear();
  out.fillers.clear();
  if (patch.vertices.size() > 0xFFF0) return ChartOutcome::TooLarge;
  if (facing.isZero()) return ChartOutcome::TooCurved;
  project(positions, facing, scratch_->turned, out);
  if (!scratch_->filler.fill(patch, out) || !chart_is_valid(patch, out, scratch_->sides))
    return ChartOutcome::Tangled;
  return ChartOutcome::Made;
}

}  // namespace foldproof
