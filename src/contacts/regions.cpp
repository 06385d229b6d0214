#include "contacts/regions.h"

#include <algorithm>

#include "check/motion.h"

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

void RegionFinder::collect_cuts(const Curves& curves, int side) {
  cuts_.clear();
  const auto& all = curves.piercings;
  for (std::size_t i = 0; i < all.size();) {
    std::size_t end = i + 1;
    while (end < all.size() && all[end].side == all[i].side && all[end].object == all[i].object &&
           all[end].edge == all[i].edge)
      ++end;
    // An edge that is pierced twice ends where it began.
    if (all[i].side == side && all[i].face != kNoIndex && (end - i) % 2 == 1)
      cuts_.push_back({all[i].edge, all[i].share});
    i = end;
  }
}

bool RegionFinder::is_cut(Index u, Index w) const {
  if (cut_stamps_[u] != stamp_ || cut_stamps_[w] != stamp_) return false;
  const Edge edge{std::min(u, w), std::max(u, w)};
  const auto at = std::lower_bound(cuts_.begin(), cuts_.end(), edge,
                                   [](const Cut& cut, const Edge& e) { return cut.edge < e; });
  return at != cuts_.end() && at->edge == edge;
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
  const auto triangles = surfaces_.topology(object_).triangles();
  for (const Index t : surfaces_.triangles_at(object_, vertex)) {
    if (!surfaces_.is_face(object_, t)) break;  // faces come first
    for (const Index w : triangles[t]) {
      if (w == vertex || is_cut(vertex, w)) continue;
      const Index other = component_of(w);
      if (other == kNoIndex) {
        add(component, w);
      } else if (other != component) {
        // The larger list stays where it is.
        Component &into = components_[component], &from = components_[other];
        const bool swapped = into.vertices.size() < from.vertices.size();
        if (swapped) std::swap(into.vertices, from.vertices), std::swap(into.visited, from.visited);
        // Visited vertices first.
        std::vector<Index> waiting(into.vertices.begin() + static_cast<std::ptrdiff_t>(into.visited),
                                   into.vertices.end());
        into.vertices.resize(into.visited);
        into.vertices.insert(into.vertices.end(), from.vertices.begin(),
                             from.vertices.begin() + static_cast<std::ptrdiff_t>(from.visited));
        into.visited += from.visited;
        into.vertices.insert(into.vertices.end(), waiting.begin(), waiting.end());
        into.vertices.insert(into.vertices.end(),
                             from.vertices.begin() + static_cast<std::ptrdiff_t>(from.visited),
                             from.vertices.end());
        from = {component, {}, 0};
      }
    }
  }
}

// Grows all components at the same pace until at most one is not complete.
void RegionFinder::grow() {
  components_.clear();
  if (++stamp_ == 0) {
    std::fill(stamps_.begin(), stamps_.end(), 0);
    std::fill(cut_stamps_.begin(), cut_stamps_.end(), 0);
    stamp_ = 1;
  }
  const std::size_t vertices = surfaces_.topology(object_).vertex_count();
  if (stamps_.size() < vertices) {
    stamps_.resize(vertices, 0);
    cut_stamps_.resize(vertices, 0);
    component_at_.resize(vertices);
  }
  active_.clear();
  for (const Cut& cut : cuts_) {
    for (const Index v : cut.edge) {
      cut_stamps_[v] = stamp_;
      if (component_of(v) != kNoIndex) continue;
      const auto component = static_cast<Index>(components_.size());
      components_.push_back({component, {}, 0});
      active_.push_back(component);
      add(component, v);
    }
  }
  while (active_.size() > 1) {
    for (const Index component : active_) {
      if (root_of(component) == component &&
          components_[component].visited < components_[component].vertices.size())
        visit(component);
    }
    std::erase_if(active_, [&](Index c) {
      return root_of(c) != c || components_[c].visited == components_[c].vertices.size();
    });
  }
}

// Decides which components are inside: those on the other side of a cut from the one that is not complete, or
// else from the largest one. False if cuts contradict each other.
bool RegionFinder::assign_parts() {
  constexpr std::uint8_t kUnknown = 2;
  inside_.assign(components_.size(), kUnknown);
  std::vector<std::vector<Index>> across(components_.size());
  for (const Cut& cut : cuts_) {
    const Index a = component_of(cut.edge[0]), b = component_of(cut.edge[1]);
    if (a == b) return false;
    across[a].push_back(b);
    across[b].push_back(a);
  }
  const auto is_complete = [&](Index c) { return components_[c].visited == components_[c].vertices.size(); };
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

Region RegionFinder::region(const Curves& curves, std::span<const Index> crossing, Positions x) {
  Region out;
  for (Index c = 0; c < components_.size(); ++c) {
    if (root_of(c) == c && inside_[c] == 1)
      out.vertices.insert(out.vertices.end(), components_[c].vertices.begin(), components_[c].vertices.end());
  }
  std::sort(out.vertices.begin(), out.vertices.end());
  const auto is_inside = [&](Index v) {
    const Index component = component_of(v);
    return component != kNoIndex && inside_[component] == 1;
  };
  const auto triangles = surfaces_.topology(object_).triangles();
  for (const Index v : out.vertices) {
    for (const Index t : surfaces_.triangles_at(object_, v)) {
      if (!surfaces_.is_face(object_, t)) break;
      if (std::all_of(triangles[t].begin(), triangles[t].end(), is_inside)) out.triangles.push_back(t);
    }
  }
  std::sort(out.triangles.begin(), out.triangles.end());
  out.triangles.erase(std::unique(out.triangles.begin(), out.triangles.end()), out.triangles.end());
  const auto at = [&](Index v) { return position(x[object_], v); };
  for (const Index t : out.triangles)
    out.area += triangle_area(at(triangles[t][0]), at(triangles[t][1]), at(triangles[t][2]));
  // Where a curve cuts one corner off, the corner or the rest is inside.
  const auto cut_at = [&](Index u, Index w) {
    const Edge edge{std::min(u, w), std::max(u, w)};
    const auto cut = std::lower_bound(cuts_.begin(), cuts_.end(), edge,
                                      [](const Cut& c, const Edge& e) { return c.edge < e; });
    return Vec3(at(edge[0]) + cut->share * (at(edge[1]) - at(edge[0])));
  };
  for (const Index t : crossing) {
    const Triangle& corners = triangles[t];
    for (int k = 0; k < 3; ++k) {
      const Index a = corners[k], b = corners[(k + 1) % 3], c = corners[(k + 2) % 3];
      const bool inside = is_inside(a);
      if (inside == is_inside(b) || inside == is_inside(c) || !is_cut(a, b) || !is_cut(a, c)) continue;
      const double corner = triangle_area(at(a), cut_at(a, b), cut_at(a, c));
      out.area += inside ? corner : triangle_area(at(a), at(b), at(c)) - corner;
    }
  }
  if (out.vertices.empty()) out.area = enclosed_area(curves);
  return out;
}

std::optional<Region> RegionFinder::find(const Curves& curves, int side, Index object,
                                         std::span<const Index> crossing, Positions x) {
  if (!curves.closed) return std::nullopt;
  object_ = object;
  collect_cuts(curves, side);
  grow();
  if (!assign_parts()) return std::nullopt;
  return region(curves, crossing, x);
}

}  // namespace foldproof::internal
