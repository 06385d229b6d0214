#include "bvh/split.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>

#include "base/parallel.h"

namespace foldproof::internal {
namespace {

// Pieces of at most this size are split by one task each.
constexpr Index kPiecePerTask = 1 << 14;
// Rounds of repair of two halves before the search for their fragments.
constexpr int kMaxRepairs = 4;
// Each half has at least 1 / kMaxImbalance of a piece's triangles.
constexpr Index kMaxImbalance = 32;
// Edges with so many triangles have them in the order of their angles.
constexpr Index kManyAtEdge = 16;
constexpr std::size_t kBuckets = 64;
constexpr float kFar = std::numeric_limits<float>::max();

/// A triangle's neighbors: a range of Surface::neighbor and Surface::length.
struct Neighbors {
  Index begin, end;
};

/// The dual graph: triangles with their neighbors over edges. A piece is a run of triangles, which it numbers
/// from 0.
struct Surface {
  std::vector<Index> ids;  // the user's
  std::vector<Neighbors> neighbors;
  std::vector<Index> neighbor;  // in the piece
  std::vector<float> length;    // from center to center
  std::vector<float> distance;  // over the surface, from one end of the piece
};

struct Piece {
  Index begin, end;
  bool measured;  // it is connected, and `distance` is known
  Index size() const { return end - begin; }
};

/// The half of a piece to which a triangle belongs.
enum SplitSide : std::uint8_t { kLeft, kRight, kReachedLeft, kReachedRight };

/// Centers of triangles.
class Centers {
 public:
  Centers(const Topology& topology, std::span<const double> positions)
      : triangles_(topology.triangles()), positions_(positions) {
    double largest = 0;
    for (const double x : positions) largest = std::max(largest, std::abs(x));
    if (std::isnormal(1 / largest)) scale_ = 1 / largest;
  }
  /// Scaled so that sums do not overflow.
  Vec3 of(Index triangle) const {
    Vec3 sum = Vec3::Zero();
    for (const Index v : triangles_[triangle])
      sum += Vec3::load(&positions_[3 * std::size_t{v}]) * (scale_ / 3);
    return sum;
  }
  /// A vertex, scaled in the same way.
  Vec3 vertex(Index v) const { return Vec3::load(&positions_[3 * std::size_t{v}]) * scale_; }

 private:
  std::span<const Triangle> triangles_;
  std::span<const double> positions_;
  double scale_ = 1;
};

/// Splits pieces into halves that are connected where the surface is: by the difference of the distances over
/// the surface from two far ends of the piece. Going towards the first end never raises that difference, so
/// the part below any threshold is connected, and so is the rest. The exception are dead ends of equal
/// difference that the threshold splits: the fragment that is cut off goes to the other half. For the same
/// reason a shortest path to an end stays in that end's half, whose distances need not be measured again.
/// Scratch: one per thread.
class Splitter {
 public:
  explicit Splitter(const Centers& centers) : centers_(centers), buckets_(kBuckets) {}

  /// Splits a piece of `from`, with about `left` triangles in the first half. Writes both halves to `to`.
  std::array<Piece, 2> split(const Piece& piece, Index left, Surface& from, Surface& to) {
    from_ = &from;
    piece_ = piece;
    neighbors_ = std::span(from.neighbors).subspan(piece.begin, piece.size());
    side_.assign(piece.size(), kLeft);
    return write_halves(to, choose_sides(left));
  }

 private:
  Index size() const { return piece_.size(); }
  float* distance_to_first() { return from_->distance.data() + piece_.begin; }

  template <class Visit>
  void for_each_neighbor(Index t, Visit visit) const {
    for (Index k = neighbors_[t].begin; k < neighbors_[t].end; ++k)
      visit(from_->neighbor[k], from_->length[k]);
  }

