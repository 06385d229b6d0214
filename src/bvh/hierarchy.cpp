#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "foldproof/bvh.h"

namespace foldproof {
namespace {

// Splits triangles into halves that are connected where the surface is: by the difference of the distances
// over the surface from two far ends of the piece. Going towards the first end never raises that difference,
// so the part below any threshold hangs together, and so does the rest; but for dead ends, all of one
// difference, that a threshold cuts: what it cuts off goes to the other half.
class Splitter {
 public:
  Splitter(const Topology& topology, std::span<const double> positions)
      : triangles_(topology.triangles()), mark_(triangles_.size(), 0) {
    connect(topology);
    centers_.reserve(triangles_.size());
    for (const Triangle& t : triangles_) {
      Vec3 sum = Vec3::Zero();
      for (const Index v : t) sum += Eigen::Map<const Vec3>(&positions[3 * std::size_t{v}]) / 3;
      centers_.push_back(sum);
    }
    distance_.resize(triangles_.size());
    key_.resize(triangles_.size());
  }

  // Reorders `piece` so that its first triangles are one half, about `left` of them; returns how many.
  std::size_t split(std::span<Index> piece, std::size_t left) {
    ++round_;
    for (const Index t : piece) mark_[t] = 2 * round_;
    if (flood(piece.front(), 2 * round_) < piece.size()) {
      order_components(piece, left);
      return left;
    }
    const Index first = queue_.back();
    measure(piece, first);
    for (const Index t : piece) key_[t] = distance_[t];
    const Index second = *std::max_element(piece.begin(), piece.end(),
                                           [&](Index a, Index b) { return distance_[a] < distance_[b]; });
    measure(piece, second);
    for (const Index t : piece) key_[t] -= distance_[t];
    std::nth_element(piece.begin(), piece.begin() + left, piece.end(),
                     [&](Index a, Index b) { return std::pair(key_[a], a) < std::pair(key_[b], b); });
    return exchange_fragments(piece, left, first, second);
  }

 private:
  void connect(const Topology& topology) {
    const auto sides = topology.triangle_edges();
    edge_begin_.assign(topology.edges().size() + 1, 0);
    for (const auto& t : sides) {
      for (const Index e : t) {
        if (e != kNoIndex) ++edge_begin_[e + 1];
      }
    }
    std::partial_sum(edge_begin_.begin(), edge_begin_.end(), edge_begin_.begin());
    edge_triangles_.resize(edge_begin_.back());
    std::vector<Index> fill(edge_begin_.begin(), edge_begin_.end() - 1);
    for (Index t = 0; t < sides.size(); ++t) {
      for (const Index e : sides[t]) {
        if (e != kNoIndex) edge_triangles_[fill[e]++] = t;
      }
    }
    sides_ = sides;
  }

  // Breadth first over triangles with this mark; raises the mark by one and fills queue_.
  std::size_t flood(Index start, std::uint32_t mark) {
    queue_.clear();
    queue_.push_back(start);
    mark_[start] = mark + 1;
    for (std::size_t i = 0; i < queue_.size(); ++i) {
      const Index t = queue_[i];
      for (const Index e : sides_[t]) {
        if (e == kNoIndex) continue;
        for (Index k = edge_begin_[e]; k < edge_begin_[e + 1]; ++k) {
          const Index other = edge_triangles_[k];
          if (mark_[other] != mark) continue;
          mark_[other] = mark + 1;
          queue_.push_back(other);
        }
      }
    }
    return queue_.size();
  }

  // Moves what does not hang together with `first` in the left half, or with `second` in the right one,
  // across.
  std::size_t exchange_fragments(std::span<Index> piece, std::size_t left, Index first, Index second) {
    round_ += 2;
    const std::uint32_t in_left = 2 * round_ - 2, in_right = 2 * round_;
    for (std::size_t i = 0; i < piece.size(); ++i) mark_[piece[i]] = i < left ? in_left : in_right;
    if (mark_[first] != in_left || mark_[second] != in_right) return left;
    flood(first, in_left);
    for (const Index t : piece.first(left)) {
      if (mark_[t] == in_left) mark_[t] = in_right;
    }
    flood(second, in_right);
    const auto middle =
        std::partition(piece.begin(), piece.end(), [&](Index t) { return mark_[t] != in_right + 1; });
    return static_cast<std::size_t>(middle - piece.begin());
  }

