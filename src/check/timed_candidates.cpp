#include "check/timed_candidates.h"

#include <algorithm>

#include "base/parallel.h"
#include "check/answer.h"
#include "check/pair_lanes.h"

namespace foldproof {
namespace {

// Parts of the motion that a step touches.
struct Parts {
  int first, last;
};

// Looks at candidates, and lets their meetings begin later where the narrow phase shows at little cost that
// they do not come within a distance before.
class Lookout {
 public:
  Lookout(FeaturePair kind, double distance)
      : lanes_(kind == FeaturePair::EdgeEdge, settings(distance), nullptr, Note{}), kind_(kind) {}

  void add(const Traversal& traversal, CandidateBuffer::Pair pair, Meeting& meeting) {
    const KineticTree &a = *traversal.a, &b = *traversal.b;
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
    lanes_.add(&meeting);
  }

  void finish() { lanes_.finish(); }

 private:
  // Nothing touches before the time of a result, whatever its answer.
  struct Note {
    void operator()(Meeting* meeting, const CcdResult& result) const {
      if (result.answer == Answer::Separated) {
        *meeting = Meeting::never();
      } else {
        const auto begin = static_cast<std::uint8_t>(result.toi * Meeting::kParts);
        meeting->begin = std::max(meeting->begin, begin);
      }
    }
  };

  // Whoever is not settled in two looks is left to the steps.
  static CcdSettings settings(double distance) {
    CcdSettings out;
    out.thickness = distance;
    out.tolerance = distance / 64;
    out.max_iterations = 2;
    return out;
  }

  template <class Places>
  void set_points(const KineticTree& tree, int point, const Places& places) {
    for (const Index place : places) {
      double ends[2][3];
      for (int axis = 0; axis < 3; ++axis) {
        for (int end = 0; end < 2; ++end) ends[end][axis] = tree.vertices[place].x[4 * end + axis];
      }
      lanes_.set_point(point++, ends[0], ends[1]);
    }
  }

  PairLanes<Meeting*, Note> lanes_;
  FeaturePair kind_;
};

// Visits each kind of candidates: in a buffer, their meetings in a chunk, all that are kept, and their ends.
template <class Visit>
void each_kind(Visit visit) {
  visit(FeaturePair::VertexFace, &CandidateBuffer::vertex_face, &Chunk::Meetings::vertex_face,
        &TimedCandidates::All::vertex_face, &Chunk::Ends::vertex_face);
  visit(FeaturePair::FaceVertex, &CandidateBuffer::face_vertex, &Chunk::Meetings::face_vertex,
        &TimedCandidates::All::face_vertex, &Chunk::Ends::face_vertex);
  visit(FeaturePair::EdgeEdge, &CandidateBuffer::edge_edge, &Chunk::Meetings::edge_edge,
        &TimedCandidates::All::edge_edge, &Chunk::Ends::edge_edge);
}

void find_all_meetings(std::span<const TraversalTask> tasks, double distance, Chunk& chunk) {
  each_kind([&](FeaturePair kind, auto candidates, auto times, auto, auto end) {
    const auto& found = chunk.candidates.*candidates;
    auto& meetings = chunk.meetings.*times;
    meetings.resize(found.size());
    Lookout lookout(kind, distance);
    std::size_t begin = 0;
    for (std::size_t i = 0; i < chunk.pairs.size(); ++i) {
      const Traversal& traversal = tasks[chunk.pairs[i].task].traversal;
      const std::size_t to = chunk.ends[i].*end;
      find_meetings(traversal, kind, std::span(found).subspan(begin, to - begin), meetings.data() + begin);
      for (; begin < to; ++begin) {
        if (meetings[begin].ever()) lookout.add(traversal, found[begin], meetings[begin]);
      }
    }
    lookout.finish();
  });
}

void keep(const Chunk& chunk, TimedCandidates::All& all) {
  const std::size_t first = all.ends.size();
  all.ends.resize(first + chunk.ends.size());
  each_kind([&](FeaturePair, auto candidates, auto times, auto kept, auto end) {
    const auto& found = chunk.candidates.*candidates;
    const auto& meetings = chunk.meetings.*times;
    auto& list = all.*kept;
    for (std::size_t i = 0, k = 0; i < chunk.ends.size(); ++i) {
      for (; k < chunk.ends[i].*end; ++k) {
        if (meetings[k].ever()) list.push_back({found[k], meetings[k]});
      }
      all.ends[first + i].*end = list.size();
    }
  });
}

// Those of the pairs of leaves from number `first` on that may meet between two parts of the motion.
void choose(const TimedCandidates::All& all, std::size_t first, const Parts& parts, Chunk& chunk) {
  chunk.ends.resize(chunk.pairs.size());
  each_kind([&](FeaturePair, auto candidates, auto, auto kept, auto end) {
    const auto& list = all.*kept;
    auto& chosen = chunk.candidates.*candidates;
    std::size_t k = first > 0 ? all.ends[first - 1].*end : 0, count = 0;
    chosen.resize(all.ends[first + chunk.pairs.size() - 1].*end - k);
    for (std::size_t i = 0; i < chunk.pairs.size(); ++i) {
      for (; k < all.ends[first + i].*end; ++k) {
        chosen[count] = list[k].pair;
        count += static_cast<std::size_t>(list[k].meeting.begin <= parts.last &&
                                          list[k].meeting.end >= parts.first);
      }
      chunk.ends[i].*end = count;
    }
    chosen.resize(count);
  });
}

}  // namespace

void TimedCandidates::gather(std::span<const TraversalTask> tasks, std::span<const LeafPairRef> pairs,
                             double distance, std::vector<Chunk>& chunks) {
  pairs_ = pairs;
  each_kind([&](FeaturePair, auto, auto, auto kept, auto) { (all_.*kept).clear(); });
  all_.ends.clear();
  in_rounds(pairs, chunks, [&](std::size_t count) {
    parallel_for(std::size_t{0}, count, [&](std::size_t i) {
      foldproof::gather(tasks, chunks[i]);
      find_all_meetings(tasks, distance, chunks[i]);
    });
    for (const Chunk& chunk : std::span(chunks).first(count)) keep(chunk, all_);
  });
}

void TimedCandidates::test(const NarrowStep& step, const float (&times)[2], std::vector<Chunk>& chunks,
                           StepResult& out) const {
  // A part more at both ends, for what rounding did to the times.
  const Parts parts{static_cast<int>(std::min(times[0], times[1]) * Meeting::kParts) - 1,
                    static_cast<int>(std::max(times[0], times[1]) * Meeting::kParts) + 1};
  in_rounds(pairs_, chunks, [&](std::size_t count) {
    parallel_for(std::size_t{0}, count, [&](std::size_t i) {
      Chunk& chunk = chunks[i];
      choose(all_, static_cast<std::size_t>(chunk.pairs.data() - pairs_.data()), parts, chunk);
      narrow(step, chunk);
    });
    for (Chunk& chunk : std::span(chunks).first(count)) take_found(step, chunk, out);
  });
}

}  // namespace foldproof