  // Sets side_. Returns whether both halves are connected and have distances from their ends.
  bool choose_sides(Index left) {
    Index first = 0;
    float* const distance = distance_to_first();
    if (piece_.measured) {
      first = static_cast<Index>(std::min_element(distance, distance + size()) - distance);
    } else {
      queue_.clear();
      if (flood(0) < size()) {
        order_components(left);
        return false;
      }
      first = queue_.back();
      measure(first, distance);
    }
    const Index second = static_cast<Index>(std::max_element(distance, distance + size()) - distance);
    distance_to_second_.resize(size());
    measure(second, distance_to_second_.data());
    split_by_rank(left);
    if (first == second) return false;
    side_[first] = kLeft;
    side_[second] = kRight;
    if (repair(first, second)) return true;
    exchange_fragments(first, second);
    // Where many triangles coincide, a half may fall into many small fragments. Splitting them off one by one
    // would take quadratic time, so the halves stay disconnected.
    const auto lefts = static_cast<Index>(std::count(side_.begin(), side_.end(), kLeft));
    if (std::min(lefts, size() - lefts) < size() / kMaxImbalance) split_by_rank(left);
    return false;
  }

  // Breadth-first search from `start` over triangles of the same side. Marks them as reached, appends them to
  // the queue and returns their number.
  std::size_t flood(Index start) {
    const std::size_t before = queue_.size();
    const std::uint8_t side = side_[start], reached = side + (kReachedLeft - kLeft);
    queue_.push_back(start);
    side_[start] = reached;
    for (std::size_t i = before; i < queue_.size(); ++i) {
      for_each_neighbor(queue_[i], [&](Index other, float) {
        if (side_[other] != side) return;
        side_[other] = reached;
        queue_.push_back(other);
      });
    }
    return queue_.size() - before;
  }

  // Shortest paths over the piece from `start`, by delta-stepping: buckets as wide as a mean length, first in
  // first out; a triangle is relaxed again when a shorter path to it is found.
  void measure(Index start, float* distance) {
    std::fill(distance, distance + size(), kFar);
    relaxed_at_.assign(size(), kFar);
    const float per_bucket = 1 / mean_length();
    std::size_t bucket = 0, queued = 0;
    const auto put = [&](Index t) {
      const auto number = static_cast<std::size_t>(std::min(distance[t] * per_bucket, 1e15f));
      buckets_[std::clamp(number, bucket, bucket + kBuckets - 1) % kBuckets].push_back(t);
      ++queued;
    };
    distance[start] = 0;
    put(start);
    for (; queued > 0; ++bucket) {
      std::vector<Index>& now = buckets_[bucket % kBuckets];
      for (std::size_t i = 0; i < now.size(); ++i) {
        const Index t = now[i];
        --queued;
        if (relaxed_at_[t] == distance[t]) continue;
        const float here = relaxed_at_[t] = distance[t];
        for_each_neighbor(t, [&](Index other, float length) {
          if (!(here + length < distance[other])) return;
          distance[other] = here + length;
          put(other);
        });
      }
      now.clear();
    }
  }

  float mean_length() const {
    const Index begin = neighbors_.front().begin, end = neighbors_.back().end;
    const float sum = std::accumulate(&from_->length[begin], &from_->length[begin] + (end - begin), 0.f);
    return std::max(sum / static_cast<float>(std::max<Index>(end - begin, 1)), 1e-30f);
  }

  // The `left` smallest differences are the left half.
  void split_by_rank(Index left) {
    order_.resize(size());
    for (Index t = 0; t < size(); ++t) {
      const auto bits = std::bit_cast<std::uint32_t>(distance_to_first()[t] - distance_to_second_[t]);
      const std::uint32_t ascending = bits >> 31 ? ~bits : bits | 0x80000000u;
      order_[t] = std::uint64_t{ascending} << 32 | t;
    }
    std::nth_element(order_.begin(), order_.begin() + left, order_.end());
    for (Index k = 0; k < size(); ++k) side_[static_cast<Index>(order_[k])] = k < left ? kLeft : kRight;
  }

  // Every triangle needs a neighbor in its half that is nearer to the half's end; one without changes sides.
  // Returns true once all have one: then both halves are connected.
  bool repair(Index first, Index second) {
    for (int round = 0; round < kMaxRepairs; ++round) {
      bool moved = false;
      for (Index t = 0; t < size(); ++t) {
        if (t == first || t == second) continue;
        const float* distance = distance_to_end(static_cast<SplitSide>(side_[t]));
        bool connected = false;
        for_each_neighbor(t, [&](Index other, float) {
          connected |= side_[other] == side_[t] && distance[other] < distance[t];
        });
        if (connected) continue;
        side_[t] = side_[t] == kLeft ? kRight : kLeft;
        moved = true;
      }
      if (!moved) return true;
    }
    return false;
  }

