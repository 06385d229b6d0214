#include "certificate/outline.h"

#include <algorithm>
#include <cmath>

namespace foldproof {
namespace {

constexpr std::uint16_t kNone = 0xFFFF;

// Orders directions by the angle counterclockwise from `back`, with `back` itself last.
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

// Edges of one triangle only; the patch lies to their left.
bool OutlineFiller::find_outline(const Patch& patch) {
  sides_.list(patch.vertices.size(), patch.triangles);
  edges_.clear();
  first_from_.assign(patch.vertices.size(), kNone);
  for (const auto& t : patch.triangles) {
    for (int k = 0; k < 3; ++k) {
      const std::uint16_t from = t[k], to = t[(k + 1) % 3];
      if (sides_.contains(to, from)) continue;
      if (edges_.size() == kNone) return false;
      const auto self = static_cast<std::uint16_t>(edges_.size());
      edges_.push_back({from, to, first_from_[from], false});
      first_from_[from] = self;
    }
  }
  return edges_.size() >= 3;
}

// Where two parts of the patch touch in one vertex, the walk stays outside: it takes the first edge that it
// meets when it turns counterclockwise from where it came.
std::size_t OutlineFiller::next_edge(const Edge& in, const Drawing& drawing) const {
  std::size_t best = first_from_[in.to];
  if (best == kNone || edges_[best].next_from_same == kNone) return best;
  const auto& places = drawing.places;
  const Direction back = places[in.from] - places[in.to];
  for (std::size_t e = edges_[best].next_from_same; e != kNone; e = edges_[e].next_from_same) {
    if (before_counterclockwise(back, places[edges_[e].to] - places[in.to],
                                places[edges_[best].to] - places[in.to])) {
      best = e;
    }
  }
  return best;
}

bool OutlineFiller::walk(std::size_t first, const Drawing& drawing) {
  loop_.clear();
  for (std::size_t e = first; !edges_[e].walked;) {
    edges_[e].walked = true;
    loop_.push_back(edges_[e].from);
    e = next_edge(edges_[e], drawing);
    if (e == kNone || (edges_[e].walked && e != first)) return false;
  }
  return true;
}

void OutlineFiller::place_loop(const Drawing& drawing) {
  loop_places_.clear();
  for (const std::uint16_t v : loop_) loop_places_.push_back(drawing.places[v]);
}

void OutlineFiller::drop(std::size_t from_loop) {
  loop_.erase(loop_.begin() + static_cast<std::ptrdiff_t>(from_loop));
  loop_places_.erase(loop_places_.begin() + static_cast<std::ptrdiff_t>(from_loop));
}

// Whether no vertex of the loop lies in a triangle, its border included, but for its own corners.
bool OutlineFiller::is_empty(Place a, Place b, Place c) const {
  const auto [left, right] = std::minmax({a[0], b[0], c[0]});
  const auto [low, high] = std::minmax({a[1], b[1], c[1]});
  for (const Place p : loop_places_) {
    if (p[0] < left || p[0] > right || p[1] < low || p[1] > high || p == a || p == b || p == c) continue;
    if (turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0) return false;
  }
  return true;
}

// Cuts off vertices where the outline turns in, until it does so nowhere.
void OutlineFiller::fill_bays(Drawing& drawing) {
  const auto& places = drawing.places;
  place_loop(drawing);
  std::size_t since_last = 0;
  for (std::size_t i = 0; since_last < loop_.size() && loop_.size() > 3;) {
    const std::size_t n = loop_.size();
    i %= n;
    const std::uint16_t before = loop_[(i + n - 1) % n], v = loop_[i], after = loop_[(i + 1) % n];
    const Place a = places[after], b = places[v], c = places[before];
    if (turn(a, b, c) > 0 && is_empty(a, b, c)) {
      drawing.fillers.push_back({after, v, before});
      drop(i);
      i += loop_.size() - 1;  // look at the vertex before again
      since_last = 0;
    } else {
      ++i;
      ++since_last;
    }
  }
}

// Goes round the loop and the square at once and joins them by the shorter of the two next diagonals.
bool OutlineFiller::join_square(Drawing& drawing) {
  const std::size_t n = loop_.size();
  if (n == 0) return false;  // an outline without sides
  const auto& places = drawing.places;
  const auto first_corner = static_cast<std::uint16_t>(places.size());
  const auto length = [](Direction d) { return dot(d, d); };
  std::size_t start = 0;
  for (std::size_t i = 1; i < n; ++i) {
    if (length(places[loop_[i]] - kChartCorners[0]) < length(places[loop_[start]] - kChartCorners[0]))
      start = i;
  }
  std::size_t inner = 0, outer = 0;
  while (inner < n || outer < 4) {
    const std::uint16_t p = loop_[(start + inner) % n], q = loop_[(start + inner + 1) % n];
    const auto corner = static_cast<std::uint16_t>(first_corner + outer % 4),
               next = static_cast<std::uint16_t>(first_corner + (outer + 1) % 4);
    const Place at = kChartCorners[outer % 4], then = kChartCorners[(outer + 1) % 4];
    const bool inner_fits = inner < n && turn(places[q], places[p], at) > 0;
    // The diagonal to the next corner stays outside when that corner sees the loop's next side.
    const bool outer_fits =
        outer < 4 && turn(places[p], at, then) > 0 && (inner == n || turn(places[q], places[p], then) > 0);
    if (!inner_fits && !outer_fits) return false;
    if (inner_fits && (!outer_fits || length(at - places[q]) <= length(then - places[p]))) {
      drawing.fillers.push_back({q, p, corner});
      ++inner;
    } else {
      drawing.fillers.push_back({p, corner, next});
      ++outer;
    }
  }
  return true;
}

// Cuts the vertices of a hole off one by one, the thickest triangle first.
bool OutlineFiller::fill_hole(Drawing& drawing) {
  const auto& places = drawing.places;
  std::reverse(loop_.begin(), loop_.end());
  place_loop(drawing);
  while (loop_.size() >= 3) {
    const std::size_t n = loop_.size();
    std::size_t best = n;
    double best_shape = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const Place a = places[loop_[(i + n - 1) % n]], b = places[loop_[i]], c = places[loop_[(i + 1) % n]];
      const double shape =
          static_cast<double>(turn(a, b, c)) /
          static_cast<double>(std::max({dot(b - a, b - a), dot(c - b, c - b), dot(a - c, a - c)}));
      if (shape <= best_shape || !is_empty(a, b, c)) continue;
      best = i;
      best_shape = shape;
    }
    if (best == n) return false;
    drawing.fillers.push_back({loop_[(best + n - 1) % n], loop_[best], loop_[(best + 1) % n]});
    drop(best);
  }
  return true;
}

// Turns the diagonal of two fillers round when d lies in the circle through a, b and c, which makes them
// thicker. Which one it is decides nothing but how much the chart will prove, so doubles do.
bool OutlineFiller::flip(Drawing& drawing, std::uint32_t side) {
  const std::uint32_t across = opposite_[side];
  if (across == kNobody) return false;
  const auto after = [](std::uint32_t s) { return s % 3 == 2 ? s - 2 : s + 1; };
  const auto corner = [&](std::uint32_t s) { return drawing.fillers[s / 3][s % 3]; };
  const std::uint32_t side1 = after(side), side2 = after(side1), across1 = after(across),
                      across2 = after(across1);
  const std::uint16_t from = corner(side), to = corner(side1), c = corner(side2), d = corner(across2);
  const auto place = [&](std::uint16_t v) {
    return v < drawing.places.size() ? drawing.places[v] : kChartCorners[v - drawing.places.size()];
  };
  const Place pa = place(from), pb = place(to), pc = place(c), pd = place(d);
  if (turn(pc, pa, pd) <= 0 || turn(pd, pb, pc) <= 0) return false;
  const Direction ca = pa - pc, cb = pb - pc, da = pa - pd, db = pb - pd;
  const auto real = [](std::int64_t i) { return static_cast<double>(i); };
  const double in_circle = real(dot(ca, cb)) * real(cross(da, db)) - real(cross(ca, cb)) * real(dot(da, db));
  if (!(in_circle > 1e-9 * std::abs(real(dot(ca, cb)) * real(cross(da, db))))) return false;
  const std::uint32_t left = side / 3, right = across / 3;
  const std::array<std::uint32_t, 2> around_left{opposite_[side2], opposite_[across1]},
      around_right{opposite_[across2], opposite_[side1]};
  drawing.fillers[left] = {c, from, d};
  drawing.fillers[right] = {d, to, c};
  const auto join = [&](std::uint32_t a, std::uint32_t b) {
    opposite_[a] = b;
    if (b != kNobody) opposite_[b] = a;
  };
  join(3 * left + 2, 3 * right + 2);
  for (std::uint32_t k = 0; k < 2; ++k) join(3 * left + k, around_left[k]);
  for (std::uint32_t k = 0; k < 2; ++k) join(3 * right + k, around_right[k]);
  suspects_.insert(suspects_.end(), {3 * left, 3 * left + 1, 3 * right, 3 * right + 1});
  return true;
}

// Two sides between the same vertices have each other; of more than two, whatever the last ones make of it:
// such fillers are no chart.
void OutlineFiller::find_opposites(const Drawing& drawing) {
  const auto sides = static_cast<std::uint32_t>(3 * drawing.fillers.size());
  opposite_.assign(sides, kNobody);
  next_side_.resize(sides);
  first_side_.assign(drawing.places.size() + kChartCorners.size(), kNobody);
  suspects_.clear();
  for (std::uint32_t side = 0; side < sides; ++side) {
    const auto& t = drawing.fillers[side / 3];
    const std::uint16_t from = t[side % 3], to = t[(side + 1) % 3];
    next_side_[side] = first_side_[from];
    first_side_[from] = side;
    for (std::uint32_t s = first_side_[to]; s != kNobody; s = next_side_[s]) {
      if (drawing.fillers[s / 3][(s + 1) % 3] != from || opposite_[s] != kNobody) continue;
      opposite_[s] = side;
      opposite_[side] = s;
      suspects_.push_back(side);
      break;
    }
  }
}

// Makes the triangulation of what lies outside of the patch Delaunay, as far as the patch lets it (Lawson's
// flips).
void OutlineFiller::fatten(Drawing& drawing) {
  find_opposites(drawing);
  std::size_t flips_left = 4 * drawing.fillers.size();
  while (!suspects_.empty() && flips_left > 0) {
    const std::uint32_t side = suspects_.back();
    suspects_.pop_back();
    flips_left -= flip(drawing, side);
  }
}

bool OutlineFiller::fill(const Patch& patch, Drawing& drawing) {
  if (!find_outline(patch)) return false;
  const auto& places = drawing.places;
  std::uint16_t leftmost = edges_[0].from;
  for (const Edge& e : edges_) {
    if (places[e.from] < places[leftmost]) leftmost = e.from;
  }
  // As if the walk came down to the leftmost vertex from above, outside of everything.
  std::size_t first = first_from_[leftmost];
  for (std::size_t e = first; e != kNone; e = edges_[e].next_from_same) {
    if (before_counterclockwise({-1, 0}, places[edges_[e].to] - places[leftmost],
                                places[edges_[first].to] - places[leftmost])) {
      first = e;
    }
  }
  if (!walk(first, drawing)) return false;
  fill_bays(drawing);
  if (!join_square(drawing)) return false;
  for (std::size_t e = 0; e < edges_.size(); ++e) {
    if (!edges_[e].walked && (!walk(e, drawing) || !fill_hole(drawing))) return false;
  }
  fatten(drawing);
  return true;
}

}  // namespace foldproof
