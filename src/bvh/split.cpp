#include "bvh/split.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>

#include "base/parallel.h"

namespace foldproof {
namespace {

// Pieces of at most that size are cut up by one thread each.
constexpr Index kPieceOfThread = 1 << 14;
// Halves are mended so often before their fragments are looked for.
constexpr int kMostMendings = 4;
// Each half has at least one in so many of a piece's triangles.
constexpr Index kMostUneven = 32;
constexpr std::size_t kBuckets = 64;
constexpr float kFar = std::numeric_limits<float>::max();

/// Where a triangle's neighbours stand.
struct Neighbours {
  Index begin, end;
};

/// Triangles with their neighbours over edges. A piece is a run of them and numbers its own from 0.
struct Surface {
  std::vector<Index> ids;  // the user's
  std::vector<Neighbours> neighbours;
  std::vector<Index> to;      // in the piece
  std::vector<float> length;  // from centre to centre
  std::vector<float> far;     // over the surface, from one end of the piece
};

struct Piece {
  Index begin, end;
  bool measured;  // it hangs together, and `far` is known
  Index size() const { return end - begin; }
};

/// A half of a piece that is being cut.
enum Side : std::uint8_t { kLeft, kRight, kReachedLeft, kReachedRight };

class Centers {
 public:
  Centers(const Topology& topology, std::span<const double> positions)
      : triangles_(topology.triangles()), positions_(positions) {
    double largest = 0;
    for (const double x : positions) largest = std::max(largest, std::abs(x));
    if (std::isnormal(1 / largest)) scale_ = 1 / largest;
  }
  /// In units that no sum of them leaves.
  Vec3 of(Index triangle) const {
    Vec3 sum = Vec3::Zero();
    for (const Index v : triangles_[triangle])
      sum += Eigen::Map<const Vec3>(&positions_[3 * std::size_t{v}]) * (scale_ / 3);
    return sum;
  }

 private:
  std::span<const Triangle> triangles_;
  std::span<const double> positions_;
  double scale_ = 1;
};

/// Cuts pieces into halves that are connected where the surface is: by the difference of the distances over
/// the surface from two far ends of the piece. Going towards the first end never raises that difference, so
/// the part below any threshold hangs together, and so does the rest; but for dead ends, all of one
/// difference, that a threshold cuts: what it cuts off goes to the other half. For the same reason the
/// shortest way to an end stays in that end's half, whose distances need not be measured again. Scratch: one
/// per thread.
class Cutter {
 public:
  explicit Cutter(const Centers& centers) : centers_(centers), buckets_(kBuckets) {}

  /// Cuts a piece of `from` into two, about `left` triangles in the first, which stand in `to` then.
  std::array<Piece, 2> cut(const Piece& piece, Index left, Surface& from, Surface& to) {
    from_ = &from;
    piece_ = piece;
    neighbours_ = std::span(from.neighbours).subspan(piece.begin, piece.size());
    side_.assign(piece.size(), kLeft);
    return move(to, choose_sides(left));
  }

 private:
  Index size() const { return piece_.size(); }
  float* far() { return from_->far.data() + piece_.begin; }

  template <class Visit>
  void for_each_neighbour(Index t, Visit visit) const {
    for (Index k = neighbours_[t].begin; k < neighbours_[t].end; ++k) visit(from_->to[k], from_->length[k]);
  }

  // Whether both halves hang together, with distances from their ends.
  bool choose_sides(Index left) {
    Index first = 0;
    if (piece_.measured) {
      first = static_cast<Index>(std::min_element(far(), far() + size()) - far());
    } else {
      queue_.clear();
      if (flood(0) < size()) {
        order_components(left);
        return false;
      }
      first = queue_.back();
      measure(first, far());
    }
    const Index second = static_cast<Index>(std::max_element(far(), far() + size()) - far());
    second_far_.resize(size());
    measure(second, second_far_.data());
    rank(left);
    if (first == second) return false;
    side_[first] = kLeft;
    side_[second] = kRight;
    if (mend(first, second)) return true;
    exchange_fragments(first, second);
    // Where many triangles lie at one place a half may come apart into crumbs. Cutting off one after the
    // other would take quadratic time: rather halves that do not hang together.
    const auto lefts = static_cast<Index>(std::count(side_.begin(), side_.end(), kLeft));
    if (std::min(lefts, size() - lefts) < size() / kMostUneven) rank(left);
    return false;
  }