  // Shortest paths from triangle to triangle, centre to centre over shared edges, from `start` to all of the
  // piece.
  void measure(std::span<const Index> piece, Index start) {
    const std::uint32_t inside = mark_[start];
    for (const Index t : piece) distance_[t] = std::numeric_limits<double>::max();
    using Entry = std::pair<double, Index>;
    heap_.assign(1, {0.0, start});
    distance_[start] = 0;
    while (!heap_.empty()) {
      const auto [d, t] = heap_.front();
      std::pop_heap(heap_.begin(), heap_.end(), std::greater<Entry>());
      heap_.pop_back();
      if (d > distance_[t]) continue;
      for (const Index e : sides_[t]) {
        if (e == kNoIndex) continue;
        for (Index k = edge_begin_[e]; k < edge_begin_[e + 1]; ++k) {
          const Index other = edge_triangles_[k];
          if (mark_[other] != inside) continue;
          const double through = d + (centers_[other] - centers_[t]).norm();
          if (!(through < distance_[other])) continue;
          distance_[other] = through;
          heap_.emplace_back(through, other);
          std::push_heap(heap_.begin(), heap_.end(), std::greater<Entry>());
        }
      }
    }
  }

  // A piece of several components: they are kept whole where that balances, and stand sorted along the
  // longest axis of their centres. The queue holds the first one already.
  void order_components(std::span<Index> piece, std::size_t left) {
    struct Component {
      std::vector<Index> triangles;
      Vec3 center = Vec3::Zero();
    };
    std::vector<Component> components;
    std::vector<Index> rest(piece.begin(), piece.end());
    for (const Index t : rest) {
      if (!components.empty()) {
        if (mark_[t] != 2 * round_) continue;
        flood(t, 2 * round_);
      }
      Component c;
      c.triangles = queue_;
      for (const Index k : queue_) c.center += centers_[k] / static_cast<double>(queue_.size());
      components.push_back(std::move(c));
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
      // The component that the cut falls into is ordered along the axis, so that the cut is a plane.
      std::vector<Index> triangles = c.triangles;
      if (place < left && place + triangles.size() > left) {
        std::sort(triangles.begin(), triangles.end(), [&](Index a, Index b) {
          return std::pair(centers_[a][axis], a) < std::pair(centers_[b][axis], b);
        });
      }
      for (const Index t : triangles) piece[place++] = t;
    }
  }

