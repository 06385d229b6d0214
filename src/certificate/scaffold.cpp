#include "certificate/scaffold.h"

#include <algorithm>
#include <cmath>

namespace foldproof::internal {
namespace {

constexpr std::uint16_t kNone = 0xFFFF;

// Orders directions by their counterclockwise angle from `back`, with `back` itself last.
bool before_counterclockwise(Direction back, Direction a, Direction b) {
  const auto half = [&](Direction d) {
    const std::int64_t side = cross(back, d);
    if (side > 0 || (side == 0 && dot(back, d) < 0)) return 0;
    return side < 0 ? 1 : 2;
  };
  const int ha = half(a), hb = half(b);
  return ha != hb ? ha < hb : cross(a, b) > 0;
}

}  // namespace

// The outline: half-edges without a twin. The patch lies to their left.
bool ScaffoldBuilder::find_outline(const Patch& patch) {
  half_edges_.assign(patch.vertices.size(), patch.triangles);
  edges_.clear();
  first_from_.assign(patch.vertices.size(), kNone);
  for (const auto& t : patch.triangles) {
    for (int k = 0; k < 3; ++k) {
      const std::uint16_t from = t[k], to = t[(k + 1) % 3];
      if (half_edges_.contains(to, from)) continue;
      if (edges_.size() == kNone) return false;
      const auto self = static_cast<std::uint16_t>(edges_.size());
      edges_.push_back({from, to, first_from_[from], false});
      first_from_[from] = self;
    }
  }
  return edges_.size() >= 3;
}

// The next edge of a loop. Where two parts of the patch touch in one vertex, the loop stays outside of both:
// it continues with the first edge counterclockwise from the one it came along.
std::size_t ScaffoldBuilder::next_edge(const Edge& in, const UvMap& uv_map) const {
  std::size_t best = first_from_[in.to];
  if (best == kNone || edges_[best].next_from_same == kNone) return best;
  const auto& uvs = uv_map.uvs;
  const Direction back = uvs[in.from] - uvs[in.to];
  for (std::size_t e = edges_[best].next_from_same; e != kNone; e = edges_[e].next_from_same) {
    if (before_counterclockwise(back, uvs[edges_[e].to] - uvs[in.to], uvs[edges_[best].to] - uvs[in.to])) {
      best = e;
    }
  }
  return best;
}

bool ScaffoldBuilder::trace_loop(std::size_t first, const UvMap& uv_map) {
  loop_.clear();
  for (std::size_t e = first; !edges_[e].visited;) {
    edges_[e].visited = true;
    loop_.push_back(edges_[e].from);
    e = next_edge(edges_[e], uv_map);
    if (e == kNone || (edges_[e].visited && e != first)) return false;
  }
  return true;
}

void ScaffoldBuilder::read_loop_uvs(const UvMap& uv_map) {
  loop_uvs_.clear();
  for (const std::uint16_t v : loop_) loop_uvs_.push_back(uv_map.uvs[v]);
}

void ScaffoldBuilder::remove_from_loop(std::size_t index) {
  loop_.erase(loop_.begin() + static_cast<std::ptrdiff_t>(index));
  loop_uvs_.erase(loop_uvs_.begin() + static_cast<std::ptrdiff_t>(index));
}

// Whether no vertex of the loop, except for the triangle's corners, lies in the triangle or on its sides.
bool ScaffoldBuilder::contains_no_vertex(Uv a, Uv b, Uv c) const {
  const auto [left, right] = std::minmax({a[0], b[0], c[0]});
  const auto [low, high] = std::minmax({a[1], b[1], c[1]});
  for (const Uv p : loop_uvs_) {
    if (p[0] < left || p[0] > right || p[1] < low || p[1] > high || p == a || p == b || p == c) continue;
    if (orient2d(a, b, p) >= 0 && orient2d(b, c, p) >= 0 && orient2d(c, a, p) >= 0) return false;
  }
  return true;
}

// Clips ears at reflex vertices of the outline until none can be clipped.
void ScaffoldBuilder::fill_concavities(UvMap& uv_map) {
  const auto& uvs = uv_map.uvs;
  read_loop_uvs(uv_map);
  std::size_t tested_since_last = 0;
  for (std::size_t i = 0; tested_since_last < loop_.size() && loop_.size() > 3;) {
    const std::size_t n = loop_.size();
    i %= n;
    const std::uint16_t before = loop_[(i + n - 1) % n], v = loop_[i], after = loop_[(i + 1) % n];
    const Uv a = uvs[after], b = uvs[v], c = uvs[before];
    if (orient2d(a, b, c) > 0 && contains_no_vertex(a, b, c)) {
      uv_map.scaffold.push_back({after, v, before});
      remove_from_loop(i);
      i += loop_.size() - 1;  // back to the vertex before
      tested_since_last = 0;
    } else {
      ++i;
      ++tested_since_last;
    }
  }
}

// Advances around the loop and the square together. Each triangle uses the shorter of the two next diagonals.
bool ScaffoldBuilder::join_to_square(UvMap& uv_map) {
  const std::size_t n = loop_.size();
  if (n == 0) return false;  // an outline without sides
  const auto& uvs = uv_map.uvs;
  const auto first_corner = static_cast<std::uint16_t>(uvs.size());
  const auto length = [](Direction d) { return dot(d, d); };
  std::size_t start = 0;
  for (std::size_t i = 1; i < n; ++i) {
    if (length(uvs[loop_[i]] - kChartCorners[0]) < length(uvs[loop_[start]] - kChartCorners[0])) start = i;
  }
  std::size_t inner = 0, outer = 0;
  while (inner < n || outer < 4) {
    const std::uint16_t p = loop_[(start + inner) % n], q = loop_[(start + inner + 1) % n];
    const auto corner = static_cast<std::uint16_t>(first_corner + outer % 4),
               next = static_cast<std::uint16_t>(first_corner + (outer + 1) % 4);
    const Uv corner_uv = kChartCorners[outer % 4], next_uv = kChartCorners[(outer + 1) % 4];
    const bool inner_fits = inner < n && orient2d(uvs[q], uvs[p], corner_uv) > 0;
    // The diagonal to the next corner stays outside of the loop if that corner sees the loop's next edge.
    const bool outer_fits = outer < 4 && orient2d(uvs[p], corner_uv, next_uv) > 0 &&
                            (inner == n || orient2d(uvs[q], uvs[p], next_uv) > 0);
    if (!inner_fits && !outer_fits) return false;
    if (inner_fits && (!outer_fits || length(corner_uv - uvs[q]) <= length(next_uv - uvs[p]))) {
      uv_map.scaffold.push_back({q, p, corner});
      ++inner;
    } else {
      uv_map.scaffold.push_back({p, corner, next});
      ++outer;
    }
  }
  return true;
}

// Clips ears, the roundest triangle first.
bool ScaffoldBuilder::fill_hole(UvMap& uv_map) {
  const auto& uvs = uv_map.uvs;
  std::reverse(loop_.begin(), loop_.end());
  read_loop_uvs(uv_map);
  while (loop_.size() >= 3) {
    const std::size_t n = loop_.size();
    std::size_t best = n;
    double best_shape = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const Uv a = uvs[loop_[(i + n - 1) % n]], b = uvs[loop_[i]], c = uvs[loop_[(i + 1) % n]];
      const double shape =
          static_cast<double>(orient2d(a, b, c)) /
          static_cast<double>(std::max({dot(b - a, b - a), dot(c - b, c - b), dot(a - c, a - c)}));
      if (shape <= best_shape || !contains_no_vertex(a, b, c)) continue;
      best = i;
      best_shape = shape;
    }
    if (best == n) return false;
    uv_map.scaffold.push_back({loop_[(best + n - 1) % n], loop_[best], loop_[(best + 1) % n]});
    remove_from_loop(best);
  }
  return true;
}

