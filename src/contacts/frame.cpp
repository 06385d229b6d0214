#include "contacts/frame.h"

#include <algorithm>
#include <cmath>

#include "check/triangles_cross.h"

namespace foldproof::internal {
namespace {

void sort_unique(std::vector<Index>& ids) {
  std::sort(ids.begin(), ids.end());
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
}

bool contains(std::span<const Index> sorted, Index id) {
  return std::binary_search(sorted.begin(), sorted.end(), id);
}

}  // namespace

// The points of a side that are inside: vertices, and the middles of pieces of edges whose ends are outside.
void FrameMeasurer::list_inner_points(int side, Positions x) {
  points_.clear();
  const auto object_x = x[objects_[side]];
  for (const Index v : region_[side]->vertices) points_.push_back(position(object_x, v));
  const auto& all = curves_.piercings;
  for (std::size_t i = 0; i < all.size();) {
    std::size_t end = i + 1;
    while (end < all.size() && all[end].side == all[i].side && all[end].edge == all[i].edge) ++end;
    if (all[i].side == side && (end - i) % 2 == 0 && !contains(region_[side]->vertices, all[i].edge[0])) {
      std::vector<double> shares;
      for (std::size_t k = i; k < end; ++k) shares.push_back(all[k].share);
      std::sort(shares.begin(), shares.end());
      const Vec3 p = position(object_x, all[i].edge[0]), q = position(object_x, all[i].edge[1]);
      for (std::size_t k = 0; k + 1 < shares.size(); k += 2)
        points_.push_back(p + (shares[k] + shares[k + 1]) / 2 * (q - p));
    }
    i = end;
  }
}

// The other surface near what is inside: its region where that is known, else what lies around the inner
// points.
void FrameMeasurer::list_other_surface(int side, Positions x) {
  const int other = 1 - side;
  const Index object = objects_[other];
  const auto triangles = surfaces_.topology(object).triangles();
  other_ = crossing_[other];
  std::erase_if(other_, [&](Index t) { return !surfaces_.is_face(object, t); });
  if (region_[other]) {
    other_.insert(other_.end(), region_[other]->triangles.begin(), region_[other]->triangles.end());
  } else {
    Vec3 low = points_[0], high = points_[0];
    for (const Vec3& p : points_) low = low.cwiseMin(p), high = high.cwiseMax(p);
    const Vec3 around = Vec3::Constant((high - low).norm() / 2);
    low -= around, high += around;
    const auto is_near = [&](Index t) {
      const auto c = corners(x[object], triangles[t]);
      for (int axis = 0; axis < 3; ++axis) {
        const auto [least, largest] = std::minmax({c[0][axis], c[1][axis], c[2][axis]});
        if (!(least <= high[axis] && largest >= low[axis])) return false;
      }
      return true;
    };
    const bool within = objects_[0] == objects_[1];
    if (seen_.size() < triangles.size()) seen_.resize(triangles.size(), 0);
    if (++now_ == 0) std::fill(seen_.begin(), seen_.end(), 0), now_ = 1;
    for (const Index t : other_) seen_[t] = now_;
    for (std::size_t i = 0; i < other_.size(); ++i) {
      for (const Index v : triangles[other_[i]]) {
        for (const Index t : surfaces_.triangles_at(object, v)) {
          if (!surfaces_.is_face(object, t)) break;  // faces come first
          if (seen_[t] == now_) continue;
          seen_[t] = now_;
          if (!is_near(t)) continue;
          if (within && (contains(crossing_[side], t) || contains(region_[side]->triangles, t))) continue;
          other_.push_back(t);
        }
      }
    }
  }
  sort_unique(other_);
  other_corners_.clear();
  for (const Index t : other_) other_corners_.push_back(corners(x[object], triangles[t]));
}

// Raises the depth to the largest distance of an inner point to the other surface.
void FrameMeasurer::find_deepest(int side, Positions x) {
  list_inner_points(side, x);
  if (!depth_) depth_ = 0;
  if (points_.empty()) return;
  list_other_surface(side, x);
  tree_.build(other_corners_);
  if (tree_.empty()) return;
  // A point cannot be deeper than its distance to any point of the other surface: the nearest one of the last
  // point.
  Vec3 known = other_corners_[0][0];
  for (const Vec3& p : points_) {
    if ((known - p).norm() <= *depth_) continue;
    known = tree_.nearest(p, known);
    const double distance = (known - p).norm();
    if (distance <= *depth_) continue;
    depth_ = distance;
    deepest_ = p;
    nearest_ = known;
  }
}

void FrameMeasurer::measure(std::span<const CrossingPair> pairs, bool folded, Positions x,
                            ContactFrame& out) {
  for (int side = 0; side < 2; ++side) {
    objects_[side] = pairs[0].object(side);
    crossing_[side].clear();
    for (const CrossingPair& pair : pairs) crossing_[side].push_back(pair.triangle(side));
    sort_unique(crossing_[side]);
    region_[side].reset();
  }
  trace_curves(surfaces_, pairs, x, curves_);
  depth_.reset();
  deepest_ = nearest_ = Vec3::Zero();
  for (int side = 0; side < 2 && !folded; ++side) {
    std::vector<Index> cut;
    for (const CrossingPair& pair : curves_.pairs) cut.push_back(pair.triangle(side));
    sort_unique(cut);
    region_[side] = regions_.find(curves_, side, objects_[side], cut, x);
  }
  out.crossings = pairs.size();
  out.triangles = 0;
  out.curve_length = curves_.length;
  out.closed = curves_.closed;
  for (int side = 0; side < 2; ++side) {
    out.area[side].reset();
    out.triangles += crossing_[side].size();
    inside_[side].clear();
    if (!region_[side]) continue;
    out.area[side] = region_[side]->area;
    std::set_difference(region_[side]->triangles.begin(), region_[side]->triangles.end(),
                        crossing_[side].begin(), crossing_[side].end(), std::back_inserter(inside_[side]));
    out.triangles += inside_[side].size();
    find_deepest(side, x);
  }
  out.depth = depth_;
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
  Vec3 sum = Vec3::Zero();
  std::size_t count = 0;
  for (const auto& line : curves_.lines) {
    auto& points = out.curves.emplace_back();
    for (const Index n : line) points.push_back(curves_.piercings[n].position);
    for (const Vec3& p : points) sum += p, ++count;
  }
  if (count == 0) {
    for (const Vec3& p : curves_.pierced) sum += p, ++count;
  }
  out.point = count > 0 ? sum / static_cast<double>(count) : (low + high) / 2;
  Vec3 normal = Vec3::Zero();
  if (depth_ && *depth_ > 0) {
    out.point = deepest_;
    normal = deepest_ - nearest_;
  } else {
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
