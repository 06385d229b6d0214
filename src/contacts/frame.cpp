#include "contacts/frame.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "check/triangles_cross.h"

namespace foldproof::internal {
namespace {

constexpr std::uint8_t kUnknown = 2;
constexpr std::size_t kKnown = 16;  // points that bound all depths at first
constexpr std::size_t kAll = std::numeric_limits<std::size_t>::max();

bool contains(std::span<const Index> sorted, Index id) {
  return std::binary_search(sorted.begin(), sorted.end(), id);
}

// A point of one of two triangles that touch where they do: a corner's nearest point.
Vec3 touching_point(const std::array<Vec3, 3>& s, const std::array<Vec3, 3>& t) {
  Vec3 best = s[0];
  double least = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 6; ++k) {
    const Vec3& corner = k < 3 ? s[k] : t[k - 3];
    const Vec3 p = nearest_on_triangle(corner, k < 3 ? t : s);
    if ((p - corner).squaredNorm() < least) least = (p - corner).squaredNorm(), best = p;
  }
  return best;
}

}  // namespace

void FrameMeasurer::begin_marks(Index object) {
  const std::size_t count = surfaces_.topology(object).triangles().size();
  if (seen_.size() < count) seen_.resize(count, 0);
  if (++now_ == 0) std::fill(seen_.begin(), seen_.end(), 0), now_ = 1;
}

// The triangles of a side, ascending.
void FrameMeasurer::list_triangles(std::span<const CrossingPair> pairs, int side, std::vector<Index>& out) {
  out.clear();
  begin_marks(objects_[side]);
  for (const CrossingPair& pair : pairs) {
    const Index t = pair.triangle(side);
    if (seen_[t] != now_) out.push_back(t);
    seen_[t] = now_;
  }
  std::sort(out.begin(), out.end());
}

// What is inside: vertices and pieces of edges.
void FrameMeasurer::list_inner_points(const Region& region, Index object, Positions x) {
  constexpr int kSplits = 3;  // the ends of a piece are on curves: of the rest, the points at each 16th
  points_.clear();
  // What may be deepest comes first: points that are less deep are then ruled out quickly.
  if (region.last != kNoIndex) points_.push_back({position(x[object], region.last)});
  for (const Index v : region.vertices) points_.push_back({position(x[object], v)});
  const bool few = region.vertices.size() <= Region::kFew;
  for (const auto& [from, to] : region.pieces) {
    const Vec3 half = few ? (to - from) / 2 : Vec3::Zero();
    points_.push_back({from + (to - from) / 2, half, few ? kSplits : 0});
  }
}

// Adds to other_ what is connected to it and not farther from a point, but for what is skipped; the nearest
// along the surface, as many as `most` in all.
template <class Skip>
void FrameMeasurer::add_near(Index object, Positions x, const Vec3& point, double distance, std::size_t most,
                             const Skip& skip) {
  const auto triangles = surfaces_.topology(object).triangles();
  const Vec3 low = point - Vec3::Constant(distance), high = point + Vec3::Constant(distance);
  const auto is_near = [&](Index t) {
    const auto c = corners(x[object], triangles[t]);
    for (int axis = 0; axis < 3; ++axis) {
      const auto [least, largest] = std::minmax({c[0][axis], c[1][axis], c[2][axis]});
      if (!(least <= high[axis] && largest >= low[axis])) return false;
    }
    return true;
  };
  begin_marks(object);
  for (const Index t : other_) seen_[t] = now_;
  for (std::size_t i = 0; i < other_.size() && other_.size() < most; ++i) {
    for (const Index v : triangles[other_[i]]) {
      for (const Index t : surfaces_.triangles_at(object, v)) {
        if (!surfaces_.is_face(object, t)) break;  // faces come first
        if (seen_[t] == now_) continue;
        seen_[t] = now_;
        if (is_near(t) && !skip(t)) other_.push_back(t);
      }
    }
  }
}

// Adds the corners of other_, from `begin` on.
void FrameMeasurer::add_corners(Index object, Positions x, std::size_t begin) {
  const auto triangles = surfaces_.topology(object).triangles();
  for (std::size_t i = begin; i < other_.size(); ++i)
    other_corners_.push_back(corners(x[object], triangles[other_[i]]));
}

