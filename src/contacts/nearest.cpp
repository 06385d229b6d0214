#include "contacts/nearest.h"

#include <algorithm>
#include <cmath>
#include <optional>

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
  // Of an edge, unless `p` is on its inner side.
  std::optional<Vec3> best;
  for (int k = 0; k < 3; ++k) {
    const Vec3 &a = t[k], &b = t[(k + 1) % 3];
    if (square > 0 && n.dot((b - a).cross(p - a)) >= 0) continue;
    const Vec3 q = nearest_on_segment(p, a, b);
    if (!best || (q - p).squaredNorm() < (*best - p).squaredNorm()) best = q;
  }
  return best ? *best : p - n.dot(p - t[0]) / square * n;
}

void NearestTriangles::set(std::span<const std::array<Vec3, 3>> triangles) {
  triangles_.assign(triangles.begin(), triangles.end());
  nodes_.clear();
  balls_.clear();
  asked_ = 0;
  for (Index i = 0; i < triangles.size(); ++i) {
    const auto& [a, b, c] = triangles[i];
    const Vec3 center = (a + b + c) / 3;
    const double square =
        std::max({(a - center).squaredNorm(), (b - center).squaredNorm(), (c - center).squaredNorm()});
    balls_.push_back({center, std::sqrt(square) * (1 + 0x1p-40), i});
  }
}

Index NearestTriangles::build_node(Index begin, Index end) {
  const auto id = static_cast<Index>(nodes_.size());
  nodes_.emplace_back();
  if (end - begin <= kLeafSize) {
    Node node{triangles_[balls_[begin].triangle][0], triangles_[balls_[begin].triangle][0], 0, begin, end};
    for (Index i = begin; i < end; ++i) {
      for (const Vec3& v : triangles_[balls_[i].triangle]) {
        node.low = node.low.cwiseMin(v);
        node.high = node.high.cwiseMax(v);
      }
    }
    nodes_[id] = node;
    return id;
  }
  Vec3 low = balls_[begin].center, high = low;
  for (Index i = begin; i < end; ++i)
    low = low.cwiseMin(balls_[i].center), high = high.cwiseMax(balls_[i].center);
  const Vec3 extent = high - low;
  const auto axis = static_cast<std::size_t>(std::max_element(extent.begin(), extent.end()) - extent.begin());
  const Index middle = begin + (end - begin) / 2;
  std::nth_element(balls_.begin() + begin, balls_.begin() + middle, balls_.begin() + end,
                   [&](const Ball& a, const Ball& b) { return a.center[axis] < b.center[axis]; });
  const Index left = build_node(begin, middle), right = build_node(middle, end);
  nodes_[id] = {nodes_[left].low.cwiseMin(nodes_[right].low), nodes_[left].high.cwiseMax(nodes_[right].high),
                right, begin, end};
  return id;
}

Vec3 NearestTriangles::nearest(const Vec3& p, const Vec3& known) {
  constexpr std::size_t kFew = 64;  // about as many searches of all take as long as the tree's building
  if (asked_++ == kFew) build_node(0, static_cast<Index>(balls_.size()));
  Vec3 best = known;
  double square = (best - p).squaredNorm(), distance = std::sqrt(square);
  const auto search_leaf = [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) {
      const double reach = (distance + balls_[i].radius) * (1 + 0x1p-40);
      if ((balls_[i].center - p).squaredNorm() > reach * reach) continue;
      const Vec3 q = nearest_on_triangle(p, triangles_[balls_[i].triangle]);
      const double q2 = (q - p).squaredNorm();
      // Of equally near ones the same in every order.
      if (q2 > square || (q2 == square && !is_less(q, best)) || (counts && !counts(balls_[i].triangle, q)))
        continue;
      best = q, square = q2, distance = std::sqrt(q2);
    }
  };
  if (nodes_.empty()) {
    search_leaf(0, static_cast<Index>(balls_.size()));
    return best;
  }
  std::array<Index, 64> stack;  // the tree is balanced: at most 32 levels
  std::size_t size = 0;
  stack[size++] = 0;
  while (size > 0) {
    const Index id = stack[--size];
    const Node& node = nodes_[id];
    if (box_distance2(p, node.low, node.high) > square) continue;
    if (node.right == 0) {
      search_leaf(node.begin, node.end);
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
