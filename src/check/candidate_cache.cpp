#include "check/candidate_cache.h"

#include <algorithm>

#include "base/parallel.h"
#include "check/answer.h"
#include "check/pair_lanes.h"

namespace foldproof::internal {
namespace {

// Shortens contact intervals: a few iterations of the narrow phase may prove that the features of a candidate
// stay farther apart than a distance at first, or during the whole motion.
class IntervalTightener {
 public:
  IntervalTightener(FeaturePair kind, double distance)
      : lanes_(kind == FeaturePair::EdgeEdge, settings(distance), nullptr, Report{}), kind_(kind) {}

  void add(const Traversal& traversal, CandidateBuffer::Pair pair, ContactInterval& interval) {
    const KineticBvh &a = *traversal.a, &b = *traversal.b;
    const Hierarchy &ha = *a.hierarchy, &hb = *b.hierarchy;
    if (kind_ == FeaturePair::EdgeEdge) {
      set_points(a, 0, ha.edges()[pair.a]);
      set_points(b, 2, hb.edges()[pair.b]);
    } else if (kind_ == FeaturePair::VertexFace) {
      set_points(a, 0, std::array<Index, 1>{pair.a});
      set_points(b, 1, hb.triangles()[pair.b]);
    } else {
      set_points(b, 0, std::array<Index, 1>{pair.b});
      set_points(a, 1, ha.triangles()[pair.a]);
    }
    lanes_.add(&interval);
  }

  void finish() { lanes_.finish(); }

 private:
  // Whatever the answer, nothing touches before its time.
  struct Report {
    void operator()(ContactInterval* interval, const CcdResult& result) const {
      if (result.answer == Answer::Separated) {
        *interval = ContactInterval::none();
      } else {
        const auto begin = static_cast<std::uint8_t>(result.toi * ContactInterval::kUnits);
        interval->begin = std::max(interval->begin, begin);
      }
    }
  };

  // More than two iterations cost more than they save in the steps.
  static CcdSettings settings(double distance) {
    CcdSettings out;
    out.thickness = distance;
    out.tolerance = distance / 64;
    out.max_iterations = 2;
    return out;
  }

  template <class Feature>
  void set_points(const KineticBvh& bvh, int point, const Feature& feature) {
    for (const Index vertex : feature) {
      double ends[2][3];
      for (int axis = 0; axis < 3; ++axis) {
        for (int end = 0; end < 2; ++end) ends[end][axis] = bvh.vertices[vertex].x[4 * end + axis];
      }
      lanes_.set_point(point++, ends[0], ends[1]);
    }
  }

