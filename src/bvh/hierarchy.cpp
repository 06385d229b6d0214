#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "foldproof/bvh.h"

namespace foldproof {
namespace {

// Splits triangles into halves that are connected where the surface is: by the difference of the distances, in
// steps over shared edges, from two far ends of the piece. Going towards the first end never raises that difference,
// so the part below any threshold hangs together.
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
    near_.resize(triangles_.size());
    key_.resize(triangles_.size());
  }

  // Reorders `piece` so that the first `left` triangles are one half.
  void split(std::span<Index> piece, std::size_t left) {
    ++round_;
    for (const Index t : piece) mark_[t] = 2 * round_;
    if (flood(piece.front(), 2 * round_) < piece.size()) {
      order_components(piece, left);
      return;
    }
    const Index first = queue_.back();
    flood(first, 2 * round_ + 1);
    for (const Index t : piece) key_[t] = static_cast<double>(near_[t]);
    const Index second = queue_.back();
    ++round_;
    for (const Index t : piece) mark_[t] = 2 * round_;
    flood(second, 2 * round_);
    // Hops tie in whole bands; inside a band the direction from end to end decides.
    const Vec3 direction = centers_[second] - centers_[first];
    const double length2 = std::max(direction.squaredNorm(), std::numeric_limits<double>::min());
    for (const Index t : piece) {
      const double along = (centers_[t] - centers_[first]).dot(direction) / length2;
      key_[t] -= static_cast<double>(near_[t]);
      if (std::isfinite(along)) key_[t] += 0.25 * std::clamp(along, -1.0, 2.0);
    }
    std::nth_element(piece.begin(), piece.begin() + left, piece.end(),
                     [&](Index a, Index b) { return std::pair(key_[a], a) < std::pair(key_[b], b); });
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

  // Breadth first over triangles with this mark; raises the mark by one, fills near_ and queue_.
  std::size_t flood(Index start, std::uint32_t mark) {
    queue_.clear();
    queue_.push_back(start);
    mark_[start] = mark + 1;
    near_[start] = 0;
    for (std::size_t i = 0; i < queue_.size(); ++i) {
      const Index t = queue_[i];
      for (const Index e : sides_[t]) {
        if (e == kNoIndex) continue;
        for (Index k = edge_begin_[e]; k < edge_begin_[e + 1]; ++k) {
          const Index other = edge_triangles_[k];
          if (mark_[other] != mark) continue;
          mark_[other] = mark + 1;
          near_[other] = near_[t] + 1;
          queue_.push_back(other);
        }
      }
    }
    return queue_.size();
  }

  // A piece of several components: they are kept whole where that balances, and stand sorted along the longest
  // axis of their centres. The queue holds the first one already.
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
  std::vector<Index> near_, queue_;
  std::vector<double> key_;
  std::uint32_t round_ = 0;
};

Result<void> check_positions(const Topology& topology, std::span<const double> positions) {
  if (positions.size() != 3 * std::size_t{topology.vertex_count()}) {
    return fail("positions", fmt::format("{} numbers for {} vertices", positions.size(), topology.vertex_count()),
                "give three coordinates per vertex");
  }
  for (std::size_t i = 0; i < positions.size(); ++i) {
    if (!std::isfinite(positions[i])) {
      return fail(fmt::format("vertex {}", i / 3), "has a coordinate that is not finite", "repair the positions");
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
    if (size <= leaf_triangles) {
      leaves_.push_back({static_cast<Index>(task.begin), 0, 0});
      continue;
    }
    // Whole leaves on the left, so that leaves come out full.
    const std::size_t leaves = (size + leaf_triangles - 1) / leaf_triangles;
    const std::size_t left = leaves / 2 * (size / leaves);
    splitter.split(std::span(triangle_ids_).subspan(task.begin, size), left);
    tasks.push_back({task.begin + left, task.end, id});
    tasks.push_back({task.begin, task.begin + left, kNoIndex});
  }
  leaves_.push_back({static_cast<Index>(count), 0, 0});
  // Children stand after their parents, so one sweep from the back closes every range of leaves.
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
