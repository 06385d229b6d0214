#include "contacts/follow_crossings.h"

#include <algorithm>
#include <limits>
#include <tuple>

#include "base/parallel.h"
#include "check/triangles_cross.h"

namespace foldproof::internal {
namespace {

// Lists the pairs of triangles that have a colliding pair of features, each once, sorted, as far as they may
// cross at the end of the step.
class PairLister {
 public:
  PairLister(const Surfaces& surfaces, Positions x1, std::span<const TriangleCrossing> crossings)
      : surfaces_(surfaces), x1_(x1), crossings_(crossings) {}

  void list(const StepResult& step, const PairFilter* filter, std::vector<TriangleCrossing>& out) {
    add_vertex_faces(step);
    add_edge_edges(step);
    if (pruned_) {
      for (const TriangleCrossing& c : crossings_)
        add({c.object_a, c.triangle_a}, {c.object_b, c.triangle_b});
    }
    std::sort(keys_.begin(), keys_.end());
    keys_.erase(std::unique(keys_.begin(), keys_.end()), keys_.end());
    out.clear();
    for (const std::uint64_t key : keys_) {
      const auto [object_a, a] = surfaces_.local_triangle(static_cast<Index>(key >> 32));
      const auto [object_b, b] = surfaces_.local_triangle(static_cast<Index>(key));
      if (filter == nullptr || filter->crossing(object_a, a, object_b, b))
        out.push_back({object_a, a, object_b, b});
    }
  }

 private:
  // A triangle with its object.
  struct Member {
    Index object, triangle;
  };
  // Around so many triangles, pairs are few enough to be tested as they are.
  static constexpr std::size_t kManyTriangles = 16;

  void add(const Member& a, const Member& b) {
    const auto [first, second] =
        std::minmax({surfaces_.triangle(a.object, a.triangle), surfaces_.triangle(b.object, b.triangle)});
    keys_.push_back(std::uint64_t{first} << 32 | second);
  }

  void add_vertex_faces(const StepResult& step) {
    std::vector<const VertexFaceCollision*> many;  // whose vertices have many triangles
    for (const VertexFaceCollision& c : step.vertex_face) {
      const auto at = surfaces_.triangles_at(c.vertex_object, c.vertex);
      if (at.size() > kManyTriangles) {
        many.push_back(&c);
        continue;
      }
      for (const Index t : at) add({c.vertex_object, t}, {c.face_object, c.face});
    }
    const auto vertex = [](const VertexFaceCollision* c) { return std::pair(c->vertex_object, c->vertex); };
    std::stable_sort(many.begin(), many.end(), [&](auto* a, auto* b) { return vertex(a) < vertex(b); });
    for (std::size_t i = 0; i < many.size();) {
      at_a_.clear();
      at_b_.clear();
      for (const Index t : surfaces_.triangles_at(many[i]->vertex_object, many[i]->vertex))
        at_a_.push_back({many[i]->vertex_object, t});
      for (const auto first = vertex(many[i]); i < many.size() && vertex(many[i]) == first; ++i)
        at_b_.push_back({many[i]->face_object, many[i]->face});
      add_overlapping();
    }
  }

  void add_edge_edges(const StepResult& step) {
    std::vector<Index> at_a, at_b;
    const EdgeEdgeCollision* last = nullptr;
    for (const EdgeEdgeCollision& c : step.edge_edge) {
      if (last == nullptr || last->a != c.a || last->object_a != c.object_a)
        surfaces_.triangles_with_edge(c.object_a, c.a, at_a);
      last = &c;
      surfaces_.triangles_with_edge(c.object_b, c.b, at_b);
      if (at_a.size() <= kManyTriangles && at_b.size() <= kManyTriangles) {
        for (const Index a : at_a) {
          for (const Index b : at_b) add({c.object_a, a}, {c.object_b, b});
        }
        continue;
      }
      at_a_.clear();
      at_b_.clear();
      for (const Index t : at_a) at_a_.push_back({c.object_a, t});
      for (const Index t : at_b) at_b_.push_back({c.object_b, t});
      add_overlapping();
    }
  }

  struct Box {
    Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
    void add(const Vec3& p) { low = low.cwiseMin(p), high = high.cwiseMax(p); }
    bool meets(const Box& o) const { return low.cwiseMin(o.high) == low && high.cwiseMax(o.low) == high; }
  };
  Box box_of(const Member& m) const {
    Box box;
    for (const Vec3& p : corners(x1_[m.object], surfaces_.topology(m.object).triangles()[m.triangle]))
      box.add(p);
    return box;
  }

  // Leaves those triangles out that do not meet the box of all others.
  void prune(std::vector<Member>& of, const std::vector<Member>& others) const {
    Box all;
    for (const Member& m : others) {
      const Box box = box_of(m);
      all.add(box.low), all.add(box.high);
    }
    std::erase_if(of, [&](const Member& m) { return !box_of(m).meets(all); });
  }

  // Adds the pairs of at_a_ and at_b_ whose boxes meet: others do not cross, even if they did before.
  void add_overlapping() {
    pruned_ = true;
    prune(at_a_, at_b_);
    prune(at_b_, at_a_);
    for (const Member& a : at_a_) {
      for (const Member& b : at_b_) {
        if (box_of(a).meets(box_of(b))) add(a, b);
      }
    }
  }

  const Surfaces& surfaces_;
  Positions x1_;
  std::span<const TriangleCrossing> crossings_;
  std::vector<std::uint64_t> keys_;  // two global triangle ids, the smaller first
  std::vector<Member> at_a_, at_b_;
  bool pruned_ = false;  // pairs were left out: those that crossed before are tested again
};

bool cross(const Surfaces& surfaces, Positions x, const TriangleCrossing& c) {
  const Triangle &s = surfaces.topology(c.object_a).triangles()[c.triangle_a],
                 &t = surfaces.topology(c.object_b).triangles()[c.triangle_b];
  if (c.object_a == c.object_b) {
    return may_cross(surfaces.topology(c.object_a), c.triangle_a, c.triangle_b) &&
           triangles_cross(x[c.object_a], s, t);
  }
  return triangles_intersect(corners(x[c.object_a], s), corners(x[c.object_b], t));
}

}  // namespace

bool is_before(const TriangleCrossing& a, const TriangleCrossing& b) {
  return std::tie(a.object_a, a.triangle_a, a.object_b, a.triangle_b) <
         std::tie(b.object_a, b.triangle_a, b.object_b, b.triangle_b);
}

void follow_crossings(const Surfaces& surfaces, const PairFilter* filter, const StepResult& step,
                      Positions x1, std::vector<TriangleCrossing>& tested,
                      std::vector<TriangleCrossing>& crossings) {
  PairLister(surfaces, x1, crossings).list(step, filter, tested);
  if (tested.empty()) return;
  std::vector<TriangleCrossing> kept;
  std::set_difference(crossings.begin(), crossings.end(), tested.begin(), tested.end(),
                      std::back_inserter(kept), is_before);
  std::vector<std::uint8_t> crosses(tested.size());
  parallel_for(IndexRange{0, tested.size()}, 256, [&](IndexRange range) {
    for (std::size_t i = range.begin; i < range.end; ++i) crosses[i] = cross(surfaces, x1, tested[i]);
  });
  std::size_t count = 0;
  for (std::size_t i = 0; i < tested.size(); ++i) {
    if (crosses[i]) tested[count++] = tested[i];
  }
  tested.resize(count);
  crossings.clear();
  std::merge(kept.begin(), kept.end(), tested.begin(), tested.end(), std::back_inserter(crossings),
             is_before);
}

}  // namespace foldproof::internal