  // Moves triangles of the left half that are not connected to `first` to the other half; and so for `second`
  // in the right half.
  void exchange_fragments(Index first, Index second) {
    queue_.clear();
    flood(first);
    for (std::uint8_t& side : side_) {
      if (side == kLeft) side = kRight;
    }
    flood(second);
    for (std::uint8_t& side : side_) side = side == kReachedRight ? kRight : kLeft;
  }

  // Splits a piece of several components, sorted along the longest axis of their centers: at most one
  // component is split itself. The queue starts with the first component.
  void order_components(Index left) {
    struct Component {
      std::size_t begin, end;
      Vec3 center;
    };
    std::vector<Component> components;
    const auto add = [&](std::size_t begin) {
      Component c{begin, queue_.size(), Vec3::Zero()};
      for (std::size_t k = begin; k < c.end; ++k) c.center += center(queue_[k]);
      c.center /= static_cast<double>(c.end - begin);
      components.push_back(c);
    };
    add(0);
    for (Index t = 0; t < size(); ++t) {
      if (side_[t] != kLeft) continue;
      const std::size_t begin = queue_.size();
      flood(t);
      add(begin);
    }
    Vec3 low = components[0].center, high = low;
    for (const Component& c : components) {
      low = low.cwiseMin(c.center);
      high = high.cwiseMax(c.center);
    }
    const Vec3 extent = high - low;
    const auto axis =
        static_cast<std::size_t>(std::max_element(extent.begin(), extent.end()) - extent.begin());
    std::stable_sort(components.begin(), components.end(),
                     [&](const Component& a, const Component& b) { return a.center[axis] < b.center[axis]; });
    std::size_t rank = 0;
    for (const Component& c : components) {
      const auto begin = queue_.begin() + static_cast<std::ptrdiff_t>(c.begin),
                 end = queue_.begin() + static_cast<std::ptrdiff_t>(c.end);
      // The component that is split is sorted along the axis, so that the cut is a plane.
      if (rank < left && rank + (c.end - c.begin) > left) {
        std::sort(begin, end, [&](Index a, Index b) {
          return std::pair(center(a)[axis], a) < std::pair(center(b)[axis], b);
        });
      }
      for (auto t = begin; t != end; ++t) side_[*t] = rank++ < left ? kLeft : kRight;
    }
  }
  Vec3 center(Index t) const { return centers_.of(from_->ids[piece_.begin + t]); }

  const float* distance_to_end(SplitSide side) {
    return side == kLeft ? distance_to_first() : distance_to_second_.data();
  }

  // Writes the left half, then the right one, each numbered from 0.
  std::array<Piece, 2> write_halves(Surface& to, bool measured) {
    Index counts[2] = {0, 0};
    number_.resize(size());
    for (Index t = 0; t < size(); ++t) number_[t] = counts[side_[t]]++;
    Index at = piece_.begin, entry = neighbors_.front().begin;
    for (const SplitSide half : {kLeft, kRight}) {
      const float* distance = distance_to_end(half);
      for (Index t = 0; t < size(); ++t) {
        if (side_[t] != half) continue;
        to.ids[at] = from_->ids[piece_.begin + t];
        if (measured) to.distance[at] = distance[t];
        const Index begin = entry;
        for_each_neighbor(t, [&](Index other, float length) {
          if (side_[other] != half) return;
          to.neighbor[entry] = number_[other];
          to.length[entry++] = length;
        });
        to.neighbors[at++] = {begin, entry};
      }
    }
    const Index middle = piece_.begin + counts[kLeft];
    return {Piece{piece_.begin, middle, measured}, Piece{middle, piece_.end, measured}};
  }