// Raises `most` to the point of `points` that is farthest from the triangles, if one is farther; known_ are
// some of the triangles' points. Uses points up.
void FrameMeasurer::raise_to_farthest(std::vector<InnerPoint>& points, Deepest& most) {
  constexpr int kRounds = 64;  // then those that remain are about equally deep, and all of them are asked for
  std::size_t first = 0;
  double square = *most.depth * *most.depth;
  // No point is farther than any point of the triangles is; of a piece, one of the ends is farthest from it.
  const auto lower_bound = [&](InnerPoint& p) {
    for (std::size_t i = first; i < known_.size(); ++i) {
      const Vec3 way = known_[i] - p.middle;
      const double bound = way.squaredNorm() + p.half.squaredNorm() + 2 * std::abs(way.dot(p.half));
      if (bound < p.bound) p.bound = bound, p.nearest = static_cast<Index>(i);
    }
  };
  for (int round = 0; !points.empty(); ++round) {
    if (round < kRounds) {
      std::size_t count = 0, farthest = 0;
      for (std::size_t i = 0; i < points.size(); ++i) {
        lower_bound(points[i]);
        if (points[i].bound <= square) continue;
        points[count] = points[i];
        if (points[count].bound > points[farthest].bound) farthest = count;
        ++count;
      }
      points.resize(count);
      if (points.empty()) return;
      std::swap(points[farthest], points.back());
      first = known_.size();
    } else {
      first = known_.size() - 1;
      lower_bound(points.back());
    }
    const InnerPoint p = points.back();
    points.pop_back();
    if (p.bound <= square) continue;
    known_.push_back(nearest_.nearest(p.middle, known_[p.nearest]));
    const double distance2 = (known_.back() - p.middle).squaredNorm();
    if (distance2 > square) {
      square = distance2;
      most = {std::sqrt(square), p.middle, known_.back()};
    }
    for (int k = 0; k < 2 && p.splits > 0; ++k) {
      const Vec3 half = p.splits > 1 ? p.half / 2 : Vec3::Zero();
      points.push_back({p.middle + (k - 0.5) * p.half, half, p.splits - 1, p.nearest, p.bound});
    }
  }
}

// Raises the depth to the largest distance of points_ to other_corners_, or to the surface around: what is
// connected to other_, whose corners are those at first.
template <class Skip>
void FrameMeasurer::raise_depth_around(Index object, Positions x, std::size_t most, const Skip& skip) {
  if (points_.empty() || other_corners_.empty()) return;
  known_.clear();
  for (std::size_t i = 0; i < outside_; i += 1 + outside_ / kKnown) known_.push_back(other_corners_[i][0]);
  while (true) {
    // No point is deeper than the farthest from other_corners_. It is the deepest, unless more is near it.
    nearest_.set(other_corners_);
    Deepest bound = deepest_;
    left_ = points_;
    raise_to_farthest(left_, bound);
    if (*bound.depth <= *deepest_.depth) return;
    const std::size_t triangles = other_.size(), corners = other_corners_.size();
    add_near(object, x, bound.point, *bound.depth, most, skip);
    add_corners(object, x, triangles);
    Deepest found = bound;
    for (std::size_t i = corners; i < other_corners_.size(); ++i) {
      const Vec3 p = nearest_on_triangle(bound.point, other_corners_[i]);
      const double distance = (p - bound.point).norm();
      if (distance < *found.depth) found = {distance, bound.point, p};
    }
    if (*found.depth > *deepest_.depth) deepest_ = found;
    if (*found.depth == *bound.depth) return;
    known_.push_back(found.nearest);
  }
}

// The faces of a side that cross, as other_.
void FrameMeasurer::begin_other(int side) {
  other_ = crossing_[side];
  std::erase_if(other_, [&](Index t) { return !surfaces_.is_face(objects_[side], t); });
  other_corners_.clear();
}

