// Crossing triangles of one pose.

#include <algorithm>
#include <tuple>

#include "base/parallel.h"
#include "base/plain_arithmetic.h"
#include "check/answer.h"
#include "check/shortlist.h"
#include "check/step.h"

namespace foldproof {
namespace {

struct Pose {
  const StepMotion& motion;
  Positions x;

  std::array<Vec3, 3> corners(Index object, const Triangle& t) const {
    return {position(x[object], t[0]), position(x[object], t[1]), position(x[object], t[2])};
  }
};

// The same triangle twice covers itself, without an area as well: it would cross itself as soon as it has
// one, and nothing else would touch on the way. One that names a vertex twice is a side or corner of the
// other.
bool covers_itself(const Triangle& t) { return t[0] != t[1] && t[1] != t[2] && t[2] != t[0]; }

// Two triangles of one object: they cross when they meet beyond what they share.
bool neighbours_cross(const Pose& pose, Index object, const Triangle& s, const Triangle& t) {
  std::array<Index, 3> shared{}, only_s{}, only_t{};
  int common = 0, rest_s = 0, rest_t = 0;
  for (const Index v : s) {
    const bool both = std::find(t.begin(), t.end(), v) != t.end();
    (both ? shared[common++] : only_s[rest_s++]) = v;
  }
  for (const Index v : t) {
    if (std::find(s.begin(), s.end(), v) == s.end()) only_t[rest_t++] = v;
  }
  const auto p = [&](Index v) { return position(pose.x[object], v); };
  if (common == 0) return triangles_intersect(pose.corners(object, s), pose.corners(object, t));
  if (rest_s == 0 && rest_t == 0) return covers_itself(s);
  if (rest_s == 0 || rest_t == 0) return false;
  if (rest_s == 1 && rest_t == 1)
    return triangles_fold(p(shared[0]), p(shared[1]), p(only_s[0]), p(only_t[0]));
  // One common vertex: they meet elsewhere only where the opposite side of one meets the other. A triangle
  // that names a vertex twice has one far vertex, and its far side is that point.
  const auto far_side = [&](const std::array<Index, 3>& only, int count) {
    return std::array<Vec3, 2>{p(only[0]), p(only[count - 1])};
  };
  return segment_intersects_triangle(far_side(only_s, rest_s), pose.corners(object, t)) ||
         segment_intersects_triangle(far_side(only_t, rest_t), pose.corners(object, s));
}

void test_pair(const Pose& pose, const TraversalTask& task, CandidateBuffer::Pair pair,
               const PairFilter* filter, std::vector<TriangleCrossing>& out) {
  Index object_a = task.object_a, object_b = task.object_b;
  const Hierarchy &ha = pose.motion.hierarchy(object_a), &hb = pose.motion.hierarchy(object_b);
  Index a = ha.triangle_ids()[pair.a], b = hb.triangle_ids()[pair.b];
  if (object_a == object_b && b < a) std::swap(a, b);
  if (filter != nullptr && !filter->crossing(a, b)) return;
  const Triangle &s = ha.topology().triangles()[a], &t = hb.topology().triangles()[b];
  const bool cross = object_a == object_b
                         ? neighbours_cross(pose, object_a, s, t)
                         : triangles_intersect(pose.corners(object_a, s), pose.corners(object_b, t));
  if (cross) out.push_back({object_a, a, object_b, b});
}

struct ById {
  bool operator()(const TriangleCrossing& a, const TriangleCrossing& b) const {
    return std::tie(a.object_a, a.triangle_a, a.object_b, a.triangle_b) <
           std::tie(b.object_a, b.triangle_a, b.object_b, b.triangle_b);
  }
};

// Counts crossings, and lists those with the smallest ids, with every copy of their triangles. Copies are
// gone through in the order of their ids, so that the rest can be left out once one is no longer listed.
class Crossings {
 public:
  Crossings(DistinctObjects distinct, std::uint64_t max_listed, StaticResult& out)
      : distinct_(distinct), out_(out), list_(out.crossings, max_listed, ById{}) {}

