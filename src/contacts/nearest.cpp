#include "contacts/nearest.h"

#include <algorithm>

namespace foldproof::internal {
namespace {

constexpr Index kLeafSize = 8;

Vec3 nearest_on_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 d = b - a;
  const double square = d.squaredNorm();
  return square > 0 ? a + std::clamp((p - a).dot(d) / square, 0.0, 1.0) * d : a;
}

double box_distance2(const Vec3& p, const Vec3& low, const Vec3& high) {
  return (low - p).cwiseMax(p - high).cwiseMax(Vec3::Zero()).squaredNorm();
}

bool is_less(const Vec3& a, const Vec3& b) {
  return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end());
}

}  // namespace

Vec3 nearest_on_triangle(const Vec3& p, const std::array<Vec3, 3>& t) {
  const Vec3 n = (t[1] - t[0]).cross(t[2] - t[0]);
  const double square = n.squaredNorm();
  bool inside = square > 0;
  for (int k = 0; k < 3 && inside; ++k) inside = n.dot((t[(k + 1) % 3] - t[k]).cross(p - t[k])) >= 0;
  if (inside) return p - n.dot(p - t[0]) / square * n;
  Vec3 best = nearest_on_segment(p, t[0], t[1]);
  for (int k = 1; k < 3; ++k) {
    const Vec3 q = nearest_on_segment(p, t[k], t[(k + 1) % 3]);
    if ((q - p).squaredNorm() < (best - p).squaredNorm()) best = q;
  }
  return best;
}

void NearestTriangles::build(std::span<const std::array<Vec3, 3>> triangles) {
  nodes_.clear();
  centers_.clear();
  for (Index i = 0; i < triangles.size(); ++i) {
    const auto& [a, b, c] = triangles[i];
    centers_.push_back({a + b + c, i});
  }
  triangles_.resize(triangles.size());
  if (!triangles.empty()) build_node(triangles, 0, static_cast<Index>(triangles.size()));
}

Index NearestTriangles::build_node(std::span<const std::array<Vec3, 3>> triangles, Index begin, Index end) {
  const auto id = static_cast<Index>(nodes_.size());
  nodes_.emplace_back();
  if (end - begin <= kLeafSize) {
    Node node{triangles[centers_[begin].triangle][0], triangles[centers_[begin].triangle][0], 0, begin, end};
    for (Index i = begin; i < end; ++i) {
      triangles_[i] = triangles[centers_[i].triangle];
      for (const Vec3& v : triangles_[i]) {
        node.low = node.low.cwiseMin(v);
        node.high = node.high.cwiseMax(v);
      }
    }
    nodes_[id] = node;
    return id;
  }
  Vec3 low = centers_[begin].sum, high = low;
  for (Index i = begin; i < end; ++i)
    low = low.cwiseMin(centers_[i].sum), high = high.cwiseMax(centers_[i].sum);
  const Vec3 extent = high - low;
  const auto axis = static_cast<std::size_t>(std::max_element(extent.begin(), extent.end()) - extent.begin());
  const Index middle = begin + (end - begin) / 2;
  std::nth_element(centers_.begin() + begin, centers_.begin() + middle, centers_.begin() + end,
                   [&](const Center& a, const Center& b) { return a.sum[axis] < b.sum[axis]; });
  const Index left = build_node(triangles, begin, middle), right = build_node(triangles, middle, end);
  nodes_[id] = {nodes_[left].low.cwiseMin(nodes_[right].low), nodes_[left].high.cwiseMax(nodes_[right].high),
                right, begin, end};
  return id;
}

Vec3 NearestTriangles::nearest(const Vec3& p, const Vec3& known) const {
  Vec3 best = known;
  double best2 = (best - p).squaredNorm();
  std::array<Index, 64> stack;  // the tree is balanced: at most 32 levels
  std::size_t size = 0;
  stack[size++] = 0;
  while (size > 0) {
    const Index id = stack[--size];
    const Node& node = nodes_[id];
    if (box_distance2(p, node.low, node.high) > best2) continue;
    if (node.right == 0) {
      for (Index i = node.begin; i < node.end; ++i) {
        const auto& [a, b, c] = triangles_[i];
        if (box_distance2(p, a.cwiseMin(b).cwiseMin(c), a.cwiseMax(b).cwiseMax(c)) > best2) continue;
        const Vec3 q = nearest_on_triangle(p, triangles_[i]);
        const double q2 = (q - p).squaredNorm();
        // Of equally near ones the same in every order.
        if ((q2 < best2 || (q2 == best2 && is_less(q, best))) && (!counts || counts(centers_[i].triangle, q)))
          best = q, best2 = q2;
      }
      continue;
    }
    const Index left = id + 1, right = node.right;
    const bool left_first = box_distance2(p, nodes_[left].low, nodes_[left].high) <=
                            box_distance2(p, nodes_[right].low, nodes_[right].high);
    stack[size++] = left_first ? right : left;
    stack[size++] = left_first ? left : right;
  }
  return best;
}

}  // namespace foldproof::internal
