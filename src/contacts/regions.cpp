#include "contacts/regions.h"

#include <algorithm>
#include <limits>

#include "check/motion.h"
#include "check/triangles_cross.h"

namespace foldproof::internal {
namespace {

double triangle_area(const Vec3& a, const Vec3& b, const Vec3& c) { return (b - a).cross(c - a).norm() / 2; }

// The area that closed lines enclose, if they lie in a plane.
double enclosed_area(const Curves& curves) {
  double area = 0;
  for (const auto& line : curves.lines) {
    Vec3 sum = Vec3::Zero();
    const Vec3 origin = curves.piercings[line[0]].position;
    for (std::size_t i = 1; i < line.size(); ++i) {
      sum += (curves.piercings[line[i - 1]].position - origin)
                 .cross(curves.piercings[line[i]].position - origin);
    }
    area += sum.norm() / 2;
  }
  return area;
}

}  // namespace

// Which end of a pierced edge is behind the face.
std::size_t RegionFinder::end_behind(const Piercing& p, Positions x) const {
  const auto [object, triangle] = surfaces_.local_triangle(p.face);
  const Triangle& f = surfaces_.topology(object).triangles()[triangle];
  const Vec3 corner = position(x[object], f[0]);
  const Vec3 normal = (position(x[object], f[1]) - corner).cross(position(x[object], f[2]) - corner);
  return normal.dot(position(x[p.object], p.edge[1]) - position(x[p.object], p.edge[0])) < 0 ? 1 : 0;
}

void RegionFinder::collect_cuts(const Curves& curves, const RegionQuery& query) {
  all_cuts_.clear();
  cuts_.clear();
  walls_.clear();
  segments_.clear();
  curves_ = &curves;
  for (const Piercing& p : curves.piercings) {
    if (p.object != query.object) continue;
    if (p.face == kNoIndex) {
      walls_.push_back(p.edge[0]);
    } else if (query.sides[static_cast<std::size_t>(p.side)]) {
      all_cuts_.push_back({p.edge, p.share, &p});
    }
  }
  for (Index i = 0; i < curves.segments.size() && !walls_.empty(); ++i) {
    const CrossingPair& pair = curves.pairs[curves.segments[i].pair];
    for (int side = 0; side < 2; ++side) {
      if (query.sides[static_cast<std::size_t>(side)]) segments_.push_back({pair.triangle(side), i});
    }
  }
  std::sort(segments_.begin(), segments_.end());
  // An edge that is pierced twice ends where it began.
  for (std::size_t i = 0; i < all_cuts_.size();) {
    std::size_t end = i + 1;
    while (end < all_cuts_.size() && all_cuts_[end].edge == all_cuts_[i].edge) ++end;
    if ((end - i) % 2 == 1) cuts_.push_back(all_cuts_[i]);
    std::sort(all_cuts_.begin() + static_cast<std::ptrdiff_t>(i),
              all_cuts_.begin() + static_cast<std::ptrdiff_t>(end),
              [](const Cut& a, const Cut& b) { return a.share < b.share; });
    i = end;
  }
}

// All cuts of an edge, whose vertices are in any order, from the smaller one on.
std::span<const RegionFinder::Cut> RegionFinder::all_cuts(Index u, Index w) const {
  if (!is_near_cuts(u) || !is_near_cuts(w)) return {};
  const auto [first, last] = cuts_from_[std::min(u, w)];
  const Cut* const cuts_end = all_cuts_.data() + last;
  const Cut* const begin =
      std::lower_bound(all_cuts_.data() + first, cuts_end, std::max(u, w),
                       [](const Cut& cut, Index vertex) { return cut.edge[1] < vertex; });
  const Cut* end = begin;
  while (end != cuts_end && end->edge[1] == std::max(u, w)) ++end;
  return {begin, end};
}

// The first cut of an edge that has an odd number of them; else null.
const RegionFinder::Cut* RegionFinder::find_cut(Index u, Index w) const {
  const auto cuts = all_cuts(u, w);
  return cuts.size() % 2 == 1 ? cuts.data() : nullptr;
}

// Whether faces connect neighbors.
bool RegionFinder::is_passable(Index u, Index w) const {
  return (has_faces_only_ || surfaces_.is_of_face(object_, {u, w})) && !is_wall(w) && !is_cut(u, w);
}

Index RegionFinder::component_of(Index vertex) {
  return stamps_[vertex] == stamp_ ? root_of(component_at_[vertex]) : kNoIndex;
}

Index RegionFinder::root_of(Index component) {
  while (components_[component].parent != component) {
    components_[component].parent = components_[components_[component].parent].parent;
    component = components_[component].parent;
  }
  return component;
}

void RegionFinder::add(Index component, Index vertex) {
  stamps_[vertex] = stamp_;
  component_at_[vertex] = component;
  components_[component].vertices.push_back(vertex);
}

// Visits the next vertex of a component: takes its neighbors in, and unites with the components that they are
// in.
void RegionFinder::visit(Index component) {
  const Index vertex = components_[component].vertices[components_[component].visited++];
  surfaces_.for_each_neighbor(object_, vertex, [&](Index w) {
    const Index other = component_of(w);
    if (other == component || !is_passable(vertex, w)) return;
    if (other == kNoIndex) {
      add(component, w);
    } else {
      unite(component, other);
    }
  });
}

void RegionFinder::unite(Index component, Index other) {
  // The larger list stays where it is.
  Component &into = components_[component], &from = components_[other];
  const bool swapped = into.vertices.size() < from.vertices.size();
  if (swapped) std::swap(into.vertices, from.vertices), std::swap(into.visited, from.visited);
  // Visited vertices first.
  const auto visited = [](Component& c) {
    return c.vertices.begin() + static_cast<std::ptrdiff_t>(c.visited);
  };
  std::vector<Index> waiting(visited(into), into.vertices.end());
  into.vertices.resize(into.visited);
  into.vertices.insert(into.vertices.end(), from.vertices.begin(), visited(from));
  into.visited += from.visited;
  into.vertices.insert(into.vertices.end(), waiting.begin(), waiting.end());
  into.vertices.insert(into.vertices.end(), visited(from), from.vertices.end());
  from = {component, {}, 0};
}

void RegionFinder::begin_search() {
  components_.clear();
  if (++stamp_ == 0) {
    std::fill(stamps_.begin(), stamps_.end(), 0);
    std::fill(cut_stamps_.begin(), cut_stamps_.end(), 0);
    stamp_ = 1;
  }
  const Topology& topology = surfaces_.topology(object_);
  has_faces_only_ = topology.face_count() == topology.triangles().size();
  const std::size_t vertices = topology.vertex_count();
  if (stamps_.size() < vertices) {
    stamps_.resize(vertices, 0);
    cut_stamps_.resize(vertices, 0);
    component_at_.resize(vertices);
    cuts_from_.resize(vertices);
  }
  const auto mark = [&](Index v) {
    if (cut_stamps_[v] != stamp_) cuts_from_[v] = {0, 0};
    cut_stamps_[v] = stamp_;
  };
  for (Index i = 0; i < all_cuts_.size(); ++i) {
    const auto& [first, second] = all_cuts_[i].edge;
    mark(first);
    mark(second);
    auto& from = cuts_from_[first];
    from = {from[1] == 0 ? i : from[0], i + 1};
  }
  for (const Index v : walls_) mark(v);
}

// Grows all components at the same pace until at most one is not complete.
void RegionFinder::grow() {
  begin_search();
  active_.clear();
  for (const Cut& cut : cuts_) {
    for (const Index v : cut.edge) {
      if (is_wall(v) || component_of(v) != kNoIndex) continue;
      const auto component = static_cast<Index>(components_.size());
      components_.push_back({component, {}, 0});
      active_.push_back(component);
      add(component, v);
      // With what is connected to it along the cuts, so that few components have to be united.
      for (std::size_t i = 0; i < components_[component].vertices.size(); ++i) {
        const Index u = components_[component].vertices[i];
        surfaces_.for_each_neighbor(object_, u, [&](Index w) {
          if (cut_stamps_[w] == stamp_ && stamps_[w] != stamp_ && is_passable(u, w)) add(component, w);
        });
      }
    }
  }
  constexpr int kAtOnce = 16;
  while (active_.size() > 1) {
    for (const Index component : active_) {
      for (int i = 0; i < kAtOnce && root_of(component) == component && !is_complete(component); ++i)
        visit(component);
    }
    std::erase_if(active_, [&](Index c) { return root_of(c) != c || is_complete(c); });
  }
}

bool RegionFinder::is_complete(Index c) const {
  return components_[c].visited == components_[c].vertices.size();
}

// Decides which components are inside: those on the other side of a cut from the one that is not complete, or
// else from the largest one; or what is behind. False if cuts contradict each other.
bool RegionFinder::assign_parts() {
  constexpr std::uint8_t kUnknown = 2;
  inside_.assign(components_.size(), kUnknown);
  group_.assign(components_.size(), kNoIndex);
  std::vector<std::vector<Index>> across(components_.size());
  for (const Cut& cut : cuts_) {
    const Index a = component_of(cut.edge[0]), b = component_of(cut.edge[1]);
    if (a == kNoIndex || b == kNoIndex) continue;  // a wall
    if (a == b) return false;
    across[a].push_back(b);
    across[b].push_back(a);
  }
  std::vector<Index> order, queue;
  for (Index c = 0; c < components_.size(); ++c) {
    if (root_of(c) == c) order.push_back(c);
  }
  std::stable_sort(order.begin(), order.end(), [&](Index a, Index b) {
    if (is_complete(a) != is_complete(b)) return !is_complete(a);
    return components_[a].vertices.size() > components_[b].vertices.size();
  });
  for (const Index outside : order) {
    if (inside_[outside] != kUnknown) continue;
    inside_[outside] = 0;
    queue.assign(1, outside);
    for (std::size_t i = 0; i < queue.size(); ++i) {
      group_[queue[i]] = outside;
      for (const Index c : across[queue[i]]) {
        const std::uint8_t part = 1 - inside_[queue[i]];
        if (inside_[c] == kUnknown) {
          inside_[c] = part;
          queue.push_back(c);
        } else if (inside_[c] != part) {
          return false;
        }
      }
    }
  }
  return true;
}

// Exchanges inside and outside where most cuts say that what is inside is not what they have behind. Without
// `behind`, they decide only where both parts have as many vertices.
void RegionFinder::turn_groups(int behind, Positions x) {
  std::vector<std::ptrdiff_t> more_inside(components_.size(), 0), votes(components_.size(), 0);  // per group
  for (Index c = 0; c < components_.size(); ++c) {
    if (root_of(c) != c) continue;
    const auto size = static_cast<std::ptrdiff_t>(components_[c].vertices.size());
    more_inside[group_[c]] += inside_[c] == 1 ? size : -size;
  }
  const auto is_asked = [&](Index group) {
    return behind != 0 || (more_inside[group] == 0 && is_complete(group));
  };
  for (const Cut& cut : cuts_) {
    const Index first = component_of(cut.edge[0]);
    if (first == kNoIndex || !is_asked(group_[first])) continue;
    const Index c = component_of(cut.edge[end_behind(*cut.piercing, x)]);
    if (c != kNoIndex) votes[group_[c]] += inside_[c] == 1 ? 1 : -1;
  }
  for (Index c = 0; c < components_.size(); ++c) {
    if (root_of(c) != c) continue;
    if (votes[group_[c]] * (behind != 0 ? behind : 1) < 0) inside_[c] = 1 - inside_[c];
    while (inside_[c] == 1 && !is_complete(c)) visit(c);
  }
}

bool RegionFinder::is_inside(Index vertex) {
  const Index component = component_of(vertex);
  return component != kNoIndex && inside_[component] == 1;
}

// The corner that a curve cuts off.
std::optional<int> RegionFinder::lone_corner(const Triangle& corners) {
  for (int k = 0; k < 3; ++k) {
    const Index a = corners[k], b = corners[(k + 1) % 3], c = corners[(k + 2) % 3];
    const bool inside = is_inside(a);
    if (inside != is_inside(b) && inside != is_inside(c) && is_cut(a, b) && is_cut(a, c)) return k;
  }
  return std::nullopt;
}

Vec3 RegionFinder::cut_at(Index u, Index w, Positions x) const {
  const Cut* cut = find_cut(u, w);
  const Vec3 from = position(x[object_], cut->edge[0]);
  return from + cut->share * (position(x[object_], cut->edge[1]) - from);
}

std::span<const std::array<Index, 2>> RegionFinder::segments_in(Index triangle) const {
  const auto* const end = segments_.data() + segments_.size();
  return {std::lower_bound(segments_.data(), end, std::array<Index, 2>{triangle, 0}),
          std::lower_bound(segments_.data(), end, std::array<Index, 2>{triangle + 1, 0})};
}

// Whether the edge to `w` is inside where it begins.
bool RegionFinder::is_inside_at(Index u, Index w) {
  if (!is_wall(u)) return is_inside(u);
  if (!is_wall(w)) return is_inside(w) != (all_cuts(u, w).size() % 2 == 1);
  return is_inside_between_walls(u, w);
}

// Around `u`, what is inside changes where curves begin in a corner: up to a neighbor that is not a wall.
bool RegionFinder::is_inside_between_walls(Index u, Index w) {
  bool changes = false;
  Index last = kNoIndex;
  for (std::size_t i = 0; i < surfaces_.triangles_at(object_, u).size(); ++i) {
    surfaces_.triangles_with_edge(object_, {u, w}, at_edge_);
    const auto next = std::find_if(at_edge_.begin(), at_edge_.end(), [&](Index t) { return t != last; });
    if (next == at_edge_.end() || !surfaces_.is_face(object_, *next)) return false;
    last = *next;
    for (const auto& [triangle, segment] : segments_in(last)) {
      for (const Index n : curves_->segments[segment].ends) {
        const Piercing& p = curves_->piercings[n];
        changes ^= p.face == kNoIndex && p.edge[0] == u;
      }
    }
    const Triangle& corners = surfaces_.topology(object_).triangles()[last];
    w = *std::find_if(corners.begin(), corners.end(), [&](Index v) { return v != u && v != w; });
    if (!is_wall(w)) return is_inside_at(u, w) != changes;
  }
  return false;
}

// Calls visit(begin, end, inside, between) with the pieces of an edge: shares of it, and whether both ends
// are on curves.
template <class Visit>
void RegionFinder::for_each_piece(const Edge& edge, std::span<const Cut> cuts, const Visit& visit) {
  bool inside = is_inside_at(edge[0], edge[1]), between = is_wall(edge[0]);
  double begin = 0;
  for (const Cut& cut : cuts) {
    visit(begin, cut.share, inside, between);
    begin = cut.share, inside = !inside, between = true;
  }
  visit(begin, 1.0, inside, between && is_wall(edge[1]));
}

void RegionFinder::add_pieces(Positions x, Region& region) {
  const bool few = region.vertices.size() <= Region::kFew;
  with_pieces_.clear();
  const auto add = [&](const Edge& edge, std::span<const Cut> cuts) {
    const Vec3 from = position(x[object_], edge[0]), to = position(x[object_], edge[1]);
    for_each_piece(edge, cuts, [&](double begin, double end, bool inside, bool between) {
      if (!inside || !(between || few)) return;
      region.pieces.push_back({from + begin * (to - from), from + end * (to - from)});
      if (between) with_pieces_.push_back(edge);
    });
  };
  for (std::size_t i = 0; i < all_cuts_.size();) {
    std::size_t end = i + 1;
    while (end < all_cuts_.size() && all_cuts_[end].edge == all_cuts_[i].edge) ++end;
    add(all_cuts_[i].edge, std::span(all_cuts_).subspan(i, end - i));
    i = end;
  }
  // Edges that are not cut.
  const auto add_around = [&](Index u, bool only_walls) {
    surfaces_.for_each_neighbor(object_, u, [&](Index w) {
      const bool first = only_walls ? is_wall(w) && u < w : is_wall(w) || u < w;
      if (first && surfaces_.is_of_face(object_, {u, w}) && all_cuts(u, w).empty())
        add({std::min(u, w), std::max(u, w)}, {});
    });
  };
  for (const Index u : walls_) add_around(u, true);
  for (std::size_t i = 0; i < region.vertices.size() && few; ++i) add_around(region.vertices[i], false);
  std::sort(with_pieces_.begin(), with_pieces_.end());
}

bool RegionFinder::reaches_inside(Index t) {
  const Triangle& corners = surfaces_.topology(object_).triangles()[t];
  for (int k = 0; k < 3; ++k) {
    const auto [a, b] = std::minmax(corners[k], corners[(k + 1) % 3]);
    if (is_inside(corners[k]) || std::binary_search(with_pieces_.begin(), with_pieces_.end(), Edge{a, b}))
      return true;
  }
  return false;
}

void RegionFinder::add_outer_pieces(Index t, Positions x, std::vector<std::array<Vec3, 3>>& out) {
  const Triangle& corners = surfaces_.topology(object_).triangles()[t];
  for (int k = 0; k < 3; ++k) {
    const auto [a, b] = std::minmax(corners[k], corners[(k + 1) % 3]);
    const Vec3 from = position(x[object_], a), to = position(x[object_], b);
    for_each_piece({a, b}, all_cuts(a, b), [&](double begin, double end, bool inside, bool) {
      const Vec3 last = from + end * (to - from);
      if (!inside) out.push_back({from + begin * (to - from), last, last});
    });
  }
}

// On the way from a piece of an edge, each segment that is crossed leads in or out. By way of the middle:
// where segments end on an edge, the way does not go along it.
bool RegionFinder::is_inside(Index t, const Vec3& p, Positions x) {
  const Triangle& corners = surfaces_.topology(object_).triangles()[t];
  const auto [a, b, c] = foldproof::corners(x[object_], corners);
  const auto cuts = all_cuts(corners[0], corners[1]);
  bool inside = is_inside_at(corners[0], corners[1]);
  // The first piece from that corner on.
  double end = 1;
  if (!cuts.empty()) end = corners[0] < corners[1] ? cuts.front().share : 1 - cuts.back().share;
  const Vec3 begin = a + end / 2 * (b - a), middle = (a + b + c) / 3, normal = (b - a).cross(c - a);
  const auto side = [&](const Vec3& u, const Vec3& v, const Vec3& w) {
    return normal.dot((v - u).cross(w - u)) >= 0;
  };
  for (const auto& [triangle, segment] : segments_in(t)) {
    const auto& ends = curves_->segments[segment].ends;
    const Vec3 &u = curves_->piercings[ends[0]].position, &v = curves_->piercings[ends[1]].position;
    const auto crosses = [&](const Vec3& from, const Vec3& to) {
      return side(from, to, u) != side(from, to, v) && side(u, v, from) != side(u, v, to);
    };
    inside ^= crosses(begin, middle) != crosses(middle, p);
  }
  return inside;
}

Region RegionFinder::region(Positions x) {
  Region out;
  std::size_t most = 0;
  for (Index c = 0; c < components_.size(); ++c) {
    const auto& vertices = components_[c].vertices;
    if (root_of(c) != c || inside_[c] != 1) continue;
    out.vertices.insert(out.vertices.end(), vertices.begin(), vertices.end());
    if (vertices.size() > most) most = vertices.size(), out.last = vertices.back();
  }
  const auto triangles = surfaces_.topology(object_).triangles();
  for (const Index v : out.vertices) {
    for (const Index t : surfaces_.triangles_at(object_, v)) {
      if (!surfaces_.is_face(object_, t)) break;
      const auto& [a, b, c] = triangles[t];
      // Once, by its smallest corner.
      if (v == std::min({a, b, c}) && is_inside(a) && is_inside(b) && is_inside(c))
        out.triangles.push_back(t);
    }
  }
  std::sort(out.triangles.begin(), out.triangles.end());
  add_pieces(x, out);
  return out;
}

double RegionFinder::area(const Region& region, std::span<const Index> crossing, Positions x) {
  if (region.vertices.empty()) return enclosed_area(*curves_);
  double sum = 0;
  const auto triangles = surfaces_.topology(object_).triangles();
  const auto at = [&](Index v) { return position(x[object_], v); };
  for (const Index t : region.triangles)
    sum += triangle_area(at(triangles[t][0]), at(triangles[t][1]), at(triangles[t][2]));
  // Where a curve cuts one corner off, the corner or the rest is inside.
  for (const Index t : crossing) {
    const Triangle& corners = triangles[t];
    const auto k = lone_corner(corners);
    if (!k) continue;
    const Index a = corners[*k], b = corners[(*k + 1) % 3], c = corners[(*k + 2) % 3];
    const double corner = triangle_area(at(a), cut_at(a, b, x), cut_at(a, c, x));
    sum += is_inside(a) ? corner : triangle_area(at(a), at(b), at(c)) - corner;
  }
  return sum;
}

std::optional<Region> RegionFinder::find(const Curves& curves, const RegionQuery& query, Positions x) {
  object_ = query.object;
  collect_cuts(curves, query);
  grow();
  if (!assign_parts()) return std::nullopt;
  turn_groups(query.behind, x);
  Region out = region(x);
  if (!query.crossing.empty()) out.area = area(out, query.crossing, x);
  return out;
}

std::array<std::vector<Index>, 2> RegionFinder::find_tips(const Curves& curves, const RegionQuery& query,
                                                          Positions x) {
  object_ = query.object;
  collect_cuts(curves, query);
  begin_search();
  std::array<std::vector<Index>, 2> tips;
  std::vector<Index> queue;
  const auto take = [&](Index v, Index tip) {
    if (is_wall(v) || stamps_[v] == stamp_) return;
    stamps_[v] = stamp_;
    component_at_[v] = tip;
    tips[tip].push_back(v);
    queue.push_back(v);
  };
  for (const Cut& cut : cuts_) {
    const std::size_t behind = end_behind(*cut.piercing, x);
    take(cut.edge[1 - behind], 0);
    take(cut.edge[behind], 1);
  }
  const std::size_t most = 64 + 2 * queue.size();
  for (std::size_t i = 0; i < queue.size() && queue.size() < most; ++i) {
    const Index v = queue[i];
    surfaces_.for_each_neighbor(object_, v, [&](Index w) {
      if (is_passable(v, w)) take(w, component_at_[v]);
    });
  }
  return tips;
}

}  // namespace foldproof::internal
