// Crossing triangles of one pose.

#include <tbb/parallel_for.h>

#include <algorithm>
#include <tuple>

#include "query/checker.h"

namespace foldproof {
namespace {

struct Pose {
  const Scene& scene;
  Positions x;

  std::array<Vec3, 3> corners(Index object, const Triangle& t) const {
    return {position(x[object], t[0]), position(x[object], t[1]), position(x[object], t[2])};
  }
};

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
  // The same triangle twice covers itself, without an area as well: it would cross itself as soon as it has
  // one, and nothing else would touch on the way. One that names a vertex twice is a side or corner of the
  // other.
  if (rest_s == 0 && rest_t == 0) return s[0] != s[1] && s[1] != s[2] && s[2] != s[0];
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
               std::vector<TriangleCrossing>& out) {
  Index object_a = task.object_a, object_b = task.object_b;
  const Hierarchy &ha = pose.scene.hierarchy(object_a), &hb = pose.scene.hierarchy(object_b);
  Index a = ha.triangle_ids()[pair.a], b = hb.triangle_ids()[pair.b];
  if (object_a == object_b && b < a) std::swap(a, b);
  const Triangle &s = ha.topology().triangles()[a], &t = hb.topology().triangles()[b];
  const bool cross = object_a == object_b
                         ? neighbours_cross(pose, object_a, s, t)
                         : triangles_intersect(pose.corners(object_a, s), pose.corners(object_b, t));
  if (cross) out.push_back({object_a, a, object_b, b});
}

}  // namespace

Result<void> check_pose(Scene& scene, std::vector<Chunk>& chunks, Positions x, const StepSettings& settings,
                        StaticResult& out) {
  Stopwatch total, watch;
  out.crossings.clear();
  out.work = {};
  out.milliseconds = {};
  if (auto ok = scene.update(x, x, settings); !ok) return ok;
  out.milliseconds.update = watch.lap();
  scene.traverse(settings, 0, out.work);
  out.milliseconds.traverse = watch.lap();

  const Pose pose{scene, x};
  in_rounds(scene.leaf_pairs(), chunks, [&](std::size_t count) {
    tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
      Chunk& chunk = chunks[i];
      chunk.candidates.clear();
      std::size_t done = 0;
      for (const LeafPairRef& pair : chunk.pairs) {
        const TraversalTask& task = scene.tasks()[pair.task];
        find_face_pairs(task.traversal, pair.leaves, chunk.candidates);
        for (; done < chunk.candidates.face_face.size(); ++done) {
          test_pair(pose, task, chunk.candidates.face_face[done], chunk.crossings);
        }
      }
    });
    for (std::size_t i = 0; i < count; ++i) {
      auto& found = chunks[i].crossings;
      out.crossings.insert(out.crossings.end(), found.begin(), found.end());
      found.clear();
    }
  });
  std::sort(out.crossings.begin(), out.crossings.end(),
            [](const TriangleCrossing& a, const TriangleCrossing& b) {
              const auto key = [](const TriangleCrossing& c) {
                return std::tuple(c.object_a, c.triangle_a, c.object_b, c.triangle_b);
              };
              return key(a) < key(b);
            });
  out.milliseconds.narrow = watch.lap();
  out.milliseconds.total = total.lap();
  if (settings.explain) scene.explain(settings, 0, out.explanation);
  return {};
}

Result<void> StepChecker::check_static(Positions x, const StepSettings& settings, StaticResult& out) {
  impl_->forecast.forget();
  return check_pose(impl_->scene, impl_->chunks, x, settings, out);
}

}  // namespace foldproof