// The same for the other surface around what crosses.
void FrameMeasurer::raise_depth_around(int side, Positions x, bool all) {
  const Index object = objects_[1 - side];
  const bool within = objects_[0] == objects_[1];
  begin_other(1 - side);
  if (region_[1 - side]) {
    begin_marks(object);
    for (const Index t : other_) seen_[t] = now_;
    for (const Index t : region_[1 - side]->triangles) {
      if (seen_[t] != now_) other_.push_back(t);
    }
  }
  add_corners(object, x, 0);
  outside_ = other_corners_.size();
  raise_depth_around(object, x, all ? kAll : 2 * other_.size() + 256, [&](Index t) {
    return within &&
           (contains(crossing_[side], t) || (region_[side] && contains(region_[side]->triangles, t)));
  });
}

void FrameMeasurer::find_deepest(int side, Positions x) {
  list_inner_points(*region_[side], objects_[side], x);
  if (!deepest_.depth) deepest_.depth = 0;
  if (points_.empty()) return;
  raise_depth_around(side, x, true);
}

// Of a surface that goes into itself, what is nearest is the rest of it: what is outside.
void FrameMeasurer::find_deepest_of_body(Positions x) {
  list_inner_points(*body_, body_query_.object, x);
  if (points_.empty()) return;
  deepest_.depth = 0;
  other_ = body_cut_;
  other_corners_.clear();
  for (const Curves::Segment& segment : curves_.segments) {
    const Vec3 &p = curves_.piercings[segment.ends[0]].position,
               &q = curves_.piercings[segment.ends[1]].position;
    other_corners_.push_back({p, q, q});
  }
  // Of a triangle that is cut, the nearest point is where it was found, if that is outside, or else on an
  // edge or a curve.
  for (const Index t : body_cut_) regions_.add_outer_pieces(t, x, other_corners_);
  const std::size_t begin = other_corners_.size();
  outside_ = begin;
  add_corners(body_query_.object, x, 0);
  nearest_.counts = [&](std::size_t i, const Vec3& p) {
    return i < begin || i - begin >= body_cut_.size() || !regions_.is_inside(body_cut_[i - begin], p, x);
  };
  raise_depth_around(body_query_.object, x, kAll, [&](Index t) { return regions_.reaches_inside(t); });
  nearest_.counts = nullptr;
}

// On which side of its faces a surface is outside: 1 in front, -1 behind, 0 nowhere, as it is open where it
// is crossed.
int FrameMeasurer::front_of(int side, Positions x) const {
  const Index object = objects_[side];
  const Shells& shells = surfaces_.shells(object);
  const Index shell = shells.of(surfaces_.topology(object).triangles()[cut_[side][0]][0]);
  const auto& line = curves_.lines[0];
  // Within faces of both sides: on a border, the share that is open depends on rounding.
  const std::size_t middle = line.size() / 2;
  const Vec3 p = (curves_.piercings[line[middle]].position +
                  curves_.piercings[line[middle > 0 ? middle - 1 : 0]].position) /
                 2;
  constexpr double kMostOpen = 0.25;  // then the winding numbers 3/4 and -1/4 are inside and outside
  if (!shells.is_closed(shell) && !(shells.open_share(shell, x[object], p) < kMostOpen)) return 0;
  return shells.outward(shell, x[object]);
}

void FrameMeasurer::find_regions(bool folded, Positions x) {
  for (int side = 0; side < 2; ++side) {
    region_[side].reset();
    cut_[side] = crossing_[side];
    if (!curves_.as_given) list_triangles(curves_.pairs, side, cut_[side]);
    query_[side] = {objects_[side], {side == 0, side == 1}, cut_[side], 0};
  }
  body_.reset();
  if (curves_.lines.empty()) return;
  const auto shell = [&](int side) {
    const Index vertex = surfaces_.topology(objects_[side]).triangles()[cut_[side][0]][0];
    return surfaces_.shells(objects_[side]).of(vertex);
  };
  const bool one_shell = objects_[0] == objects_[1] && shell(0) == shell(1);
  for (int side = 0; side < 2; ++side) {
    if (folded || (one_shell && !curves_.closed)) continue;
    RegionQuery query = query_[side];
    if (!curves_.closed) {
      query.behind = front_of(1 - side, x);
      if (query.behind == 0) continue;
    }
    region_[side] = regions_.find(curves_, query, x);
  }
  if (!one_shell || curves_.at_borders || region_[0] || region_[1]) return;
  body_cut_.clear();
  std::set_union(cut_[0].begin(), cut_[0].end(), cut_[1].begin(), cut_[1].end(),
                 std::back_inserter(body_cut_));
  body_query_ = {objects_[0], {true, true}, {}, 0};
  body_ = regions_.find(curves_, body_query_, x);
}