// Flips the common edge of two scaffold triangles if it violates the Delaunay condition. Either diagonal
// gives a valid chart, so doubles suffice.
bool ScaffoldBuilder::flip(UvMap& uv_map, std::uint32_t half_edge) {
  const std::uint32_t twin = twin_[half_edge];
  if (twin == kNoHalfEdge) return false;
  const auto after = [](std::uint32_t h) { return h % 3 == 2 ? h - 2 : h + 1; };
  const auto first_vertex = [&](std::uint32_t h) { return uv_map.scaffold[h / 3][h % 3]; };
  const std::uint32_t own1 = after(half_edge), own2 = after(own1), twin1 = after(twin), twin2 = after(twin1);
  const std::uint16_t from = first_vertex(half_edge), to = first_vertex(own1), c = first_vertex(own2),
                      d = first_vertex(twin2);
  const auto uv = [&](std::uint16_t v) {
    return v < uv_map.uvs.size() ? uv_map.uvs[v] : kChartCorners[v - uv_map.uvs.size()];
  };
  const Uv pa = uv(from), pb = uv(to), pc = uv(c), pd = uv(d);
  if (orient2d(pc, pa, pd) <= 0 || orient2d(pd, pb, pc) <= 0) return false;
  const Direction ca = pa - pc, cb = pb - pc, da = pa - pd, db = pb - pd;
  const auto real = [](std::int64_t i) { return static_cast<double>(i); };
  const double in_circle = real(dot(ca, cb)) * real(cross(da, db)) - real(cross(ca, cb)) * real(dot(da, db));
  if (!(in_circle > 1e-9 * std::abs(real(dot(ca, cb)) * real(cross(da, db))))) return false;
  const std::uint32_t left = half_edge / 3, right = twin / 3;
  const std::array<std::uint32_t, 2> around_left{twin_[own2], twin_[twin1]},
      around_right{twin_[twin2], twin_[own1]};
  uv_map.scaffold[left] = {c, from, d};
  uv_map.scaffold[right] = {d, to, c};
  const auto join = [&](std::uint32_t a, std::uint32_t b) {
    twin_[a] = b;
    if (b != kNoHalfEdge) twin_[b] = a;
  };
  join(3 * left + 2, 3 * right + 2);
  for (std::uint32_t k = 0; k < 2; ++k) join(3 * left + k, around_left[k]);
  for (std::uint32_t k = 0; k < 2; ++k) join(3 * right + k, around_right[k]);
  to_check_.insert(to_check_.end(), {3 * left, 3 * left + 1, 3 * right, 3 * right + 1});
  return true;
}

