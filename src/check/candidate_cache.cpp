#include "check/candidate_cache.h"

#include <algorithm>
#include <optional>

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

  void add(const Traversal& traversal, CandidatePair pair, ContactInterval& interval) {
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

// A time interval in units of ContactInterval, which may extend beyond the motion.
struct UnitInterval {
  int begin, end;
  bool meets(const ContactInterval& other) const { return other.begin <= end && other.end >= begin; }
};

}  // namespace

void CandidateCache::find_intervals(std::span<const TraversalTask> tasks, double distance, Part& part) {
  for (const FeaturePair kind : kFeaturePairs)
    part.intervals[kind].resize(part.found.candidates[kind].size());
  PerKind<std::optional<IntervalTightener>> tighteners;
  for (const FeaturePair kind : kFeaturePairs) tighteners[kind].emplace(kind, distance);
  part.found.for_each(
      [&](const CandidateRuns::Run& run, FeaturePair kind, std::size_t begin, std::size_t end) {
        const Traversal& traversal = tasks[run.task].traversal;
        const std::span pairs = std::span(part.found.candidates[kind]).subspan(begin, end - begin);
        auto& intervals = part.intervals[kind];
        find_contact_intervals(traversal, kind, pairs, intervals.data() + begin);
        for (std::size_t k = begin; k < end; ++k) {
          if (!intervals[k].is_empty()) tighteners[kind]->add(traversal, pairs[k - begin], intervals[k]);
        }
      });
  for (const FeaturePair kind : kFeaturePairs) tighteners[kind]->finish();
}

void CandidateCache::drop_empty(Part& part) {
  for (const FeaturePair kind : kFeaturePairs) {
    auto& candidates = part.found.candidates[kind];
    auto& intervals = part.intervals[kind];
    std::size_t k = 0, kept = 0;
    for (CandidateRuns::Run& run : part.found.runs) {
      for (; k < run.ends[kind]; ++k) {
        candidates[kept] = candidates[k];
        intervals[kept] = intervals[k];
        kept += static_cast<std::size_t>(!intervals[k].is_empty());
      }
      run.ends[kind] = kept;
    }
    candidates.resize(kept);
    intervals.resize(kept);
  }
}

void CandidateCache::fill(std::span<const TraversalTask> tasks, std::span<const TaskLeaves> pairs,
                          double distance) {
  count_ = (pairs.size() + kChunk - 1) / kChunk;
  if (parts_.size() < count_) parts_.resize(count_);
  parallel_for(std::size_t{0}, count_, [&](std::size_t i) {
    const std::size_t begin = i * kChunk;
    find_candidates(tasks, pairs.subspan(begin, std::min(kChunk, pairs.size() - begin)), parts_[i].found);
    find_intervals(tasks, distance, parts_[i]);
    drop_empty(parts_[i]);
  });
}

void CandidateCache::test(const NarrowStep& step, const float (&times)[2], NarrowScratch& scratch,
                          StepResult& out) const {
  // One unit more at both ends covers the rounding of the times.
  const UnitInterval interval{static_cast<int>(std::min(times[0], times[1]) * ContactInterval::kUnits) - 1,
                              static_cast<int>(std::max(times[0], times[1]) * ContactInterval::kUnits) + 1};
  const auto test = [&](std::span<const Part> part, Hits& hits) {
    CandidateRuns& selected = scratch.candidates.local();
    selected.clear();
    const CandidateRuns& found = part[0].found;
    selected.runs = found.runs;
    for (const FeaturePair kind : kFeaturePairs)
      selected.candidates[kind].resize(found.candidates[kind].size());
    PerKind<std::size_t> counts{};
    std::size_t list = 0;
    found.for_each([&](const CandidateRuns::Run&, FeaturePair kind, std::size_t begin, std::size_t end) {
      const auto& candidates = found.candidates[kind];
      const auto& intervals = part[0].intervals[kind];
      auto& kept = selected.candidates[kind];
      std::size_t& count = counts[kind];
      for (std::size_t k = begin; k < end; ++k) {
        kept[count] = candidates[k];
        count += static_cast<std::size_t>(interval.meets(intervals[k]));
      }
      selected.runs[list++ / kFeaturePairs.size()].ends[kind] = counts[kind];
    });
    for (const FeaturePair kind : kFeaturePairs) selected.candidates[kind].resize(counts[kind]);
    test_candidates(step, selected, hits);
  };
  in_chunks(std::span(parts_).first(count_), 1, scratch.hits, test,
            [&](const Hits& hits) { add_collisions(step, hits, out); });
}

}  // namespace foldproof::internal
