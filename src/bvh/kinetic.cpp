#include "bvh/kinetic.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <cmath>
#include <limits>

#undef HWY_TARGET_INCLUDE  // Highway compiles this file once per instruction set
#define HWY_TARGET_INCLUDE "bvh/kinetic.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "bvh/grid.h"

HWY_BEFORE_NAMESPACE();
namespace foldproof::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// The box of the vertices with these ids; at least one.
void FitBox(const MovingVertex* vertices, std::span<const Index> ids, KineticBox& box) {
  const hn::CappedTag<float, 4> d;
  for (int end = 0; end < 2; ++end) {
    for (std::size_t lane = 0; lane < 4; lane += hn::Lanes(d)) {
      const std::size_t offset = 4 * end + lane;
      auto lower = hn::Load(d, vertices[ids[0]].x + offset), upper = lower;
      for (const Index id : ids.subspan(1)) {
        const auto p = hn::Load(d, vertices[id].x + offset);
        lower = hn::Min(lower, p);
        upper = hn::Max(upper, p);
      }
      hn::Store(lower, d, box.x[end][0] + lane);
      hn::Store(hn::Neg(upper), d, box.x[end][1] + lane);
    }
  }
}

void FitLeaves(const MovingVertex* vertices, std::span<const LeafVertices> leaves, KineticBox* boxes) {
  for (const LeafVertices& leaf : leaves) FitBox(vertices, leaf.vertices, boxes[leaf.node]);
}

// Both ends of the vertices with these ids into the frame, and what lies around them.
void Move(const Frame& frame, std::span<const Index> ids, std::span<const double> x0,
          std::span<const double> x1, MovingVertex* vertices, Bounds& bounds) {
  const hn::CappedTag<double, 4> d;
  const hn::Rebind<float, decltype(d)> df;
  alignas(32) const double center[4] = {frame.center.x(), frame.center.y(), frame.center.z(), 0};
  alignas(32) double low[4], high[4], poison[4];  // poison: zero unless a coordinate is infinite or NaN
  const auto scale = hn::Set(d, frame.scale);
  for (std::size_t lane = 0; lane < 4; lane += hn::Lanes(d)) {
    const auto three = hn::FirstN(d, lane < 3 ? 3 - lane : 0);
    const auto middle = hn::Load(d, center + lane);
    auto lowest = hn::Set(d, std::numeric_limits<double>::infinity()), highest = hn::Neg(lowest);
    auto poisoned = hn::Zero(d);
    for (std::size_t i = 0; i < ids.size(); ++i) {
      const std::size_t at = 3 * std::size_t{ids[i]};
      float* out = vertices[i].x + lane;
      for (const auto x : {x0, x1}) {
        const double* from = &x[at];
        double last[4] = {0, 0, 0, 0};  // behind the last vertex there is nothing to be read
        if (at + 4 > x.size()) from = std::copy_n(from, 3, last) - 3;
        const auto p = hn::IfThenElseZero(three, hn::LoadU(d, from + lane));
        lowest = hn::Min(lowest, p);
        highest = hn::Max(highest, p);
        poisoned = hn::Add(poisoned, hn::Mul(p, hn::Zero(d)));
        const auto y = hn::Mul(hn::Sub(p, middle), scale);
        hn::Store(hn::DemoteTo(df, y), df, out);
        out += 4;
      }
    }
    hn::Store(lowest, d, low + lane);
    hn::Store(highest, d, high + lane);
    hn::Store(poisoned, d, poison + lane);
  }
  for (int axis = 0; axis < 3; ++axis) {
    bounds.low[axis] = std::min(bounds.low[axis], low[axis]);
    bounds.high[axis] = std::max(bounds.high[axis], high[axis]);
    bounds.finite &= poison[axis] == 0;
  }
}