  const Centers& centers_;
  Surface* from_ = nullptr;
  Piece piece_{};
  std::span<const Neighbors> neighbors_;
  std::vector<std::uint8_t> side_;
  std::vector<Index> queue_, number_;  // number_: in the half
  std::vector<float> distance_to_second_, relaxed_at_;
  std::vector<std::uint64_t> order_;
  std::vector<std::vector<Index>> buckets_;
};

// Orders triangles by breadth-first search over the surface, so that neighbors are near each other in memory
// however the user numbered them.
class SurfaceOrder {
 public:
  SurfaceOrder(const Topology& topology, const Centers& centers) : sides_(topology.triangle_edges()) {
    std::vector<Index>& begin = edge_begin_;
    begin.assign(topology.edges().size() + 1, 0);
    for_each_side([&](Index e, Side) { ++begin[e + 1]; });
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    at_edges_.resize(begin.back());
    std::vector<Index> fill(begin.begin(), begin.end() - 1);
    for_each_side([&](Index e, Side side) { at_edges_[fill[e]++] = side; });
    for (Index e = 0; e < topology.edges().size(); ++e) {
      if (begin[e + 1] - begin[e] >= kManyAtEdge) sort_by_angle(topology.edges()[e], at_edge(e), centers);
    }
    places_.resize(sides_.size());
    for (Index k = 0; k < at_edges_.size(); ++k) places_[at_edges_[k].triangle][at_edges_[k].number] = k;
  }

  std::vector<Index> order() const {
    std::vector<Index> order;
    order.reserve(sides_.size());
    std::vector<bool> visited(sides_.size(), false);
    for (Index start = 0; start < sides_.size(); ++start) {
      if (visited[start]) continue;
      visited[start] = true;
      order.push_back(start);
      for (std::size_t i = order.size() - 1; i < order.size(); ++i) {
        for_each_neighbor(order[i], [&](Index other) {
          if (visited[other]) return;
          visited[other] = true;
          order.push_back(other);
        });
      }
    }
    return order;
  }

  // At an edge of many triangles each has two neighbors: the previous and the next one.
  template <class Visit>
  void for_each_neighbor(Index t, Visit visit) const {
    for (std::size_t k = 0; k < 3; ++k) {
      const Index e = sides_[t][k];
      if (e == kNoIndex) continue;
      const Index self = places_[t][k];
      const auto visit_other = [&](Index other) {
        if (at_edges_[other].triangle != t) visit(at_edges_[other].triangle);
      };
      if (self != edge_begin_[e]) visit_other(self - 1);
      if (self + 1 != edge_begin_[e + 1]) visit_other(self + 1);
    }
  }

 private:
  struct Side {
    Index triangle;
    Index number;  // 0 to 2
  };

  template <class Visit>
  void for_each_side(Visit visit) const {
    for (Index t = 0; t < sides_.size(); ++t) {
      for (Index k = 0; k < 3; ++k) {
        if (sides_[t][k] != kNoIndex) visit(sides_[t][k], Side{t, k});
      }
    }
  }
  std::span<Side> at_edge(Index e) {
    return std::span(at_edges_).subspan(edge_begin_[e], edge_begin_[e + 1] - edge_begin_[e]);
  }

  // Around the edge, so that halves of what is at it lie on different sides of a plane.
  static void sort_by_angle(const Edge& edge, std::span<Side> sides, const Centers& centers) {
    const Vec3 start = centers.vertex(edge[0]), along = (centers.vertex(edge[1]) - start).normalized();
    const auto away = [&](Index t) {
      const Vec3 out = centers.of(t) - start;
      return out - along * along.dot(out);
    };
    const Vec3 x = away(sides[0].triangle), y = along.cross(x);
    std::vector<std::pair<double, std::size_t>> order;
    for (std::size_t k = 0; k < sides.size(); ++k) {
      // Grows with the angle, from 0 to 4, and is computed alike on all machines.
      const Vec3 out = away(sides[k].triangle);
      const double a = x.dot(out), b = y.dot(out), size = std::abs(a) + std::abs(b);
      const double quarter = size > 0 && size <= std::numeric_limits<double>::max() ? b / size : 0;
      order.emplace_back(a < 0 ? 2 - quarter : b < 0 ? 4 + quarter : quarter, k);
    }
    std::ranges::sort(order);
    const std::vector<Side> old(sides.begin(), sides.end());
    for (std::size_t k = 0; k < sides.size(); ++k) sides[k] = old[order[k].second];
  }