  // Breadth first from `start` over what is on its side; marks it as reached and appends it to the queue.
  // Returns how many.
  std::size_t flood(Index start) {
    const std::size_t before = queue_.size();
    const std::uint8_t side = side_[start], reached = side + (kReachedLeft - kLeft);
    queue_.push_back(start);
    side_[start] = reached;
    for (std::size_t i = before; i < queue_.size(); ++i) {
      for_each_neighbour(queue_[i], [&](Index other, float) {
        if (side_[other] != side) return;
        side_[other] = reached;
        queue_.push_back(other);
      });
    }
    return queue_.size() - before;
  }

  // Shortest paths over the piece from `start`. Buckets as wide as a step; in a bucket whoever comes first is
  // first, and goes again when a shorter way is found.
  void measure(Index start, float* distance) {
    std::fill(distance, distance + size(), kFar);
    gone_at_.assign(size(), kFar);
    const float per_bucket = 1 / mean_step();
    std::size_t bucket = 0, waiting = 0;
    const auto put = [&](Index t) {
      const auto number = static_cast<std::size_t>(std::min(distance[t] * per_bucket, 1e15f));
      buckets_[std::clamp(number, bucket, bucket + kBuckets - 1) % kBuckets].push_back(t);
      ++waiting;
    };
    distance[start] = 0;
    put(start);
    for (; waiting > 0; ++bucket) {
      std::vector<Index>& now = buckets_[bucket % kBuckets];
      for (std::size_t i = 0; i < now.size(); ++i) {
        const Index t = now[i];
        --waiting;
        if (gone_at_[t] == distance[t]) continue;
        const float so_far = gone_at_[t] = distance[t];
        for_each_neighbour(t, [&](Index other, float length) {
          if (!(so_far + length < distance[other])) return;
          distance[other] = so_far + length;
          put(other);
        });
      }
      now.clear();
    }
  }

  float mean_step() const {
    const Index begin = neighbours_.front().begin, end = neighbours_.back().end;
    const float sum = std::accumulate(&from_->length[begin], &from_->length[begin] + (end - begin), 0.f);
    return std::max(sum / static_cast<float>(std::max<Index>(end - begin, 1)), 1e-30f);
  }

  // The smallest differences are left.
  void rank(Index left) {
    order_.resize(size());
    for (Index t = 0; t < size(); ++t) {
      const auto bits = std::bit_cast<std::uint32_t>(far()[t] - second_far_[t]);
      const std::uint32_t ascending = bits >> 31 ? ~bits : bits | 0x80000000u;
      order_[t] = std::uint64_t{ascending} << 32 | t;
    }
    std::nth_element(order_.begin(), order_.begin() + left, order_.end());
    for (Index k = 0; k < size(); ++k) side_[static_cast<Index>(order_[k])] = k < left ? kLeft : kRight;
  }

  // Every triangle needs a neighbour in its half that is nearer to the half's end; one that has none changes
  // sides. True when all have: both halves hang together then.
  bool mend(Index first, Index second) {
    for (int round = 0; round < kMostMendings; ++round) {
      bool moved = false;
      for (Index t = 0; t < size(); ++t) {
        if (t == first || t == second) continue;
        const float* distance = side_[t] == kLeft ? far() : second_far_.data();
        bool held = false;
        for_each_neighbour(t, [&](Index other, float) {
          held |= side_[other] == side_[t] && distance[other] < distance[t];
        });
        if (held) continue;
        side_[t] = side_[t] == kLeft ? kRight : kLeft;
        moved = true;
      }
      if (!moved) return true;
    }
    return false;
  }