  void add(const TriangleCrossing& c) {
    const Index one[] = {c.triangle_a}, other[] = {c.triangle_b};
    const auto a = copies(c.object_a, one), b = copies(c.object_b, other);
    out_.crossing_count += std::uint64_t{a.size()} * b.size();
    if (c.object_a == c.object_b) {
      add_within(c.object_a, a, b);
      return;
    }
    for (const Index i : a) {
      for (const Index k : b) {
        if (!list_.add({c.object_a, i, c.object_b, k})) return;
      }
    }
  }

  // Every two copies of a triangle.
  void add_copies(Index object, std::span<const Index> copies) {
    out_.crossing_count += std::uint64_t{copies.size()} * (copies.size() - 1) / 2;
    for (std::size_t i = 0; i < copies.size(); ++i) {
      for (std::size_t k = i + 1; k < copies.size(); ++k) {
        if (!list_.add({object, copies[i], object, copies[k]})) return;
      }
    }
  }

  void finish() { list_.finish(); }

 private:
  std::span<const Index> copies(Index object, std::span<const Index> alone) const {
    return distinct_.empty() || !distinct_[object]->has_copies() ? alone
                                                                 : distinct_[object]->copies(alone[0]);
  }

  // By the smaller id of each pair, in both lists.
  void add_within(Index object, std::span<const Index> a, std::span<const Index> b) {
    while (!a.empty() && !b.empty()) {
      if (b[0] < a[0]) std::swap(a, b);
      for (const Index k : b) {
        if (!list_.add({object, a[0], object, k})) return;
      }
      a = a.subspan(1);
    }
  }

  DistinctObjects distinct_;
  StaticResult& out_;
  Shortlist<TriangleCrossing, ById> list_;
};

void add_all_copies(const Pose& pose, DistinctObjects distinct, Crossings& out) {
  for (Index object = 0; object < distinct.size(); ++object) {
    for (const Index t : distinct[object]->repeated()) {
      if (covers_itself(pose.motion.hierarchy(object).topology().triangles()[t]))
        out.add_copies(object, distinct[object]->copies(t));
    }
  }
}

}  // namespace

Result<void> check_pose(const Query& query, Positions x, const StepSettings& settings, StaticResult& out) {
  const PlainArithmetic plain;
  Pipeline& pipeline = query.pipeline;
  std::vector<Chunk>& chunks = pipeline.chunks;
  Stopwatch total, watch;
  out.crossings.clear();
  out.crossing_count = 0;
  out.work = {};
  out.milliseconds = {};
  if (auto ok = pipeline.motion.update(x, x); !ok) return ok;
  out.milliseconds.update = watch.lap();
  if (auto ok = pipeline.find_leaf_pairs(x, x, settings, 0, out.work); !ok) return ok;
  out.milliseconds.traverse = watch.lap();

  const Pose pose{pipeline.motion, x};
  const BroadPhase& found = pipeline.broad_phase;
  Crossings crossings(query.distinct, settings.max_listed, out);
  in_rounds(found.leaf_pairs(), chunks, [&](std::size_t count) {
    parallel_for(std::size_t{0}, count, [&](std::size_t i) {
      Chunk& chunk = chunks[i];
      chunk.candidates.clear();
      std::size_t done = 0;
      for (const LeafPairRef& pair : chunk.pairs) {
        const TraversalTask& task = found.tasks()[pair.task];
        find_face_pairs(task.traversal, pair.leaves, chunk.candidates);
        for (; done < chunk.candidates.face_face.size(); ++done) {
          test_pair(pose, task, chunk.candidates.face_face[done], query.filter, chunk.crossings);
        }
      }
    });
    for (std::size_t i = 0; i < count; ++i) {
      for (const TriangleCrossing& crossing : chunks[i].crossings) crossings.add(crossing);
      chunks[i].crossings.clear();
    }
  });
  if (settings.within) add_all_copies(pose, query.distinct, crossings);
  crossings.finish();
  out.milliseconds.narrow = watch.lap();
  out.milliseconds.total = total.lap();
  if (settings.explain) {
    pipeline.explain(settings, 0, out.explanation);
    spread(query.distinct, out.explanation);
  }
  return {};
}

}  // namespace foldproof
