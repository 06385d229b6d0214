#include "verify.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace foldproof::bench {
namespace {

std::vector<Pair> sorted(std::vector<Pair> pairs) {
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

Result<void> compare(const std::string& kind, const std::string& name_a, const std::vector<Pair>& a,
                     const std::string& name_b, const std::vector<Pair>& b) {
  const auto twice = std::adjacent_find(b.begin(), b.end());
  if (twice != b.end())
    return fail("verify", fmt::format("{} gave the {} pair {} {} twice", name_b, kind, twice->a, twice->b),
                "mend it");
  if (a == b) return {};
  std::vector<Pair> only_a, only_b;
  std::set_difference(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(only_a));
  std::set_difference(b.begin(), b.end(), a.begin(), a.end(), std::back_inserter(only_b));
  const Pair example = only_a.empty() ? only_b.front() : only_a.front();
  return fail("verify",
              fmt::format("{} pairs differ: {} only from {}, {} only from {}; one is {} {}", kind,
                          only_a.size(), name_a, only_b.size(), name_b, example.a, example.b),
              "mend one of them");
}

/// The largest gap along an axis between the swept boxes of two sets of vertices; negative when they overlap.
double gap(std::span<const double> x0, std::span<const double> x1, std::span<const Index> a,
           std::span<const Index> b) {
  const auto bounds = [&](std::span<const Index> ids, int axis) {
    double lo = INFINITY, hi = -INFINITY;
    for (const Index v : ids)
      for (const auto& x : {x0, x1}) {
        lo = std::min(lo, x[3 * v + axis]);
        hi = std::max(hi, x[3 * v + axis]);
      }
    return std::pair(lo, hi);
  };
  double widest = -INFINITY;
  for (int axis = 0; axis < 3; ++axis) {
    const auto [lo_a, hi_a] = bounds(a, axis);
    const auto [lo_b, hi_b] = bounds(b, axis);
    widest = std::max({widest, lo_a - hi_b, lo_b - hi_a});
  }
  return widest;
}

}  // namespace

bool same_answer(const StepResult& a, const StepResult& b) {
  const auto vf = [](const VertexFaceCollision& x, const VertexFaceCollision& y) {
    return x.vertex == y.vertex && x.face == y.face && x.toi == y.toi && x.answer == y.answer;
  };
  const auto ee = [](const EdgeEdgeCollision& x, const EdgeEdgeCollision& y) {
    return x.a == y.a && x.b == y.b && x.toi == y.toi && x.answer == y.answer;
  };
  return std::equal(a.vertex_face.begin(), a.vertex_face.end(), b.vertex_face.begin(), b.vertex_face.end(),
                    vf) &&
         std::equal(a.edge_edge.begin(), a.edge_edge.end(), b.edge_edge.begin(), b.edge_edge.end(), ee);
}

Result<void> Verifier::add_peer(const std::string& name, const Candidates& candidates) {
  Sorted mine{name, sorted(candidates.vertex_face), sorted(candidates.edge_edge)};
  if (first_.empty()) {
    first_.push_back(std::move(mine));
    return {};
  }
  const Sorted& first = first_.front();
  if (auto same = compare("vertex-face", first.name, first.vertex_face, name, mine.vertex_face); !same)
    return same;
  return compare("edge-edge", first.name, first.edge_edge, name, mine.edge_edge);
}

Index Verifier::edge_id(const Edge& edge) const {
  const auto edges = topology_.edges();
  return static_cast<Index>(std::lower_bound(edges.begin(), edges.end(), edge) - edges.begin());
}

Result<void> Verifier::check_answer(const StepResult& result) const {
  if (first_.empty()) return {};
  const Sorted& first = first_.front();
  const auto check = [&](const std::vector<Pair>& pairs, Pair pair, std::span<const Index> a,
                         std::span<const Index> b) -> Result<void> {
    if (std::binary_search(pairs.begin(), pairs.end(), pair)) return {};
    if (gap(x0_, x1_, a, b) <= result.tolerance) return {};
    return fail("verify",
                fmt::format("foldproof reports the pair {} {}, whose boxes stay apart", pair.a, pair.b),
                "mend foldproof");
  };
  for (const auto& c : result.vertex_face)
    if (auto fine =
            check(first.vertex_face, {c.vertex, c.face}, {&c.vertex, 1}, topology_.triangles()[c.face]);
        !fine)
      return fine;
  for (const auto& c : result.edge_edge)
    if (auto fine = check(first.edge_edge, {edge_id(c.a), edge_id(c.b)}, c.a, c.b); !fine) return fine;
  return {};
}

}  // namespace foldproof::bench