// Pairs half-edges between the same two vertices. Where there are more than two, the pairing is arbitrary:
// such a scaffold is not valid anyway.
void ScaffoldBuilder::find_twins(const UvMap& uv_map) {
  const auto count = static_cast<std::uint32_t>(3 * uv_map.scaffold.size());
  twin_.assign(count, kNoHalfEdge);
  next_half_edge_.resize(count);
  first_half_edge_.assign(uv_map.uvs.size() + kChartCorners.size(), kNoHalfEdge);
  to_check_.clear();
  for (std::uint32_t h = 0; h < count; ++h) {
    const auto& t = uv_map.scaffold[h / 3];
    const std::uint16_t from = t[h % 3], to = t[(h + 1) % 3];
    next_half_edge_[h] = first_half_edge_[from];
    first_half_edge_[from] = h;
    for (std::uint32_t other = first_half_edge_[to]; other != kNoHalfEdge; other = next_half_edge_[other]) {
      if (uv_map.scaffold[other / 3][(other + 1) % 3] != from || twin_[other] != kNoHalfEdge) continue;
      twin_[other] = h;
      twin_[h] = other;
      to_check_.push_back(h);
      break;
    }
  }
}

// Makes the scaffold a constrained Delaunay triangulation, whose triangles are rounder, by Lawson's flips.
void ScaffoldBuilder::make_delaunay(UvMap& uv_map) {
  find_twins(uv_map);
  std::size_t flips_left = 4 * uv_map.scaffold.size();
  while (!to_check_.empty() && flips_left > 0) {
    const std::uint32_t half_edge = to_check_.back();
    to_check_.pop_back();
    flips_left -= flip(uv_map, half_edge);
  }
}

bool ScaffoldBuilder::build(const Patch& patch, UvMap& uv_map) {
  if (!find_outline(patch)) return false;
  const auto& uvs = uv_map.uvs;
  std::uint16_t leftmost = edges_[0].from;
  for (const Edge& e : edges_) {
    if (uvs[e.from] < uvs[leftmost]) leftmost = e.from;
  }
  // The outer loop: it reaches the leftmost vertex from the left, outside of the patch.
  std::size_t first = first_from_[leftmost];
  for (std::size_t e = first; e != kNone; e = edges_[e].next_from_same) {
    if (before_counterclockwise({-1, 0}, uvs[edges_[e].to] - uvs[leftmost],
                                uvs[edges_[first].to] - uvs[leftmost])) {
      first = e;
    }
  }
  if (!trace_loop(first, uv_map)) return false;
  fill_concavities(uv_map);
  if (!join_to_square(uv_map)) return false;
  for (std::size_t e = 0; e < edges_.size(); ++e) {
    if (!edges_[e].visited && (!trace_loop(e, uv_map) || !fill_hole(uv_map))) return false;
  }
  make_delaunay(uv_map);
  return true;
}

}  // namespace foldproof::internal
