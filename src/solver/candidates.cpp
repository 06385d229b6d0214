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

void ContactChecker::Impl::choose(CandidateChunk& chunk) const {
  const Hierarchy& h = *mesh->hierarchy();
  const auto topology_edges = h.topology().edges();
  chunk.found.clear();
  for (const auto& pair : chunk.boxes.vertex_face) {
    const Index vertex = h.vertex_ids()[pair.a], triangle = h.triangle_ids()[pair.b];
    if (!choice.vertex_face(vertex, triangle)) continue;
    switch (choice.element(triangle)) {
      case Element::Face:
        chunk.found.vertex_face.push_back({vertex, triangle});
        break;
      case Element::Edge:
        chunk.found.edge_vertex.push_back({choice.codim_edge(triangle), vertex});
        break;
      case Element::Point:
        chunk.found.vertex_vertex.push_back({vertex, choice.codim_point(triangle)});
        break;
    }
  }
  for (const auto& pair : chunk.boxes.edge_edge) {
    const Index a = h.edge_ids()[pair.a], b = h.edge_ids()[pair.b];
    if (!choice.edge_edge(topology_edges[a], topology_edges[b])) continue;
    const Index row_a = mesh->edge_of(a), row_b = mesh->edge_of(b);
    chunk.found.edge_edge.push_back({std::min(row_a, row_b), std::max(row_a, row_b)});
  }
}

template <class Look, class Take>
Result<void> ContactChecker::Impl::find(std::span<const double> x0, std::span<const double> x1,
                                        double distance, Look look, Take take) {
  const PlainArithmetic plain;
  Stopwatch total, watch;
  StepSettings step_settings = this->step_settings(0);
  step_settings.certificates = settings.certify_candidates;
  const std::span<const double> from[] = {x0}, to[] = {x1};
  if (auto ok = near.update(from, to, step_settings); !ok) return ok;
  milliseconds.update += watch.lap();
  near.traverse(step_settings, distance, work);
  milliseconds.traverse += watch.lap();
  in_rounds(near.leaf_pairs(), candidate_chunks, [&](std::size_t count) {
    parallel_for(std::size_t{0}, count, [&](std::size_t i) {
      CandidateChunk& chunk = candidate_chunks[i];
      chunk.boxes.clear();
      for (const LeafPairRef& pair : chunk.pairs)
        find_candidates(near.tasks()[pair.task].traversal, pair.leaves, chunk.boxes);
      choose(chunk);
      look(chunk);
    });
    for (const CandidateChunk& chunk : std::span(candidate_chunks).first(count)) {
      work.candidates_vf += chunk.found.size() - chunk.found.edge_edge.size();
      work.candidates_ee += chunk.found.edge_edge.size();
      take(chunk);
    }
  });
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
  auto found = impl_->find(
      x0, x1, inflation, [](CandidateChunk&) {},
      [&](const CandidateChunk& chunk) {
        append(chunk.found.vertex_face, out.vertex_face);
        append(chunk.found.edge_edge, out.edge_edge);
        append(chunk.found.edge_vertex, out.edge_vertex);
        append(chunk.found.vertex_vertex, out.vertex_vertex);
      });
  if (!found) return found;
  std::sort(out.vertex_face.begin(), out.vertex_face.end());
  std::sort(out.edge_edge.begin(), out.edge_edge.end());
  std::sort(out.edge_vertex.begin(), out.edge_vertex.end());
  std::sort(out.vertex_vertex.begin(), out.vertex_vertex.end());
  return {};
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
        x, x, reach, [&](CandidateChunk& chunk) { chunk.least = impl_->least_distance(chunk.found, x); },
        [&](const CandidateChunk& chunk) { least = std::min(least, chunk.least); });
    if (!found) return tl::unexpected(found.error());
    if (least <= reach) return least;
    if (reach >= bound) return std::numeric_limits<double>::infinity();
  }
}

}  // namespace foldproof
