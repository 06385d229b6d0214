// Pairs of features that may be close.

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/parallel.h"
#include "base/stopwatch.h"
#include "base/try.h"
#include "solver/contact_checker.h"

namespace foldproof {
namespace {

template <class Pair>
void append_pairs(const std::vector<Pair>& from, std::vector<Pair>& to) {
  to.insert(to.end(), from.begin(), from.end());
}

// minimum_distance starts its search with this share of the bound, and enlarges it by this factor.
constexpr double kFirstShare = 1.0 / 256, kGrowth = 4;

}  // namespace

void Candidates::clear() {
  vertex_face.clear();
  edge_edge.clear();
  edge_vertex.clear();
  vertex_vertex.clear();
}

template <class Process, class Merge>
Result<void> ContactChecker::Impl::find(std::span<const double> x0, std::span<const double> x1,
                                        double distance, Process process, Merge merge) {
  constexpr std::size_t kRowsPerPart = 64, kPartsPerRound = 32;
  const PlainArithmetic plain;
  Stopwatch total, watch;
  const std::span<const double> from[] = {x0}, to[] = {x1};
  FOLDPROOF_TRY(run([&](const Pipeline& used) { return used.motion.check(from, to); }));
  milliseconds.update += watch.lap();
  const auto search = [&](auto& lists, auto ends) {
    lists.update(ends, distance, work);
    milliseconds.traverse += watch.lap();
    for (std::size_t done = 0; done < lists.row_count(); done += kRowsPerPart * kPartsPerRound) {
      const std::size_t remaining = lists.row_count() - done;
      const std::size_t count = std::min(kPartsPerRound, (remaining + kRowsPerPart - 1) / kRowsPerPart);
      parts.resize(std::max(parts.size(), count));
      parallel_for(std::size_t{0}, count, [&](std::size_t k) {
        const std::size_t begin = done + k * kRowsPerPart;
        parts[k].found.clear();
        lists.find({begin, std::min(begin + kRowsPerPart, lists.row_count())}, parts[k].scratch,
                   parts[k].found);
        process(parts[k]);
      });
      for (const Part& part : std::span(parts).first(count)) {
        work.candidates_vf += part.found.size() - part.found.edge_edge.size();
        work.candidates_ee += part.found.edge_edge.size();
        merge(part);
      }
    }
  };
  if (x0.data() == x1.data()) {
    search(pose_lists, std::array{x0.data()});
  } else {
    search(step_lists, std::array{x0.data(), x1.data()});
  }
  milliseconds.narrow += watch.lap();
  milliseconds.total += total.lap();
  return {};
}

double ContactChecker::Impl::min_distance(const Candidates& found, std::span<const double> x) const {
  double smallest = std::numeric_limits<double>::infinity();
  const auto at = [&](Index v) { return position(x, v); };
  const auto near_face = [&](Index v, const Triangle& t) {
    smallest = std::min(smallest, vertex_face_closest({at(v), at(t[0]), at(t[1]), at(t[2])}).distance);
  };
  for (const auto& pair : found.vertex_face) near_face(pair.vertex, mesh->faces()[pair.face]);
  for (const auto& pair : found.edge_vertex) {
    const Edge& e = mesh->edges()[pair.edge];
    near_face(pair.vertex, {e[0], e[1], e[1]});
  }
  for (const auto& pair : found.vertex_vertex)
    near_face(pair.vertex_a, {pair.vertex_b, pair.vertex_b, pair.vertex_b});
  for (const auto& pair : found.edge_edge) {
    const Edge &a = mesh->edges()[pair.edge_a], &b = mesh->edges()[pair.edge_b];
    smallest = std::min(smallest, edge_edge_closest({at(a[0]), at(a[1]), at(b[0]), at(b[1])}).distance);
  }
  return smallest;
}

Result<void> ContactChecker::candidates(std::span<const double> x0, std::span<const double> x1,
                                        double inflation, Candidates& out) {
  impl_->start_call();
  out.clear();
  FOLDPROOF_TRY(check_length("inflation", inflation));
  const auto append = [&](const auto& part) {
    append_pairs(part.found.vertex_face, out.vertex_face);
    append_pairs(part.found.edge_edge, out.edge_edge);
    append_pairs(part.found.edge_vertex, out.edge_vertex);
    append_pairs(part.found.vertex_vertex, out.vertex_vertex);
  };
  const auto keep = [](const auto&) {};
  return isolated([&] { return impl_->find(x0, x1, inflation, keep, append); });
}

Result<void> ContactChecker::candidates(std::span<const double> x, double inflation, Candidates& out) {
  return candidates(x, x, inflation, out);
}

Result<double> ContactChecker::minimum_distance(std::span<const double> x, double bound) {
  const PlainArithmetic plain;
  impl_->start_call();
  FOLDPROOF_TRY(check_length("bound", bound));
  // A share of a denormal bound could round to zero, and stay there.
  const double first = std::min(bound, std::max(bound * kFirstShare, std::numeric_limits<double>::min()));
  for (double distance = first;; distance = std::min(bound, distance * kGrowth)) {
    double smallest = std::numeric_limits<double>::infinity();
    const auto measure = [&](auto& part) { part.min_distance = impl_->min_distance(part.found, x); };
    const auto take_min = [&](const auto& part) { smallest = std::min(smallest, part.min_distance); };
    FOLDPROOF_TRY(isolated([&] { return impl_->find(x, x, distance, measure, take_min); }));
    if (smallest <= distance) return smallest;
    if (distance >= bound) return std::numeric_limits<double>::infinity();
  }
}

}  // namespace foldproof
