// Pairs of features that may be close.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/parallel.h"
#include "base/stopwatch.h"
#include "base/try.h"
#include "solver/contact_checker.h"

namespace foldproof {
namespace {

template <class Pair>
void append_to(const std::vector<Pair>& from, std::vector<Pair>& to) {
  to.insert(to.end(), from.begin(), from.end());
}

Result<void> check_bound(const char* name, double value) {
  if (value >= 0) return {};  // not NaN
  return fail(ErrorCode::InvalidArgument, name, "is not a length",
              "give a number of at least 0, or infinity");
}

}  // namespace

void Candidates::clear() {
  vertex_face.clear();
  edge_edge.clear();
  edge_vertex.clear();
  vertex_vertex.clear();
}

Result<void> ContactChecker::Impl::check_positions(std::span<const double> x0, std::span<const double> x1) {
  const std::span<const double> from[] = {x0}, to[] = {x1};
  return run([&](const Pipeline& used) { return used.motion.check(from, to); });
}

template <int Ends, class Process, class Merge>
Result<void> ContactChecker::Impl::find(CandidateLists<Ends>& lists, std::span<const double> x0,
                                        std::span<const double> x1, double distance, Process process,
                                        Merge merge) {
  constexpr std::size_t kRowsPerPart = 64, kPartsPerRound = 32;
  const PlainArithmetic plain;
  Stopwatch total, watch;
  FOLDPROOF_TRY(check_positions(x0, x1));
  milliseconds.update += watch.lap();
  std::array<const double*, Ends> ends{x0.data()};
  ends.back() = x1.data();
  lists.update(ends, distance, work);
  milliseconds.traverse += watch.lap();
  for (std::size_t done = 0; done < lists.row_count(); done += kRowsPerPart * kPartsPerRound) {
    const std::size_t remaining = lists.row_count() - done;
    const std::size_t count = std::min(kPartsPerRound, (remaining + kRowsPerPart - 1) / kRowsPerPart);
    parts.resize(std::max(parts.size(), count));
    parallel_for(std::size_t{0}, count, [&](std::size_t k) {
      const std::size_t begin = done + k * kRowsPerPart;
      parts[k].pairs.clear();
      lists.find({begin, std::min(begin + kRowsPerPart, lists.row_count())}, parts[k].pairs);
      process(parts[k]);
    });
    for (const Part& part : std::span(parts).first(count)) {
      work.candidates_vf += part.vertex_pairs;
      work.candidates_ee += part.edge_pairs;
      merge(part);
    }
  }
  milliseconds.narrow += watch.lap();
  milliseconds.total += total.lap();
  return {};
}

void ContactChecker::Impl::measure(Part& part, double distance, std::span<const std::uint8_t> active) const {
  const PosedFeatures features{*mesh, pose_lists.points()};
  const auto is_active = [&](Index vertex) { return vertex != kNoIndex && active[vertex] != 0; };
  const auto in_leaf_order = [&](Index v) { return is_active(mesh->hierarchy()->vertex_ids()[v]); };
  part.of_kind[0].clear();
  part.of_kind[1].clear();
  for (const BoxPair pair : part.pairs) {
    if (active.empty() || std::ranges::any_of(features.corners(pair), in_leaf_order))
      part.of_kind[features.is_edge_edge(pair) ? 1 : 0].push_back(pair);
  }
  part.vertex_pairs = part.of_kind[0].size();
  part.edge_pairs = part.of_kind[1].size();
  part.close.clear();
  for (const auto& pairs : part.of_kind) {
    visit_distances(
        features, pairs, [&] { return distance; },
        [&](BoxPair pair, const NearestBatch& nearest, int lane) {
          const ClosePair close = close_pair(features, pair, nearest, lane);
          if (active.empty() || std::ranges::any_of(close.vertices, is_active)) part.close.push_back(close);
        });
  }
}

Result<void> ContactChecker::candidates(std::span<const double> x0, std::span<const double> x1,
                                        double inflation, Candidates& out) {
  impl_->start_call();
  out.clear();
  FOLDPROOF_TRY(check_length("inflation", inflation));
  const auto find = [&](auto& lists) {
    const auto translate = [&](Impl::Part& part) {
      part.candidates.clear();
      lists.append(part.pairs, part.candidates);
      part.edge_pairs = part.candidates.edge_edge.size();
      part.vertex_pairs = part.candidates.size() - part.edge_pairs;
    };
    const auto append = [&](const Impl::Part& part) {
      append_to(part.candidates.vertex_face, out.vertex_face);
      append_to(part.candidates.edge_edge, out.edge_edge);
      append_to(part.candidates.edge_vertex, out.edge_vertex);
      append_to(part.candidates.vertex_vertex, out.vertex_vertex);
    };
    return isolated([&] { return impl_->find(lists, x0, x1, inflation, translate, append); });
  };
  const bool pose = x0.data() == x1.data();
  return pose ? find(impl_->pose_lists) : find(impl_->step_lists);
}

Result<void> ContactChecker::candidates(std::span<const double> x, double inflation, Candidates& out) {
  return candidates(x, x, inflation, out);
}

Result<void> ContactChecker::close_pairs(std::span<const double> x, double distance,
                                         std::vector<ClosePair>& out, std::span<const std::uint8_t> active) {
  impl_->start_call();
  out.clear();
  FOLDPROOF_TRY(check_bound("distance", distance));
  if (!active.empty() && active.size() != mesh().vertex_count()) {
    return fail(ErrorCode::InvalidArgument, "active", fmt::format("has {} numbers", active.size()),
                fmt::format("give one for each of the {} vertices, or none", mesh().vertex_count()));
  }
  const auto measure = [&](Impl::Part& part) { impl_->measure(part, distance, active); };
  const auto append = [&](const Impl::Part& part) { append_to(part.close, out); };
  FOLDPROOF_TRY(isolated([&] { return impl_->find(impl_->pose_lists, x, x, distance, measure, append); }));
  merge_close_pairs(out, impl_->close_pair_table);
  return {};
}

Result<double> ContactChecker::minimum_distance(std::span<const double> x, double bound) {
  const PlainArithmetic plain;
  Stopwatch total;
  impl_->start_call();
  FOLDPROOF_TRY(check_bound("bound", bound));
  FOLDPROOF_TRY(impl_->check_positions(x, x));
  const double distance = isolated([&] { return impl_->pose_lists.nearest(x.data(), bound, impl_->work); });
  impl_->milliseconds.total = total.lap();
  return distance;
}

}  // namespace foldproof
