#include "contacts/shells.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <optional>
#include <tuple>

#include "check/motion.h"

namespace foldproof::internal {
namespace {

Index root_of(std::vector<Index>& parent, Index v) {
  while (parent[v] != v) v = parent[v] = parent[parent[v]];
  return v;
}

void unite(std::vector<Index>& parent, Index a, Index b) {
  a = root_of(parent, a);
  b = root_of(parent, b);
  parent[std::max(a, b)] = std::min(a, b);
}

// Of a triangle, seen from the origin (van Oosterom and Strackee 1983).
double solid_angle(const Vec3& a, const Vec3& b, const Vec3& c) {
  const double p = a.norm(), q = b.norm(), r = c.norm();
  return 2 * std::atan2(a.dot(b.cross(c)), p * q * r + a.dot(b) * r + b.dot(c) * p + c.dot(a) * q);
}

}  // namespace

Shells::Shells(const Topology& topology) : topology_(topology) {
  std::vector<Index> parent(topology.vertex_count());
  std::iota(parent.begin(), parent.end(), Index{0});
  std::vector<std::uint8_t> is_used(parent.size(), 0);
  for (const Triangle& t : topology.faces()) {
    unite(parent, t[0], t[1]);
    unite(parent, t[0], t[2]);
    for (const Index v : t) is_used[v] = 1;
  }
  shell_.assign(parent.size(), kNoIndex);
  Index count = 0;
  for (Index v = 0; v < parent.size(); ++v) {
    if (!is_used[v]) continue;
    const Index root = root_of(parent, v);  // the smallest vertex, which has its number already
    shell_[v] = root == v ? count++ : shell_[root];
  }
  faces_begin_.assign(std::size_t{count} + 1, 0);
  for (const Triangle& t : topology.faces()) ++faces_begin_[shell_[t[0]] + 1];
  std::partial_sum(faces_begin_.begin(), faces_begin_.end(), faces_begin_.begin());
  std::vector<std::size_t> next(faces_begin_.begin(), faces_begin_.end() - 1);
  faces_.resize(topology.face_count());
  for (Index t = 0; t < faces_.size(); ++t) faces_[next[shell_[topology.faces()[t][0]]]++] = t;
  begin_.assign(std::size_t{count} + 1, 0);
  find_borders();
}

void Shells::find_borders() {
  const auto edges = topology_.edges();
  std::vector<std::uint8_t> odd(edges.size(), 0);
  const auto for_each_edge = [&](auto visit) {
    for (Index t = 0; t < topology_.face_count(); ++t) {
      for (int k = 0; k < 3; ++k) {
        const Index edge = topology_.triangle_edges()[t][k];
        if (edge != kNoIndex) visit(edge, topology_.faces()[t][k], topology_.faces()[t][(k + 1) % 3]);
      }
    }
  };
  for_each_edge([&](Index edge, Index, Index) { odd[edge] ^= 1; });
  std::vector<Index> parent(shell_.size());
  std::iota(parent.begin(), parent.end(), Index{0});
  for_each_edge([&](Index edge, Index from, Index to) {
    if (!odd[edge]) return;
    odd[edge] = 0;  // once
    borders_.push_back({from, to, 0});
    unite(parent, from, to);
  });
  for (Border& border : borders_) {
    border.loop = root_of(parent, border.from);
    ++begin_[shell_[border.from] + 1];
  }
  std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
  std::sort(borders_.begin(), borders_.end(), [&](const Border& a, const Border& b) {
    return std::tuple(shell_[a.from], a.loop, a.from, a.to) <
           std::tuple(shell_[b.from], b.loop, b.from, b.to);
  });
}

// The triangles that cover a shell's holes.
template <class Visit>
void Shells::for_each_cap(Index shell, std::span<const double> x, const Visit& visit) const {
  for (std::size_t i = begin_[shell]; i < begin_[shell + 1];) {
    std::size_t end = i;
    Vec3 middle = Vec3::Zero();
    for (; end < begin_[shell + 1] && borders_[end].loop == borders_[i].loop; ++end)
      middle += position(x, borders_[end].from);
    middle /= static_cast<double>(end - i);
    for (; i < end; ++i) visit(position(x, borders_[i].to), position(x, borders_[i].from), middle);
  }
}

double Shells::open_share(Index shell, std::span<const double> x, const Vec3& p) const {
  double sum = 0;
  for_each_cap(shell, x,
               [&](const Vec3& a, const Vec3& b, const Vec3& c) { sum += solid_angle(a - p, b - p, c - p); });
  return std::abs(sum) / (4 * std::numbers::pi);
}

int Shells::outward(Index shell, std::span<const double> x) const {
  double volume = 0;
  std::optional<Vec3> origin;
  const auto add = [&](const Vec3& a, const Vec3& b, const Vec3& c) {
    if (!origin) origin = a;
    volume += (a - *origin).dot((b - *origin).cross(c - *origin));
  };
  for (std::size_t i = faces_begin_[shell]; i < faces_begin_[shell + 1]; ++i) {
    const auto& [p, q, r] = topology_.faces()[faces_[i]];
    add(position(x, p), position(x, q), position(x, r));
  }
  for_each_cap(shell, x, add);
  return volume < 0 ? -1 : 1;
}

}  // namespace foldproof::internal