// Children stand behind their parents: one sweep from the back closes a subtree.
void UniteInnerNodes(std::span<const Hierarchy::Node> nodes, Index first, Index count, KineticBox* boxes) {
  const hn::CappedTag<float, 16> d;
  for (std::size_t i = first + count; i-- > first;) {
    if (nodes[i].is_leaf()) continue;
    const float *a = boxes[i + 1].x[0][0], *b = boxes[nodes[i].right].x[0][0];
    for (std::size_t lane = 0; lane < 16; lane += hn::Lanes(d)) {
      hn::Store(hn::Min(hn::Load(d, a + lane), hn::Load(d, b + lane)), d, boxes[i].x[0][0] + lane);
    }
  }
}

// Places of the leaf's own features lie between 1 and 254, so that others can lie outside.
void FitGrid(const KineticBox& box, LeafGrid& grid) {
  constexpr float kSteps = 252, kLeast = 0x1p-20f;
  for (int end = 0; end < 2; ++end) {
    for (int axis = 0; axis < 4; ++axis) {
      const float side = std::max(-box.x[end][1][axis] - box.x[end][0][axis], kLeast);
      grid.origin[4 * end + axis] = box.x[end][0][axis] - side * (1.5f / kSteps);
      grid.scale[4 * end + axis] = kSteps / side;
    }
  }
}

// Boxes one after the other -> coordinates one after the other.
HWY_INLINE void Transpose(const ByteBox (&boxes)[16], Index lane, BoxBlock& block) {
#if HWY_TARGET == HWY_SCALAR
  for (int row = 0; row < 16; ++row) {
    if (row % 4 == 3) continue;
    for (int i = 0; i < 16; ++i)
      block.x[row / 8][row / 4 % 2][row % 4][lane + i] = boxes[i].x[row / 8][row % 8];
  }
#else
  const hn::Full128<std::uint8_t> d;
  hn::Vec<hn::Full128<std::uint8_t> > from[16], to[16];
  for (int i = 0; i < 16; ++i) to[i] = hn::Load(d, boxes[i].x[0]);
  for (int round = 0; round < 4; ++round) {
    for (int i = 0; i < 16; ++i) from[i] = to[i];
    for (int i = 0; i < 8; ++i) {
      to[2 * i] = hn::InterleaveLower(d, from[i], from[i + 8]);
      to[2 * i + 1] = hn::InterleaveUpper(d, from[i], from[i + 8]);
    }
  }
  for (int row = 0; row < 16; ++row) {
    if (row % 4 < 3) hn::Store(to[row], d, block.x[row / 8][row / 4 % 2][row % 4] + lane);
  }
#endif
}

template <int N>
HWY_INLINE void FillBlocks(const MovingVertex* vertices, const LeafGrid& grid, Index leaf,
                           FeatureBlocks<N>& features) {
  for (Index b = features.begin[leaf]; b < features.begin[leaf + 1]; ++b) {
    const int count = __builtin_popcount(features.used[b]);
    for (int first = 0; first < count; first += 16) {
      ByteBox boxes[16] = {};
      for (int k = 0; k < std::min(16, count - first); ++k)
        PlaceFeature(vertices, features.ids[b], first + k, 0, grid, boxes[k]);
      Transpose(boxes, first, features.boxes[b]);
    }
  }
}

void FillLeafFeatures(KineticTree& tree, Index leaf) {
  LeafGrid& grid = tree.grids[leaf];
  FitGrid(tree.boxes[tree.leaf_node(leaf)], grid);
  FillBlocks(tree.vertices.data(), grid, leaf, tree.vertex_blocks);
  FillBlocks(tree.vertices.data(), grid, leaf, tree.edge_blocks);
  FillBlocks(tree.vertices.data(), grid, leaf, tree.face_blocks);
}

}  // namespace foldproof::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace foldproof {

HWY_EXPORT(FitLeaves);
HWY_EXPORT(UniteInnerNodes);
HWY_EXPORT(Move);
HWY_EXPORT(FillLeafFeatures);