  std::span<const std::array<Index, 3>> sides_;
  std::vector<Index> edge_begin_;             // per edge: its first side, in at_edges_
  std::vector<Side> at_edges_;                // of one edge: by triangle, or by angle
  std::vector<std::array<Index, 3>> places_;  // of a triangle's sides, in at_edges_
};

// The surface, and a buffer of the same size for its halves.
std::array<Surface, 2> surface_of(const Topology& topology, const Centers& centers) {
  std::array<Surface, 2> both;
  Surface& surface = both[0];
  const SurfaceOrder surface_order(topology, centers);
  surface.ids = surface_order.order();
  std::vector<Index> number(surface.ids.size());
  for (Index k = 0; k < number.size(); ++k) number[surface.ids[k]] = k;
  for (const Index t : surface.ids) {
    const auto begin = static_cast<Index>(surface.neighbor.size());
    const Vec3 center = centers.of(t);
    surface_order.for_each_neighbor(t, [&](Index other) {
      surface.neighbor.push_back(number[other]);
      surface.length.push_back(static_cast<float>((centers.of(other) - center).norm()));
    });
    surface.neighbors.push_back({begin, static_cast<Index>(surface.neighbor.size())});
  }
  surface.distance.resize(surface.ids.size());
  both[1] = surface;
  return both;
}

/// Builds the tree below one piece, or the top of the whole tree.
class TreeBuilder {
 public:
  struct Task {
    Piece piece;
    int buffer;
  };
  static constexpr Index kSubtree = kNoIndex;  // in place of a leaf's size

  TreeBuilder(Index leaf_triangles, std::array<Surface, 2>& buffers, std::span<Index> triangle_ids)
      : leaf_triangles_(leaf_triangles), buffers_(buffers), triangle_ids_(triangle_ids) {}

  /// Splits until pieces are leaves, or no larger than `stop`: those become `subtrees`.
  void build(Task root, Index stop, Splitter& splitter) {
    std::vector<Task> tasks{root};
    while (!tasks.empty()) {
      const Task task = tasks.back();
      tasks.pop_back();
      const Index size = task.piece.size();
      Surface& from = buffers_[task.buffer];
      // One leaf that is too full is better than two that are half empty.
      if (size <= leaf_triangles_ + leaf_triangles_ / 4) {
        leaf_sizes.push_back(size);
        std::copy_n(from.ids.begin() + task.piece.begin, size, triangle_ids_.begin() + task.piece.begin);
        continue;
      }
      if (size <= stop) {
        leaf_sizes.push_back(kSubtree);
        subtrees.push_back(task);
        continue;
      }
      leaf_sizes.push_back(0);
      // Whole leaves on the left, so that leaves come out full.
      const Index leaves = std::max<Index>((size + leaf_triangles_ / 2) / leaf_triangles_, 2);
      const auto halves =
          splitter.split(task.piece, leaves / 2 * (size / leaves), from, buffers_[1 - task.buffer]);
      tasks.push_back({halves[1], 1 - task.buffer});
      tasks.push_back({halves[0], 1 - task.buffer});
    }
  }

  std::vector<Index> leaf_sizes;
  std::vector<Task> subtrees;

 private:
  Index leaf_triangles_;
  std::array<Surface, 2>& buffers_;
  std::span<Index> triangle_ids_;
};

}  // namespace

SplitSurface split_surface(const Topology& topology, std::span<const double> positions,
                           Index leaf_triangles) {
  const Centers centers(topology, positions);
  std::array<Surface, 2> buffers = surface_of(topology, centers);
  const auto count = static_cast<Index>(topology.triangles().size());
  SplitSurface split;
  split.triangle_ids.resize(count);
  TreeBuilder top(leaf_triangles, buffers, split.triangle_ids);
  {
    Splitter splitter(centers);
    top.build({{0, count, false}, 0}, kPiecePerTask, splitter);
  }
  std::vector<TreeBuilder> below(top.subtrees.size(),
                                 TreeBuilder(leaf_triangles, buffers, split.triangle_ids));
  PerThread<Splitter> splitters([&] { return Splitter(centers); });
  parallel_for(std::size_t{0}, below.size(),
               [&](std::size_t k) { below[k].build(top.subtrees[k], 0, splitters.local()); });
  std::size_t next = 0;
  for (const Index size : top.leaf_sizes) {
    if (size != TreeBuilder::kSubtree) {
      split.leaf_sizes.push_back(size);
      continue;
    }
    const std::vector<Index>& sizes = below[next++].leaf_sizes;
    split.leaf_sizes.insert(split.leaf_sizes.end(), sizes.begin(), sizes.end());
  }
  return split;
}

}  // namespace foldproof::internal
