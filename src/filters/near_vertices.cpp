// Filters of vertices that belong together: two features are ignored if any vertex of the one belongs to any
// vertex of the other.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>

#include "base/plain_arithmetic.h"
#include "base/try.h"
#include "filters/by_vertices.h"
#include "foldproof/filters.h"

namespace foldproof {
namespace {

// Vertices of all objects, numbered one object after the other.
struct VertexNumbers {
  std::vector<Index> first;  // of each object, and the end
  static Result<VertexNumbers> make(std::span<const Object> objects) {
    VertexNumbers numbers{{0}};
    for (const Object& object : objects) {
      const std::uint64_t end =
          std::uint64_t{numbers.first.back()} + object.hierarchy()->topology().vertex_count();
      if (end >= kNoIndex)
        return fail(ErrorCode::LimitExceeded, "objects", "have too many vertices to number them",
                    "give fewer");
      numbers.first.push_back(static_cast<Index>(end));
    }
    return numbers;
  }
};

class VertexFilter final : public ByVertices {
 public:
  // `pairs`: of vertices that belong together; each is taken in both orders.
  VertexFilter(std::span<const Object> objects, VertexNumbers numbers,
               std::span<const std::array<Index, 2>> pairs)
      : ByVertices(objects), first_(std::move(numbers.first)), begin_(first_.back() + std::size_t{1}) {
    for (const auto& [a, b] : pairs) {
      ++begin_[a];
      ++begin_[b];
    }
    std::size_t end = 0;
    for (std::size_t& begin : begin_) begin = end += begin;
    with_.resize(end);
    for (const auto& [a, b] : pairs) {
      with_[--begin_[a]] = b;
      with_[--begin_[b]] = a;
    }
    for (std::size_t v = 0; v + 1 < begin_.size(); ++v)
      std::sort(with_.data() + begin_[v], with_.data() + begin_[v + 1]);
  }

  bool nodes(Index, Index, Index, Index) const override { return true; }

 private:
  bool tests(Index object_a, std::span<const Index> a, Index object_b,
             std::span<const Index> b) const override {
    for (const Index i : a) {
      const Index v = first_[object_a] + i;
      const auto begin = with_.begin() + static_cast<std::ptrdiff_t>(begin_[v]),
                 end = with_.begin() + static_cast<std::ptrdiff_t>(begin_[v + 1]);
      for (const Index j : b) {
        if (begin != end && std::binary_search(begin, end, first_[object_b] + j)) return false;
      }
    }
    return true;
  }

  std::vector<Index> first_;        // per object
  std::vector<std::size_t> begin_;  // per vertex: where its part of with_ begins
  std::vector<Index> with_;         // vertices that belong to it, ascending
};

// Appends each vertex of an object with itself and those of smaller ids that are within a length along edges
// (Dijkstra 1959).
template <class Length>
void append_near(const Topology& topology, Index first, double most, Length length_of,
                 std::vector<std::array<Index, 2>>& out) {
  struct End {
    Index vertex;
    double length;
  };
  std::vector<std::vector<End>> ends(topology.vertex_count());
  for (const auto& [a, b] : topology.edges()) {
    const double length = length_of(a, b);
    ends[a].push_back({b, length});
    ends[b].push_back({a, length});
  }
  std::vector<double> length(topology.vertex_count(), std::numeric_limits<double>::infinity());
  std::vector<Index> reached;
  std::priority_queue<std::pair<double, Index>, std::vector<std::pair<double, Index>>, std::greater<>> open;
  for (Index from = 0; from < topology.vertex_count(); ++from) {
    reached.assign(1, from);
    length[from] = 0;
    open.push({0, from});
    while (!open.empty()) {
      const auto [so_far, vertex] = open.top();
      open.pop();
      if (so_far > length[vertex]) continue;  // reached on a shorter path
      for (const End& end : ends[vertex]) {
        const double longer = so_far + end.length;
        if (longer > most || longer >= length[end.vertex]) continue;
        if (std::isinf(length[end.vertex])) reached.push_back(end.vertex);
        length[end.vertex] = longer;
        open.push({longer, end.vertex});
      }
    }
    for (const Index vertex : reached) {
      if (vertex <= from) out.push_back({first + from, first + vertex});
      length[vertex] = std::numeric_limits<double>::infinity();
    }
  }
}

}  // namespace

Result<std::shared_ptr<const PairFilter>> ignore_sewn(std::span<const Object> objects,
                                                      std::span<const std::array<ObjectVertex, 2>> seams) {
  auto numbers = FOLDPROOF_TRY(VertexNumbers::make(objects));
  std::vector<std::array<Index, 2>> pairs;
  for (std::size_t k = 0; k < seams.size(); ++k) {
    for (const auto& [object, vertex] : seams[k]) {
      if (object >= objects.size() || vertex >= objects[object].hierarchy()->topology().vertex_count()) {
        return fail(ErrorCode::InvalidArgument, fmt::format("seam {}", k),
                    fmt::format("names vertex {} of object {}, which is not there", vertex, object),
                    "count both from 0");
      }
    }
    const auto& [a, b] = seams[k];
    const std::array pair{numbers.first[a.object] + a.vertex, numbers.first[b.object] + b.vertex};
    if (pair[0] != pair[1]) pairs.push_back(pair);
  }
  return std::make_shared<const VertexFilter>(objects, std::move(numbers), pairs);
}

Result<std::shared_ptr<const PairFilter>> ignore_rings(std::span<const Object> objects, Index rings) {
  auto numbers = FOLDPROOF_TRY(VertexNumbers::make(objects));
  std::vector<std::array<Index, 2>> pairs;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    append_near(
        objects[i].hierarchy()->topology(), numbers.first[i], rings, [](Index, Index) { return 1.0; }, pairs);
  }
  return std::make_shared<const VertexFilter>(objects, std::move(numbers), pairs);
}

Result<std::shared_ptr<const PairFilter>> ignore_length(std::span<const Object> objects, Positions x,
                                                        double length) {
  const PlainArithmetic plain;
  if (!(length >= 0) || !std::isfinite(length))
    return fail(ErrorCode::InvalidArgument, "length", "is not a length", "give a number of at least 0");
  if (x.size() != objects.size()) {
    return fail(ErrorCode::InvalidArgument, "positions",
                fmt::format("are of {} objects instead of {}", x.size(), objects.size()),
                "give those of each object");
  }
  auto numbers = FOLDPROOF_TRY(VertexNumbers::make(objects));
  std::vector<std::array<Index, 2>> pairs;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const Topology& topology = objects[i].hierarchy()->topology();
    if (x[i].size() != 3 * std::size_t{topology.vertex_count()} ||
        !std::ranges::all_of(x[i], [](double c) { return std::isfinite(c); })) {
      return fail(ErrorCode::InvalidArgument, fmt::format("positions of object {}", i),
                  "are not finite, or of another number of vertices",
                  fmt::format("give three numbers for each of {} vertices", topology.vertex_count()));
    }
    const auto at = [&](Index v) { return Vec3::load(&x[i][3 * std::size_t{v}]); };
    append_near(
        topology, numbers.first[i], length, [&](Index a, Index b) { return (at(b) - at(a)).norm(); }, pairs);
  }
  return std::make_shared<const VertexFilter>(objects, std::move(numbers), pairs);
}

}  // namespace foldproof