namespace {

// Lays out features [begin(leaf), begin(leaf + 1)) of every leaf in blocks.
template <int N, class BeginOf, class VerticesOf>
FeatureBlocks<N> lay_out(Index leaf_count, BeginOf begin_of, VerticesOf vertices_of) {
  FeatureBlocks<N> features;
  features.begin.push_back(0);
  for (Index leaf = 0; leaf < leaf_count; ++leaf) {
    const Index end = begin_of(leaf + 1);
    for (Index first = begin_of(leaf); first < end; first += kBlock) {
      const Index used = std::min(kBlock, end - first);
      IdBlock<N>& ids = features.ids.emplace_back();
      for (Index lane = 0; lane < kBlock; ++lane) {
        const auto vertices = vertices_of(first + (lane < used ? lane : 0));
        for (int k = 0; k < N; ++k) ids.v[k][lane] = vertices[k];
      }
      features.first.push_back(first);
      features.used.push_back(~std::uint32_t{0} >> (kBlock - used));
    }
    features.begin.push_back(static_cast<Index>(features.ids.size()));
  }
  features.boxes.resize(features.ids.size());
  return features;
}

}  // namespace

KineticTree::KineticTree(std::shared_ptr<const Hierarchy> tree) : hierarchy(std::move(tree)) {
  const Hierarchy& h = *hierarchy;
  const auto leaves = h.leaves();
  vertices.resize(h.vertex_ids().size());
  boxes.resize(h.nodes().size());
  grids.resize(h.leaf_count());
  vertex_blocks = lay_out<1>(
      h.leaf_count(), [&](Index leaf) { return leaves[leaf].vertices; },
      [](Index v) { return std::array<Index, 1>{v}; });
  edge_blocks = lay_out<2>(
      h.leaf_count(), [&](Index leaf) { return leaves[leaf].edges; }, [&](Index e) { return h.edges()[e]; });
  face_blocks = lay_out<3>(
      h.leaf_count(), [&](Index leaf) { return leaves[leaf].triangles; },
      [&](Index t) { return h.triangles()[t]; });
  find_leaves();
}

void KineticTree::find_leaves() {
  constexpr Index kLeavesOfTask = 256;
  const Hierarchy& h = *hierarchy;
  for (Index node = 0; node < h.nodes().size();) {
    const Index leaves = h.nodes()[node].leaf_end - h.nodes()[node].leaf_begin;
    (leaves <= kLeavesOfTask ? subtrees_ : above_).push_back(node);
    node += leaves <= kLeavesOfTask ? 2 * leaves - 1 : 1;
  }
  auto lists = list_leaf_vertices(h);
  leaf_vertex_ids_ = std::move(lists.places);
  for (Index node = 0; node < h.nodes().size(); ++node) {
    if (!h.nodes()[node].is_leaf()) continue;
    const Index leaf = h.nodes()[node].leaf_begin, begin = lists.begin[leaf];
    leaves_.push_back({std::span(leaf_vertex_ids_).subspan(begin, lists.begin[leaf + 1] - begin), node});
  }
}

Bounds KineticTree::move(const Frame& frame, std::span<const double> x0, std::span<const double> x1) {
  using Range = tbb::blocked_range<std::size_t>;
  const auto ids = hierarchy->vertex_ids();
  return tbb::parallel_reduce(
      Range(0, ids.size(), 4096), Bounds{},
      [&](const Range& range, Bounds b) {
        HWY_DYNAMIC_DISPATCH(Move)
        (frame, ids.subspan(range.begin(), range.size()), x0, x1, &vertices[range.begin()], b);
        return b;
      },
      [](Bounds a, const Bounds& b) {
        return Bounds{a.low.cwiseMin(b.low), a.high.cwiseMax(b.high), a.finite && b.finite};
      });
}