  PairLanes<ContactInterval*, Report> lanes_;
  FeaturePair kind_;
};

// Visits each kind of candidates: the members of CandidateBuffer, ContactIntervals, Lists and Ends.
template <class Visit>
void for_each_kind(Visit visit) {
  visit(FeaturePair::VertexFace, &CandidateBuffer::vertex_face, &Chunk::ContactIntervals::vertex_face,
        &CandidateCache::Lists::vertex_face, &Chunk::Ends::vertex_face);
  visit(FeaturePair::FaceVertex, &CandidateBuffer::face_vertex, &Chunk::ContactIntervals::face_vertex,
        &CandidateCache::Lists::face_vertex, &Chunk::Ends::face_vertex);
  visit(FeaturePair::EdgeEdge, &CandidateBuffer::edge_edge, &Chunk::ContactIntervals::edge_edge,
        &CandidateCache::Lists::edge_edge, &Chunk::Ends::edge_edge);
}

void find_intervals(std::span<const TraversalTask> tasks, double distance, Chunk& chunk) {
  for_each_kind([&](FeaturePair kind, auto candidates_of, auto intervals_of, auto, auto end_of) {
    const auto& candidates = chunk.candidates.*candidates_of;
    auto& intervals = chunk.intervals.*intervals_of;
    intervals.resize(candidates.size());
    IntervalTightener tightener(kind, distance);
    std::size_t k = 0;
    for (std::size_t i = 0; i < chunk.pairs.size(); ++i) {
      const Traversal& traversal = tasks[chunk.pairs[i].task].traversal;
      const std::size_t end = chunk.ends[i].*end_of;
      find_contact_intervals(traversal, kind, std::span(candidates).subspan(k, end - k),
                             intervals.data() + k);
      for (; k < end; ++k) {
        if (!intervals[k].is_empty()) tightener.add(traversal, candidates[k], intervals[k]);
      }
    }
    tightener.finish();
  });
}

// Appends the candidates of a chunk whose intervals are not empty.
void append(const Chunk& chunk, CandidateCache::Lists& lists) {
  const std::size_t first = lists.ends.size();
  lists.ends.resize(first + chunk.ends.size());
  for_each_kind([&](FeaturePair, auto candidates_of, auto intervals_of, auto list_of, auto end_of) {
    const auto& candidates = chunk.candidates.*candidates_of;
    const auto& intervals = chunk.intervals.*intervals_of;
    auto& list = lists.*list_of;
    for (std::size_t i = 0, k = 0; i < chunk.ends.size(); ++i) {
      for (; k < chunk.ends[i].*end_of; ++k) {
        if (!intervals[k].is_empty()) list.push_back({candidates[k], intervals[k]});
      }
      lists.ends[first + i].*end_of = list.size();
    }
  });
}

// A time interval in units of ContactInterval, which may extend beyond the motion.
struct UnitInterval {
  int begin, end;
};

// Copies the candidates that may touch in the interval to a chunk. `first`: the number of its first pair of
// leaves.
void select(const CandidateCache::Lists& lists, std::size_t first, const UnitInterval& interval,
            Chunk& chunk) {
  chunk.ends.resize(chunk.pairs.size());
  for_each_kind([&](FeaturePair, auto candidates_of, auto, auto list_of, auto end_of) {
    const auto& list = lists.*list_of;
    auto& selected = chunk.candidates.*candidates_of;
    std::size_t k = first > 0 ? lists.ends[first - 1].*end_of : 0, count = 0;
    selected.resize(lists.ends[first + chunk.pairs.size() - 1].*end_of - k);
    for (std::size_t i = 0; i < chunk.pairs.size(); ++i) {
      for (; k < lists.ends[first + i].*end_of; ++k) {
        selected[count] = list[k].pair;
        count += static_cast<std::size_t>(list[k].interval.begin <= interval.end &&
                                          list[k].interval.end >= interval.begin);
      }
      chunk.ends[i].*end_of = count;
    }
    selected.resize(count);
  });
}

}  // namespace

void CandidateCache::fill(std::span<const TraversalTask> tasks, std::span<const LeafPair> pairs,
                          double distance, std::vector<Chunk>& chunks) {
  pairs_ = pairs;
  for_each_kind([&](FeaturePair, auto, auto, auto list_of, auto) { (lists_.*list_of).clear(); });
  lists_.ends.clear();
  in_rounds(pairs, chunks, [&](std::size_t count) {
    parallel_for(std::size_t{0}, count, [&](std::size_t i) {
      find_candidates(tasks, chunks[i]);
      find_intervals(tasks, distance, chunks[i]);
    });
    for (const Chunk& chunk : std::span(chunks).first(count)) append(chunk, lists_);
  });
}

void CandidateCache::test(const NarrowStep& step, const float (&times)[2], std::vector<Chunk>& chunks,
                          StepResult& out) const {
  // One unit more at both ends covers the rounding of the times.
  const UnitInterval interval{static_cast<int>(std::min(times[0], times[1]) * ContactInterval::kUnits) - 1,
                              static_cast<int>(std::max(times[0], times[1]) * ContactInterval::kUnits) + 1};
  in_rounds(pairs_, chunks, [&](std::size_t count) {
    parallel_for(std::size_t{0}, count, [&](std::size_t i) {
      Chunk& chunk = chunks[i];
      select(lists_, static_cast<std::size_t>(chunk.pairs.data() - pairs_.data()), interval, chunk);
      test_candidates(step, chunk);
    });
    for (Chunk& chunk : std::span(chunks).first(count)) add_collisions(step, chunk, out);
  });
}

}  // namespace foldproof::internal