  // Moves what does not hang together with `first` in the left half, or with `second` in the right one,
  // across.
  void exchange_fragments(Index first, Index second) {
    queue_.clear();
    flood(first);
    for (std::uint8_t& side : side_) {
      if (side == kLeft) side = kRight;
    }
    flood(second);
    for (std::uint8_t& side : side_) side = side == kReachedRight ? kRight : kLeft;
  }

  // A piece of several components: they are kept whole where that balances, and stand sorted along the
  // longest axis of their centres. The queue holds the first one already.
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
    int axis = 0;
    (high - low).maxCoeff(&axis);
    std::stable_sort(components.begin(), components.end(),
                     [&](const Component& a, const Component& b) { return a.center[axis] < b.center[axis]; });
    std::size_t place = 0;
    for (const Component& c : components) {
      const auto begin = queue_.begin() + static_cast<std::ptrdiff_t>(c.begin),
                 end = queue_.begin() + static_cast<std::ptrdiff_t>(c.end);
      // The component that the cut falls into is ordered along the axis, so that the cut is a plane.
      if (place < left && place + (c.end - c.begin) > left) {
        std::sort(begin, end, [&](Index a, Index b) {
          return std::pair(center(a)[axis], a) < std::pair(center(b)[axis], b);
        });
      }
      for (auto t = begin; t != end; ++t) side_[*t] = place++ < left ? kLeft : kRight;
    }
  }
  Vec3 center(Index t) const { return centers_.of(from_->ids[piece_.begin + t]); }

  // Writes the halves one behind the other, each with its own numbers.
  std::array<Piece, 2> move(Surface& to, bool measured) {
    Index counts[2] = {0, 0};
    place_.resize(size());
    for (Index t = 0; t < size(); ++t) place_[t] = counts[side_[t]]++;
    Index at = piece_.begin, entry = neighbours_.front().begin;
    for (const Side half : {kLeft, kRight}) {
      const float* distance = half == kLeft ? far() : second_far_.data();
      for (Index t = 0; t < size(); ++t) {
        if (side_[t] != half) continue;
        to.ids[at] = from_->ids[piece_.begin + t];
        if (measured) to.far[at] = distance[t];
        const Index begin = entry;
        for_each_neighbour(t, [&](Index other, float length) {
          if (side_[other] != half) return;
          to.to[entry] = place_[other];
          to.length[entry++] = length;
        });
        to.neighbours[at++] = {begin, entry};
      }
    }
    const Index middle = piece_.begin + counts[kLeft];
    return {Piece{piece_.begin, middle, measured}, Piece{middle, piece_.end, measured}};
  }

  const Centers& centers_;
  Surface* from_ = nullptr;
  Piece piece_{};
  std::span<const Neighbours> neighbours_;
  std::vector<std::uint8_t> side_;
  std::vector<Index> queue_, place_;
  std::vector<float> second_far_, gone_at_;
  std::vector<std::uint64_t> order_;
  std::vector<std::vector<Index>> buckets_;
};

// Triangles in the order in which a walk over the surface meets them, so that neighbours stand near each
// other however the user has numbered them.
class Walk {
 public:
  explicit Walk(const Topology& topology) : sides_(topology.triangle_edges()) {
    std::vector<Index>& begin = edge_begin_;
    begin.assign(topology.edges().size() + 1, 0);
    for_each_side([&](Index e, Index) { ++begin[e + 1]; });
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    edge_triangles_.resize(begin.back());
    std::vector<Index> fill(begin.begin(), begin.end() - 1);
    for_each_side([&](Index e, Index t) { edge_triangles_[fill[e]++] = t; });
  }

  std::vector<Index> order() const {
    std::vector<Index> order;
    order.reserve(sides_.size());
    std::vector<bool> met(sides_.size(), false);
    for (Index start = 0; start < sides_.size(); ++start) {
      if (met[start]) continue;
      met[start] = true;
      order.push_back(start);
      for (std::size_t i = order.size() - 1; i < order.size(); ++i) {
        for_each_neighbour(order[i], [&](Index other) {
          if (met[other]) return;
          met[other] = true;
          order.push_back(other);
        });
      }
    }
    return order;
  }

