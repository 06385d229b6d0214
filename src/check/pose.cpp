// The static query: pairs of triangles that cross in one pose.

#include <algorithm>
#include <tuple>

#include "base/parallel.h"
#include "check/answer.h"
#include "check/separated_triangles.h"
#include "check/smallest_k.h"
#include "check/step.h"
#include "check/triangles_cross.h"

namespace foldproof::internal {
namespace {

struct Pose {
  const StepMotion& motion;
  Positions x;
  std::span<const Object> objects;
  bool is_layered(Index object) const { return !objects.empty() && objects[object].is_layered(); }
};

void test_pair(const Pose& pose, const TraversalTask& task, CandidatePair pair, const Filter& filter,
               std::vector<TriangleCrossing>& out) {
  Index object_a = task.object_a, object_b = task.object_b;
  const Hierarchy &ha = pose.motion.hierarchy(object_a), &hb = pose.motion.hierarchy(object_b);
  Index a = ha.triangle_ids()[pair.a], b = hb.triangle_ids()[pair.b];
  if (object_a == object_b && b < a) std::swap(a, b);
  if (object_a == object_b && !may_cross(ha.topology(), a, b)) return;
  if (!filter.crossing(object_a, a, object_b, b)) return;
  const Triangle &s = ha.topology().triangles()[a], &t = hb.topology().triangles()[b];
  const bool cross = object_a == object_b
                         ? triangles_cross(pose.x[object_a], s, t)
                         : triangles_intersect(corners(pose.x[object_a], s), corners(pose.x[object_b], t));
  if (!cross || (object_a == object_b && pose.is_layered(object_a) && have_same_vertices(s, t))) return;
  out.push_back({object_a, a, object_b, b});
}

// Tests pairs of triangles eight at a time: most are separated, and only the others need exact arithmetic.
class CrossingTest {
 public:
  CrossingTest(const Pose& pose, const Filter& filter, std::vector<TriangleCrossing>& out)
      : pose_(pose), filter_(filter), out_(out) {}

  void add(const TraversalTask& task, CandidatePair pair) {
    set(0, task.object_a, pair.a, false);
    set(1, task.object_b, pair.b, task.object_a != task.object_b);
    waiting_[count_] = {&task, pair};
    if (++count_ == waiting_.size()) finish();
  }
  void finish() {
    const unsigned separated = separated_triangles(lanes_);
    for (unsigned k = 0; k < count_; ++k) {
      if ((separated >> k & 1) == 0) test_pair(pose_, *waiting_[k].task, waiting_[k].pair, filter_, out_);
    }
    count_ = 0;
  }

 private:
  struct Waiting {
    const TraversalTask* task;
    CandidatePair pair;
  };

  // Vertices of another object are numbered -1, -2 and so on.
  void set(int side, Index object, Index triangle, bool is_other_object) {
    const Hierarchy& h = pose_.motion.hierarchy(object);
    const Triangle& corners = h.triangles()[triangle];
    for (int k = 0; k < 3; ++k) {
      const double number = corners[k];
      lanes_.set(static_cast<int>(count_), side, k, position(pose_.x[object], h.vertex_ids()[corners[k]]),
                 is_other_object ? -1 - number : number);
    }
  }

  TrianglePairs lanes_{};
  const Pose& pose_;
  const Filter& filter_;
  std::vector<TriangleCrossing>& out_;
  std::array<Waiting, 8> waiting_;
  unsigned count_ = 0;
};

struct ById {
  bool operator()(const TriangleCrossing& a, const TriangleCrossing& b) const {
    return std::tie(a.object_a, a.triangle_a, a.object_b, a.triangle_b) <
           std::tie(b.object_a, b.triangle_a, b.object_b, b.triangle_b);
  }
};

// Counts crossings of all copies of triangles and lists those with the smallest ids. Copies are added in the
// order of their ids, so all others can be skipped once one is not listed.
class Crossings {
 public:
  Crossings(DistinctObjects distinct, std::uint64_t max_listed, StaticResult& out)
      : distinct_(distinct), out_(out), list_(out.crossings, max_listed, ById{}) {}

  void add(const TriangleCrossing& c) {
    const auto a = copies(c.object_a, c.triangle_a), b = copies(c.object_b, c.triangle_b);
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

  // Adds every pair of copies of a triangle.
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
  // Precondition: `triangle` outlives the result.
  std::span<const Index> copies(Index object, const Index& triangle) const {
    return distinct_.empty() || !distinct_[object]->has_copies() ? std::span(&triangle, 1)
                                                                 : distinct_[object]->copies(triangle);
  }

  // In the order of the smaller id of each pair.
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
  SmallestK<TriangleCrossing, ById> list_;
};

// Adds the crossings of triangles with their own copies.
void add_all_copies(const Pose& pose, const Filter& filter, Crossings& out) {
  for (Index object = 0; object < filter.distinct.size(); ++object) {
    if (pose.is_layered(object)) continue;
    const DistinctTriangles& distinct = *filter.distinct[object];
    for (const Index t : distinct.repeated()) {
      if (filter.crossing(object, t, object, t) &&
          copies_cross(pose.motion.hierarchy(object).topology().triangles()[t]))
        out.add_copies(object, distinct.copies(t));
    }
  }
}

}  // namespace

Result<void> check_pose(const Query& query, Positions x, const StepSettings& settings, StaticResult& out) {
  Pipeline& pipeline = query.pipeline;
  StepMotion& motion = pipeline.motion;
  out.complete = false;
  out.crossings.clear();
  out.crossing_count = 0;
  out.work = {};
  out.milliseconds = {};
  FOLDPROOF_TRY(check_settings(settings, motion.size()));

  const auto update = [&]() -> Result<void> {
    FOLDPROOF_TRY(motion.update(x, x));
    out.work.refits = motion.size();
    return {};
  };
  const auto search = [&] { return pipeline.find_leaf_pairs(settings, 0, out.work); };
  const auto narrow = [&]() -> Result<void> {
    const Pose pose{motion, x, query.objects};
    const BroadPhase& found = pipeline.broad_phase;
    Crossings crossings(pipeline.filter.distinct, settings.max_listed, out);
    const auto test = [&](std::span<const TaskLeaves> pairs, Hits& hits) {
      std::vector<CandidatePair>& faces =
          pipeline.narrow.candidates.local().candidates[FeaturePair::VertexFace];
      CrossingTest crossing_test(pose, pipeline.filter, hits.crossings);
      for (const TaskLeaves& pair : pairs) {
        const TraversalTask& task = found.tasks()[pair.task];
        faces.clear();
        find_face_pairs(task.traversal, pair.leaves, faces);
        for (const CandidatePair both : faces) crossing_test.add(task, both);
      }
      crossing_test.finish();
    };
    const auto add = [&](const Hits& hits) {
      for (const TriangleCrossing& crossing : hits.crossings) crossings.add(crossing);
    };
    const auto is_done = [&] { return query.any_will_do && out.crossing_count > 0; };
    in_chunks(found.leaf_pairs(), kChunk, pipeline.narrow.hits, test, add, is_done);
    if (settings.within) add_all_copies(pose, pipeline.filter, crossings);
    crossings.finish();
    return {};
  };
  FOLDPROOF_TRY(run_stages(out.milliseconds, update, search, narrow));
  if (settings.explain) pipeline.explain(out.explanation);
  out.complete = true;
  return {};
}

}  // namespace foldproof::internal