// How far the smaller part of a surface reaches beyond the other surface, where neither has an inside.
void FrameMeasurer::find_reach(Positions x) {
  for (int side = 0; side < 2; ++side) {
    region_[side] = regions_.find(curves_, query_[side], x);
    if (region_[side]) find_deepest(side, x);
    region_[side].reset();
  }
  if (deepest_.depth) return;
  for (int side = 0; side < 2; ++side) find_reach_of_tips(side, x);
  // Along the curve they come apart, too.
  if (deepest_.depth) deepest_.depth = std::min(*deepest_.depth, curves_.length);
}

// The same where curves end within both surfaces.
void FrameMeasurer::find_reach_of_tips(int side, Positions x) {
  const auto tips = regions_.find_tips(curves_, query_[side], x);
  const Deepest before = deepest_;
  std::optional<Deepest> least;
  for (const auto& tip : tips) {
    points_.clear();
    for (const Index v : tip) points_.push_back({position(x[objects_[side]], v)});
    if (points_.empty()) continue;
    deepest_.depth = 0;
    raise_depth_around(side, x, false);
    if (!least || *deepest_.depth < *least->depth) least = deepest_;
  }
  deepest_ = least && *least->depth > before.depth.value_or(-1) ? *least : before;
}

// Gives what is inside of a surface that goes into itself to the sides whose cut edges are nearest along it.
void FrameMeasurer::split_body() {
  const Index object = objects_[0];
  const auto triangles = surfaces_.topology(object).triangles();
  side_of_.assign(body_->vertices.size(), kUnknown);
  if (places_.size() < surfaces_.topology(object).vertex_count())
    places_.resize(surfaces_.topology(object).vertex_count());
  for (Index i = 0; i < body_->vertices.size(); ++i) places_[body_->vertices[i]] = i;
  const auto is_in_body = [&](Index v) {
    const Index place = places_[v];
    return place < body_->vertices.size() && body_->vertices[place] == v;
  };
  std::vector<Index> queue;
  const auto take = [&](Index v, int side) {
    if (side_of_[places_[v]] != kUnknown) return;
    side_of_[places_[v]] = static_cast<std::uint8_t>(side);
    queue.push_back(v);
  };
  for (const Piercing& p : curves_.piercings) {
    for (const Index v : p.edge) {
      if (is_in_body(v)) take(v, p.side);
    }
  }
  for (std::size_t i = 0; i < queue.size(); ++i) {
    for (const Index t : surfaces_.triangles_at(object, queue[i])) {
      const Triangle& corners = triangles[t];
      if (!std::all_of(corners.begin(), corners.end(), is_in_body)) continue;
      for (const Index w : corners) take(w, side_of_[places_[queue[i]]]);
    }
  }
  std::vector<Index> crossing;
  std::set_union(crossing_[0].begin(), crossing_[0].end(), crossing_[1].begin(), crossing_[1].end(),
                 std::back_inserter(crossing));
  auto next = crossing.begin();
  for (const Index t : body_->triangles) {
    while (next != crossing.end() && *next < t) ++next;
    if (next == crossing.end() || *next != t)
      inside_[side_of_[places_[triangles[t][0]]] == 1 ? 1 : 0].push_back(t);
  }
}

// Whether nothing is inside, beyond rounding.
void FrameMeasurer::set_touching(ContactFrame& out) {
  // A fold so small that no vertex tells how deep it is.
  if (body_ && deepest_.depth && *deepest_.depth <= curves_.rounding) {
    deepest_.depth.reset();
    body_.reset();
  }
  out.touching = curves_.pierced.empty() &&
                 (curves_.lines.empty() || (deepest_.depth && *deepest_.depth <= curves_.rounding));
  if (!out.touching) return;
  deepest_.depth.reset();
  body_.reset();
  for (auto& region : region_) region.reset();
}