  // Of many triangles at an edge each has the one before and the one behind it.
  template <class Visit>
  void for_each_neighbour(Index t, Visit visit) const {
    for (const Index e : sides_[t]) {
      if (e == kNoIndex) continue;
      const auto first = edge_triangles_.begin() + edge_begin_[e],
                 end = edge_triangles_.begin() + edge_begin_[e + 1];
      const auto self = std::lower_bound(first, end, t);
      if (self != first && *(self - 1) != t) visit(*(self - 1));
      if (self + 1 != end && *(self + 1) != t) visit(*(self + 1));
    }
  }

 private:
  template <class Visit>
  void for_each_side(Visit visit) const {
    for (Index t = 0; t < sides_.size(); ++t) {
      for (const Index e : sides_[t]) {
        if (e != kNoIndex) visit(e, t);
      }
    }
  }

  std::span<const std::array<Index, 3>> sides_;
  std::vector<Index> edge_begin_, edge_triangles_;  // per edge: its triangles, ascending
};

std::array<Surface, 2> surface_of(const Topology& topology, const Centers& centers) {
  std::array<Surface, 2> both;
  Surface& surface = both[0];
  const Walk walk(topology);
  surface.ids = walk.order();
  std::vector<Index> place(surface.ids.size());
  for (Index k = 0; k < place.size(); ++k) place[surface.ids[k]] = k;
  for (const Index t : surface.ids) {
    const auto begin = static_cast<Index>(surface.to.size());
    const Vec3 center = centers.of(t);
    walk.for_each_neighbour(t, [&](Index other) {
      surface.to.push_back(place[other]);
      surface.length.push_back(static_cast<float>((centers.of(other) - center).norm()));
    });
    surface.neighbours.push_back({begin, static_cast<Index>(surface.to.size())});
  }
  surface.far.resize(surface.ids.size());
  both[1] = surface;
  return both;
}

/// The tree below one piece, or its top.
class Plan {
 public:
  struct Task {
    Piece piece;
    int buffer;
  };
  static constexpr Index kSubtree = kNoIndex;  // in place of a leaf's size

  Plan(Index leaf_triangles, std::array<Surface, 2>& buffers, std::span<Index> triangle_ids)
      : leaf_triangles_(leaf_triangles), buffers_(buffers), triangle_ids_(triangle_ids) {}

  /// Cuts until pieces are leaves, or no larger than `stop`: those are left for others.
  void make(Task root, Index stop, Cutter& cutter) {
    std::vector<Task> tasks{root};
    while (!tasks.empty()) {
      const Task task = tasks.back();
      tasks.pop_back();
      const Index size = task.piece.size();
      Surface& from = buffers_[task.buffer];
      // A few more than asked for is better than two leaves half full.
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
          cutter.cut(task.piece, leaves / 2 * (size / leaves), from, buffers_[1 - task.buffer]);
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
  Plan top(leaf_triangles, buffers, split.triangle_ids);
  {
    Cutter cutter(centers);
    top.make({{0, count, false}, 0}, kPieceOfThread, cutter);
  }
  std::vector<Plan> below(top.subtrees.size(), Plan(leaf_triangles, buffers, split.triangle_ids));
  PerThread<Cutter> cutters([&] { return Cutter(centers); });
  parallel_for(std::size_t{0}, below.size(),
               [&](std::size_t k) { below[k].make(top.subtrees[k], 0, cutters.local()); });
  std::size_t next = 0;
  for (const Index size : top.leaf_sizes) {
    if (size != Plan::kSubtree) {
      split.leaf_sizes.push_back(size);
      continue;
    }
    const std::vector<Index>& sizes = below[next++].leaf_sizes;
    split.leaf_sizes.insert(split.leaf_sizes.end(), sizes.begin(), sizes.end());
  }
  return split;
}

}  // namespace foldproof
