// Pairs of features that may be near each other.

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/parallel.h"
#include "solver/contact_checker.h"

namespace foldproof {
namespace {

template <class Pair>
void append(const std::vector<Pair>& from, std::vector<Pair>& to) {
  to.insert(to.end(), from.begin(), from.end());
}

Result<void> check_length(const char* name, double value) {
  if (!(value >= 0) || !std::isfinite(value))
    return fail(name, "is not a length", "give a number of at least 0");
  return {};
}

// minimum_distance looks this far first, as a share of the bound, and each time this much farther.
constexpr double kFirstLook = 1.0 / 256, kFarther = 4;

}  // namespace

void Candidates::clear() {
  vertex_face.clear();
  edge_edge.clear();
  edge_vertex.clear();
  vertex_vertex.clear();
}

template <class Look, class Take>
Result<void> ContactChecker::Impl::find(std::span<const double> x0, std::span<const double> x1,
                                        double distance, Look look, Take take) {
  constexpr std::size_t kRowsPerPart = 64, kPartsPerRound = 32;
  const PlainArithmetic plain;
  Stopwatch total, watch;
  const std::span<const double> from[] = {x0}, to[] = {x1};
  if (auto ok = pipeline.motion.check(from, to); !ok) return ok;
  milliseconds.update += watch.lap();
  const auto search = [&](auto& lists, auto ends) {
    lists.update(ends, distance, work);
    milliseconds.traverse += watch.lap();
    for (std::size_t done = 0; done < lists.row_count(); done += kRowsPerPart * kPartsPerRound) {
      const std::size_t left = lists.row_count() - done;
      const std::size_t count = std::min(kPartsPerRound, (left + kRowsPerPart - 1) / kRowsPerPart);
      parts.resize(std::max(parts.size(), count));
      parallel_for(std::size_t{0}, count, [&](std::size_t k) {
        const std::size_t begin = done + k * kRowsPerPart;
        parts[k].found.clear();
        lists.find({begin, std::min(begin + kRowsPerPart, lists.row_count())}, parts[k].scratch,
                   parts[k].found);
        look(parts[k]);
      });
      for (const Part& part : std::span(parts).first(count)) {
        work.candidates_vf += part.found.size() - part.found.edge_edge.size();
        work.candidates_ee += part.found.edge_edge.size();
        take(part);
      }
    }
  };
  if (x0.data() == x1.data()) {
    search(of_pose, std::array{x0.data()});
  } else {
    search(of_step, std::array{x0.data(), x1.data()});
  }
  milliseconds.narrow += watch.lap();
  milliseconds.total += total.lap();
  return {};
}

double ContactChecker::Impl::least_distance(const Candidates& found, std::span<const double> x) const {
  double least = std::numeric_limits<double>::infinity();
  const auto at = [&](Index v) { return position(x, v); };
  const auto near_face = [&](Index v, const Triangle& t) {
    least = std::min(least, vertex_face_closest({at(v), at(t[0]), at(t[1]), at(t[2])}).distance);
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
    least = std::min(least, edge_edge_closest({at(a[0]), at(a[1]), at(b[0]), at(b[1])}).distance);
  }
  return least;
}

Result<void> ContactChecker::candidates(std::span<const double> x0, std::span<const double> x1,
                                        double inflation, Candidates& out) {
  impl_->begin();
  out.clear();
  if (auto ok = check_length("inflation", inflation); !ok) return ok;
  return impl_->find(
      x0, x1, inflation, [](const auto&) {},
      [&](const auto& part) {
        append(part.found.vertex_face, out.vertex_face);
        append(part.found.edge_edge, out.edge_edge);
        append(part.found.edge_vertex, out.edge_vertex);
        append(part.found.vertex_vertex, out.vertex_vertex);
      });
}

Result<void> ContactChecker::candidates(std::span<const double> x, double inflation, Candidates& out) {
  return candidates(x, x, inflation, out);
}

Result<double> ContactChecker::minimum_distance(std::span<const double> x, double bound) {
  const PlainArithmetic plain;
  impl_->begin();
  if (auto ok = check_length("bound", bound); !ok) return tl::unexpected(ok.error());
  // Among the last denormal numbers a share of the bound would round to zero, and stay there.
  const double first = std::min(bound, std::max(bound * kFirstLook, std::numeric_limits<double>::min()));
  for (double reach = first;; reach = std::min(bound, reach * kFarther)) {
    double least = std::numeric_limits<double>::infinity();
    const auto found = impl_->find(
        x, x, reach, [&](auto& part) { part.least = impl_->least_distance(part.found, x); },
        [&](const auto& part) { least = std::min(least, part.least); });
    if (!found) return tl::unexpected(found.error());
    if (least <= reach) return least;
    if (reach >= bound) return std::numeric_limits<double>::infinity();
  }
}

}  // namespace foldproof