void KineticTree::fit() {
  const auto nodes = hierarchy->nodes();
  tbb::parallel_for(std::size_t{0}, subtrees_.size(), [&](std::size_t k) {
    const Hierarchy::Node& root = nodes[subtrees_[k]];
    const Index count = root.leaf_end - root.leaf_begin;
    HWY_DYNAMIC_DISPATCH(FitLeaves)
    (vertices.data(), std::span(leaves_).subspan(root.leaf_begin, count), boxes.data());
    HWY_DYNAMIC_DISPATCH(UniteInnerNodes)(nodes, subtrees_[k], 2 * count - 1, boxes.data());
  });
  for (auto node = above_.rbegin(); node != above_.rend(); ++node)
    HWY_DYNAMIC_DISPATCH(UniteInnerNodes)(nodes, *node, 1, boxes.data());
}

void KineticTree::move_vertex(const Frame& frame, Index place, const double* x0, const double* x1) {
  const Index only = 0;
  Bounds unused;
  HWY_DYNAMIC_DISPATCH(Move)(frame, {&only, 1}, {x0, 3}, {x1, 3}, &vertices[place], unused);
}

void KineticTree::fit_leaf(Index leaf) {
  HWY_DYNAMIC_DISPATCH(FitLeaves)(vertices.data(), std::span(leaves_).subspan(leaf, 1), boxes.data());
}

void KineticTree::fill_features(Index leaf) { HWY_DYNAMIC_DISPATCH(FillLeafFeatures)(*this, leaf); }

LeafVertexLists list_leaf_vertices(const Hierarchy& h) {
  LeafVertexLists lists{{0}, {}};
  for (Index leaf = 0; leaf < h.leaf_count(); ++leaf) {
    const auto offset = static_cast<std::ptrdiff_t>(lists.begin.back());
    for (Index t = h.leaves()[leaf].triangles; t < h.leaves()[leaf + 1].triangles; ++t)
      lists.places.insert(lists.places.end(), h.triangles()[t].begin(), h.triangles()[t].end());
    std::sort(lists.places.begin() + offset, lists.places.end());
    lists.places.erase(std::unique(lists.places.begin() + offset, lists.places.end()), lists.places.end());
    lists.begin.push_back(static_cast<Index>(lists.places.size()));
  }
  lists.places.shrink_to_fit();
  return lists;
}

// Halves first, so that the largest doubles do not overflow.
Frame frame_around(const Vec3& low, const Vec3& high) {
  Frame frame;
  const Vec3 middle = low / 2 + high / 2;
  // The centre is rounded, hence a little room.
  const double half = (high / 2 - low / 2).maxCoeff();
  const double reach = half * (1 + 0x1p-50) + middle.cwiseAbs().maxCoeff() * 0x1p-51;
  frame.center = middle;
  if (!(reach > 0)) return frame;
  // Everything lies within a half of the middle, and that within a sixteenth of the centre.
  frame.scale = std::ldexp(1.0, -std::clamp(std::ilogb(reach) + 2, -1020, 1025));
  for (double& c : frame.center) c = std::nearbyint(c * frame.scale * 8) / (frame.scale * 8);
  return frame;
}

Frame frame_around(std::span<const double> x) {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (std::size_t i = 0; i < x.size(); i += 3) {
    const Eigen::Map<const Vec3> corner(&x[i]);
    low = low.cwiseMin(corner);
    high = high.cwiseMax(corner);
  }
  return frame_around(low, high);
}

float separation_margin(const Frame& frame, double distance) {
  constexpr double kRounding = 0x1.1p-22;  // docs/soundness.md, B2
  const double margin = distance * frame.scale * (1 + 0x1p-50) + kRounding;
  // Never infinite: the infinite boxes of empty lanes must stay apart.
  if (!(margin < 0x1p127)) return std::numeric_limits<float>::max();
  return std::nextafter(static_cast<float>(margin), std::numeric_limits<float>::infinity());
}

}  // namespace foldproof
#endif  // HWY_ONCE
