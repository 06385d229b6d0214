#include "subdivide.h"
#include "base/try.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>

namespace foldproof::bench {
namespace {

// An edge of the coarse mesh with the corners opposite to it, and the new vertex on it.
struct SplitEdge {
  std::vector<Index> opposite;
  Index vertex = kNoIndex;
};
using SplitEdges = std::map<Edge, SplitEdge>;

SplitEdges edges_of(const Topology& coarse) {
  SplitEdges edges;
  for (const Triangle& t : coarse.triangles()) {
    for (int k = 0; k < 3; ++k)
      edges[{std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3])}].opposite.push_back(
          t[(k + 2) % 3]);
  }
  return edges;
}

// Every new vertex is in two triangles with one end of its edge and in two with the other.
Result<void> number_new_vertices(const Topology& fine, const Topology& coarse, SplitEdges& edges) {
  std::vector<std::vector<Index>> ends(fine.vertex_count());
  for (const Triangle& t : fine.triangles()) {
    for (const Index a : t) {
      for (const Index b : t) {
        if (a >= coarse.vertex_count() && b < coarse.vertex_count()) ends[a].push_back(b);
      }
    }
  }
  for (Index v = coarse.vertex_count(); v < fine.vertex_count(); ++v) {
    const auto [low, high] = std::minmax_element(ends[v].begin(), ends[v].end());
    const auto edge = ends[v].empty() ? edges.end() : edges.find({*low, *high});
    if (edge == edges.end())
      return fail(fmt::format("vertex {}", v), "lies on no edge of the coarse mesh",
                  "subdivide it by Loop's rule");
    edge->second.vertex = v;
  }
  for (const auto& [ends_of_edge, edge] : edges) {
    if (edge.vertex == kNoIndex || edge.opposite.size() != 2)
      return fail(fmt::format("edge {}, {}", ends_of_edge[0], ends_of_edge[1]), "is open or was not split",
                  "use a closed mesh that was subdivided by Loop's rule");
  }
  return {};
}

using Rows = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;

Rows subdivide(const SplitEdges& edges, const Rows& x, Index fine_vertices) {
  Rows out = Rows::Zero(fine_vertices, 3);
  Rows ring = Rows::Zero(x.rows(), 3);
  std::vector<int> valence(x.rows(), 0);
  for (const auto& [ends, edge] : edges) {
    const auto [a, b] = ends;
    out.row(edge.vertex) =
        0.375 * (x.row(a) + x.row(b)) + 0.125 * (x.row(edge.opposite[0]) + x.row(edge.opposite[1]));
    ring.row(a) += x.row(b);
    ring.row(b) += x.row(a);
    ++valence[a];
    ++valence[b];
  }
  for (Eigen::Index v = 0; v < x.rows(); ++v) {
    const double n = valence[v], wave = 0.375 + 0.25 * std::cos(2 * std::numbers::pi / n);
    const double weight = (0.625 - wave * wave) / n;
    out.row(v) = (1 - n * weight) * x.row(v) + weight * ring.row(v);
  }
  return out;
}

// The triangles at each edge; kNoIndex where there is none.
Result<std::vector<std::array<Index, 2>>> sides_of(const Topology& topology) {
  std::vector<std::array<Index, 2>> sides(topology.edges().size(), {kNoIndex, kNoIndex});
  for (Index t = 0; t < topology.triangles().size(); ++t) {
    for (const Index edge : topology.triangle_edges()[t]) {
      if (edge == kNoIndex || sides[edge][1] != kNoIndex)
        return fail(fmt::format("triangle {}", t), "has a corner twice, or an edge with two others",
                    "refine a manifold mesh");
      sides[edge][sides[edge][0] == kNoIndex ? 0 : 1] = t;
    }
  }
  return sides;
}

// One new vertex in the middle of every triangle; then edges with two triangles are flipped.
std::vector<Triangle> refined_triangles(const Topology& coarse, std::span<const std::array<Index, 2>> sides) {
  std::vector<Triangle> fine;
  fine.reserve(3 * coarse.triangles().size());
  for (Index t = 0; t < coarse.triangles().size(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const Index a = coarse.triangles()[t][k], b = coarse.triangles()[t][(k + 1) % 3];
      const auto [one, two] = sides[coarse.triangle_edges()[t][k]];
      const Index other = one == t ? two : one, here = coarse.vertex_count() + t;
      fine.push_back({a, other == kNoIndex ? b : coarse.vertex_count() + other, here});
    }
  }
  return fine;
}

std::vector<double> refined_positions(const Topology& coarse, std::span<const std::array<Index, 2>> sides,
                                      const Rows& x) {
  std::vector<double> out(3 * (coarse.vertex_count() + coarse.triangles().size()));
  Eigen::Map<Rows> y(out.data(), static_cast<Eigen::Index>(out.size() / 3), 3);
  Rows ring = Rows::Zero(x.rows(), 3);
  std::vector<int> valence(x.rows());
  std::vector<bool> border(x.rows());
  for (std::size_t e = 0; e < sides.size(); ++e) {
    const auto [a, b] = coarse.edges()[e];
    ring.row(a) += x.row(b);
    ring.row(b) += x.row(a);
    ++valence[a];
    ++valence[b];
    if (sides[e][1] == kNoIndex) border[a] = border[b] = true;
  }
  for (Eigen::Index v = 0; v < x.rows(); ++v) {
    const double n = valence[v], weight = (4 - 2 * std::cos(2 * std::numbers::pi / n)) / 9;
    const bool stays = border[v] || n == 0;
    y.row(v) = stays ? x.row(v).eval() : ((1 - weight) * x.row(v) + weight / n * ring.row(v)).eval();
  }
  for (std::size_t t = 0; t < coarse.triangles().size(); ++t) {
    const auto& [a, b, c] = coarse.triangles()[t];
    y.row(x.rows() + static_cast<Eigen::Index>(t)) = (x.row(a) + x.row(b) + x.row(c)) / 3;
  }
  return out;
}

}  // namespace

Result<std::unique_ptr<Motion>> subdivide_like(const Topology& fine, Motion& coarse) {
  SplitEdges edges = edges_of(coarse.topology());
  FOLDPROOF_TRY(number_new_vertices(fine, coarse.topology(), edges));
  std::vector<std::vector<double>> frames;
  Rows x(coarse.topology().vertex_count(), 3);
  for (Index k = 0; k < coarse.frame_count(); ++k) {
    FOLDPROOF_TRY(coarse.read_frame(k, {x.data(), static_cast<std::size_t>(x.size())}));
    const Rows y = subdivide(edges, x, fine.vertex_count());
    frames.emplace_back(y.data(), y.data() + y.size());
  }
  return memory_motion(coarse.name(), fine, std::move(frames));
}

Result<std::unique_ptr<Motion>> refine(Motion& coarse) {
  const Topology& topology = coarse.topology();
  const auto sides = FOLDPROOF_TRY(sides_of(topology));
  auto fine =
      FOLDPROOF_TRY(Topology::make(topology.vertex_count() + static_cast<Index>(topology.triangles().size()),
                                   refined_triangles(topology, sides)));
  std::vector<std::vector<double>> frames;
  Rows x(topology.vertex_count(), 3);
  for (Index k = 0; k < coarse.frame_count(); ++k) {
    FOLDPROOF_TRY(coarse.read_frame(k, {x.data(), static_cast<std::size_t>(x.size())}));
    frames.push_back(refined_positions(topology, sides, x));
  }
  return memory_motion(coarse.name(), std::move(fine), std::move(frames));
}

}  // namespace foldproof::bench