  std::span<const Triangle> triangles_;
  std::span<const std::array<Index, 3>> sides_;
  std::vector<Index> edge_begin_, edge_triangles_;
  std::vector<Vec3> centers_;
  std::vector<std::uint32_t> mark_;
  std::vector<Index> queue_;
  std::vector<std::pair<double, Index>> heap_;
  std::vector<double> distance_, key_;
  std::uint32_t round_ = 0;
};

Result<void> check_positions(const Topology& topology, std::span<const double> positions) {
  if (positions.size() != 3 * std::size_t{topology.vertex_count()}) {
    return fail("positions",
                fmt::format("{} numbers for {} vertices", positions.size(), topology.vertex_count()),
                "give three coordinates per vertex");
  }
  for (std::size_t i = 0; i < positions.size(); ++i) {
    if (!std::isfinite(positions[i])) {
      return fail(fmt::format("vertex {}", i / 3), "has a coordinate that is not finite",
                  "repair the positions");
    }
  }
  return {};
}

}  // namespace

Result<Hierarchy> Hierarchy::build(Topology topology, std::span<const double> positions,
                                   const HierarchySettings& settings) {
  if (auto ok = check_positions(topology, positions); !ok) return tl::unexpected(ok.error());
  Hierarchy tree;
  tree.topology_ = std::move(topology);
  tree.split(positions, std::max<Index>(settings.leaf_triangles, 1));
  tree.assign_owners();
  return tree;
}

Result<Hierarchy> Hierarchy::from_parts(Topology topology, std::vector<Index> triangle_ids,
                                        std::span<const Index> leaf_sizes) {
  const std::size_t count = topology.triangles().size();
  std::vector<bool> seen(count, false);
  bool permutation = triangle_ids.size() == count;
  for (std::size_t k = 0; permutation && k < count; ++k) {
    permutation = triangle_ids[k] < count && !seen[triangle_ids[k]];
    if (permutation) seen[triangle_ids[k]] = true;
  }
  if (!permutation) return fail("triangle order", "does not name every triangle once", "build it anew");
  Hierarchy tree;
  tree.topology_ = std::move(topology);
  tree.triangle_ids_ = std::move(triangle_ids);
  if (!tree.plant(leaf_sizes)) return fail("nodes", "do not form a tree over the triangles", "build it anew");
  tree.assign_owners();
  return tree;
}

// Nodes and leaves from the number of triangles per node in depth-first order. False when they are no tree.
bool Hierarchy::plant(std::span<const Index> leaf_sizes) {
  const std::size_t count = topology_.triangles().size();
  std::size_t planted = 0;
  std::vector<Index> open;  // inner nodes whose right child is still to come
  for (Index id = 0; id < leaf_sizes.size(); ++id) {
    if (id > 0 && nodes_[id - 1].leaf_begin != leaves_.size()) {  // what precedes is a leaf, not the parent
      if (open.empty()) return false;
      nodes_[open.back()].right = id;
      open.pop_back();
    }
    Node node;
    node.leaf_begin = static_cast<Index>(leaves_.size());
    nodes_.push_back(node);
    if (leaf_sizes[id] == 0) {
      open.push_back(id);
      continue;
    }
    if (leaf_sizes[id] > count - planted) return false;
    leaves_.push_back({static_cast<Index>(planted), 0, 0});
    planted += leaf_sizes[id];
  }
  if (nodes_.empty() || !open.empty() || planted != count || leaf_sizes.back() == 0) return false;
  leaves_.push_back({static_cast<Index>(count), 0, 0});
  close_ranges();
  return true;
}

void Hierarchy::split(std::span<const double> positions, Index leaf_triangles) {
  const std::size_t count = topology_.triangles().size();
  triangle_ids_.resize(count);
  std::iota(triangle_ids_.begin(), triangle_ids_.end(), 0u);
  Splitter splitter(topology_, positions);

  struct Task {
    std::size_t begin, end;
    Index parent;  // whose right child this is; kNoIndex for left children and the root
  };
  std::vector<Task> tasks{{0, count, kNoIndex}};
  while (!tasks.empty()) {
    const Task task = tasks.back();
    tasks.pop_back();
    const Index id = static_cast<Index>(nodes_.size());
    if (task.parent != kNoIndex) nodes_[task.parent].right = id;
    Node node;
    node.leaf_begin = static_cast<Index>(leaves_.size());
    nodes_.push_back(node);
    const std::size_t size = task.end - task.begin;
    // A few more than asked for is better than two leaves half full.
    if (size <= leaf_triangles + leaf_triangles / 4) {
      leaves_.push_back({static_cast<Index>(task.begin), 0, 0});
      continue;
    }
    // Whole leaves on the left, so that leaves come out full.
    const std::size_t leaves = std::max<std::size_t>((size + leaf_triangles / 2) / leaf_triangles, 2);
    const std::size_t left =
        splitter.split(std::span(triangle_ids_).subspan(task.begin, size), leaves / 2 * (size / leaves));
    tasks.push_back({task.begin + left, task.end, id});
    tasks.push_back({task.begin, task.begin + left, kNoIndex});
  }
  leaves_.push_back({static_cast<Index>(count), 0, 0});
  close_ranges();
}

// Children stand after their parents, so one sweep from the back closes every range of leaves.
void Hierarchy::close_ranges() {
  for (std::size_t i = nodes_.size(); i-- > 0;) {
    Node& node = nodes_[i];
    node.leaf_end = node.is_leaf() ? node.leaf_begin + 1 : nodes_[node.right].leaf_end;
  }
}

void Hierarchy::assign_owners() {
  std::vector<Index> vertex_place(topology_.vertex_count(), kNoIndex);
  std::vector<bool> edge_owned(topology_.edges().size(), false);
  const auto all_triangles = topology_.triangles();
  const auto sides = topology_.triangle_edges();
  triangles_.reserve(all_triangles.size());
  for (Index leaf = 0; leaf < leaf_count(); ++leaf) {
    leaves_[leaf].edges = static_cast<Index>(edge_ids_.size());
    leaves_[leaf].vertices = static_cast<Index>(vertex_ids_.size());
    for (Index k = leaves_[leaf].triangles; k < leaves_[leaf + 1].triangles; ++k) {
      const Index id = triangle_ids_[k];
      Triangle local;
      for (int c = 0; c < 3; ++c) {
        Index& place = vertex_place[all_triangles[id][c]];
        if (place == kNoIndex) {
          place = static_cast<Index>(vertex_ids_.size());
          vertex_ids_.push_back(all_triangles[id][c]);
        }
        local[c] = place;
        const Index edge = sides[id][c];
        if (edge != kNoIndex && !edge_owned[edge]) {
          edge_owned[edge] = true;
          edge_ids_.push_back(edge);
        }
      }
      triangles_.push_back(local);
    }
  }
  leaves_.back().edges = static_cast<Index>(edge_ids_.size());
  leaves_.back().vertices = static_cast<Index>(vertex_ids_.size());
  edges_.reserve(edge_ids_.size());
  for (const Index id : edge_ids_) {
    const Edge& edge = topology_.edges()[id];
    edges_.push_back({vertex_place[edge[0]], vertex_place[edge[1]]});
  }
}

}  // namespace foldproof