void FrameMeasurer::measure(std::span<const CrossingPair> pairs, bool folded, Positions x,
                            ContactFrame& out) {
  for (int side = 0; side < 2; ++side) {
    objects_[side] = pairs[0].object(side);
    list_triangles(pairs, side, crossing_[side]);
  }
  trace_curves(surfaces_, pairs, x, curves_);
  find_regions(folded, x);
  deepest_ = {};
  for (int side = 0; side < 2; ++side) {
    if (region_[side]) find_deepest(side, x);
  }
  if (body_) find_deepest_of_body(x);
  out.at_least = false;
  if (!deepest_.depth && !curves_.lines.empty()) {
    find_reach(x);
    out.at_least = deepest_.depth.has_value();
  }
  set_touching(out);
  out.at_least &= deepest_.depth.has_value();
  out.depth = deepest_.depth;
  out.crossings = pairs.size();
  out.triangles = 0;
  out.curve_length = curves_.length;
  out.closed = curves_.closed;
  for (auto& triangles : inside_) triangles.clear();
  if (body_) split_body();
  for (int side = 0; side < 2; ++side) {
    out.area[side].reset();
    if (region_[side]) {
      out.area[side] = region_[side]->area;
      std::set_difference(region_[side]->triangles.begin(), region_[side]->triangles.end(),
                          crossing_[side].begin(), crossing_[side].end(), std::back_inserter(inside_[side]));
    }
    out.triangles += crossing_[side].size() + inside_[side].size();
  }
}

// A point of the curves, or of what touches, in the middle.
Vec3 FrameMeasurer::middle_of_curves(std::span<const CrossingPair> pairs, Positions x) const {
  std::vector<Vec3> points = curves_.pierced;
  for (const auto& line : curves_.lines) {
    for (const Index n : line) points.push_back(curves_.piercings[n].position);
  }
  for (std::size_t i = 0; i < pairs.size() && curves_.lines.empty() && curves_.pierced.empty(); ++i) {
    const auto at = [&](int side) {
      const Index object = pairs[i].object(side);
      return corners(x[object], surfaces_.topology(object).triangles()[pairs[i].triangle(side)]);
    };
    points.push_back(touching_point(at(0), at(1)));
  }
  Vec3 middle = Vec3::Zero();
  for (const Vec3& p : points) middle += p / static_cast<double>(points.size());
  const auto distance = [&](const Vec3& p) { return (p - middle).squaredNorm(); };
  return *std::min_element(points.begin(), points.end(),
                           [&](const Vec3& p, const Vec3& q) { return distance(p) < distance(q); });
}

void FrameMeasurer::describe(std::span<const CrossingPair> pairs, Positions x, Contact& out) const {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (int side = 0; side < 2; ++side) {
    Contact::Side& to = out.sides[side];
    to.inside = inside_[side];
    to.triangles.clear();
    std::merge(crossing_[side].begin(), crossing_[side].end(), to.inside.begin(), to.inside.end(),
               std::back_inserter(to.triangles));
    for (const Index t : to.triangles) {
      for (const Vec3& v : corners(x[objects_[side]], surfaces_.topology(objects_[side]).triangles()[t]))
        low = low.cwiseMin(v), high = high.cwiseMax(v);
    }
  }
  out.low = low;
  out.high = high;
  out.curves.clear();
  for (const auto& line : curves_.lines) {
    auto& points = out.curves.emplace_back();
    for (const Index n : line) points.push_back(curves_.piercings[n].position);
  }
  Vec3 normal = Vec3::Zero();
  if (deepest_.depth && *deepest_.depth > 0) {
    out.point = deepest_.point;
    normal = deepest_.point - deepest_.nearest;
  } else {
    out.point = middle_of_curves(pairs, x);
    for (const CrossingPair& pair : pairs) {
      for (int side = 0; side < 2; ++side) {
        const Index object = pair.object(side);
        const auto c = corners(x[object], surfaces_.topology(object).triangles()[pair.triangle(side)]);
        normal += (side == 0 ? -1 : 1) * (c[1] - c[0]).cross(c[2] - c[0]).normalized();
      }
    }
  }
  out.normal = normal.normalized();
}

}  // namespace foldproof::internal
