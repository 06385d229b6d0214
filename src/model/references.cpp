#include "model/references.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace foldproof::internal {
namespace {

// More pairs would not distinguish poses better, and memory holds a descriptor per pose.
constexpr std::size_t kMaxPairs = 4096;

double squared_distance(std::span<const float> a, std::span<const float> b) {
  double sum = 0;
  for (std::size_t k = 0; k < a.size(); ++k) sum += (double{a[k]} - b[k]) * (double{a[k]} - b[k]);
  return sum;
}

}  // namespace

BendDescriptor::BendDescriptor(const PatchSlots& slots) : hierarchy_(slots.hierarchy()) {
  std::size_t all = 0;
  for (Index leaf = 0; leaf < hierarchy_->leaf_count(); ++leaf) all += slots.neighbors(leaf).size();
  const std::size_t stride = all / (2 * kMaxPairs) + 1;
  std::size_t k = 0;
  for (Index leaf = 0; leaf < hierarchy_->leaf_count(); ++leaf) {
    for (const Index other : slots.neighbors(leaf)) {
      if (leaf < other && k++ % stride == 0) pairs_.push_back({leaf, other});
    }
  }
}

std::vector<float> BendDescriptor::of(std::span<const double> positions) const {
  const Hierarchy& h = *hierarchy_;
  const auto corner = [&](Index v) { return Vec3::load(&positions[3 * std::size_t{v}]); };
  std::vector<Vec3> normals(h.leaf_count(), Vec3::Zero());
  for (Index leaf = 0; leaf < h.leaf_count(); ++leaf) {
    for (Index k = h.leaves()[leaf].triangles; k < h.leaves()[leaf + 1].triangles; ++k) {
      const Triangle& t = h.topology().triangles()[h.triangle_ids()[k]];
      normals[leaf] += (corner(t[1]) - corner(t[0])).cross(corner(t[2]) - corner(t[0]));
    }
    normals[leaf] = normals[leaf].stableNormalized();
  }
  std::vector<float> cosines;
  cosines.reserve(pairs_.size());
  for (const auto& [a, b] : pairs_) {
    const double cosine = normals[a].dot(normals[b]);
    cosines.push_back(std::isnan(cosine) ? 0.f : static_cast<float>(std::clamp(cosine, -1.0, 1.0)));
  }
  return cosines;
}

std::vector<Index> choose_references(std::span<const std::vector<float>> descriptors, Index count) {
  std::vector<Index> chosen;
  std::vector<double> nearest(descriptors.size(), std::numeric_limits<double>::infinity());
  Index next = 0;
  while (chosen.size() < count && nearest[next] > 0) {
    chosen.push_back(next);
    for (std::size_t k = 0; k < descriptors.size(); ++k) {
      nearest[k] = std::min(nearest[k], squared_distance(descriptors[k], descriptors[next]));
    }
    next = static_cast<Index>(std::max_element(nearest.begin(), nearest.end()) - nearest.begin());
  }
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

}  // namespace foldproof::internal
