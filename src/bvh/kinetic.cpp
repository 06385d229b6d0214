#include "bvh/kinetic.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/parallel.h"

#undef HWY_TARGET_INCLUDE  // Highway compiles this file once per instruction set
#define HWY_TARGET_INCLUDE "bvh/kinetic.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "bvh/grid.h"

HWY_BEFORE_NAMESPACE();
namespace foldproof::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// The box of the vertices with these ids; at least one. Minima are exact, whichever zero they give
// (tests/arithmetic, Order).
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

// Bounds on their way.
struct alignas(32) Around {
  double low[4], high[4], poison[4];  // poison: zero unless a coordinate is infinite or NaN

  void grow(Bounds& bounds) const {
    for (int axis = 0; axis < 3; ++axis) {
      bounds.low[axis] = std::min(bounds.low[axis], low[axis]);
      bounds.high[axis] = std::max(bounds.high[axis], high[axis]);
      bounds.finite &= poison[axis] == 0;
    }
  }
};

// Reads some coordinates of both ends of the vertices with these ids; `visit`s each, and says what lies
// around.
template <class D, class Visit>
HWY_INLINE void ReadEnds(D d, std::size_t lane, std::span<const Index> ids, std::span<const double> x0,
                         std::span<const double> x1, Around& around, Visit visit) {
  const auto three = hn::FirstN(d, lane < 3 ? 3 - lane : 0);
  const auto read = [&](std::span<const double> x, Index id) {
    const std::size_t at = 3 * std::size_t{id};
    const double* from = &x[at];
    double last[4] = {0, 0, 0, 0};  // behind the last vertex there is nothing to be read
    if (at + 4 > x.size()) from = std::copy_n(from, 3, last) - 3;
    return hn::IfThenElseZero(three, hn::LoadU(d, from + lane));
  };
  auto lowest = hn::Set(d, std::numeric_limits<double>::infinity()), highest = hn::Neg(lowest);
  auto poison = hn::Zero(d);
  constexpr std::size_t kAhead = 16;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    if (i + kAhead < ids.size()) {
      __builtin_prefetch(&x0[3 * std::size_t{ids[i + kAhead]}]);
      __builtin_prefetch(&x1[3 * std::size_t{ids[i + kAhead]}]);
    }
    const auto p0 = read(x0, ids[i]), p1 = read(x1, ids[i]);
    lowest = hn::Min(lowest, hn::Min(p0, p1));
    highest = hn::Max(highest, hn::Max(p0, p1));
    poison = hn::Add(poison, hn::Add(hn::Mul(p0, hn::Zero(d)), hn::Mul(p1, hn::Zero(d))));
    visit(i, p0, p1);
  }
  hn::Store(lowest, d, around.low + lane);
  hn::Store(highest, d, around.high + lane);
  hn::Store(poison, d, around.poison + lane);
}

// Takes coordinates into the frame.
template <class D>
struct IntoFrame {
  D d;
  hn::Vec<D> middle, scale;
  HWY_INLINE IntoFrame(D tag, const Frame& frame, std::size_t lane) : d(tag) {
    alignas(32) const double center[4] = {frame.center.x(), frame.center.y(), frame.center.z(), 0};
    middle = hn::Load(d, center + lane);
    scale = hn::Set(d, frame.scale);
  }
  // B2: one rounding to nearest each; what leaves the range of floats stays beyond the frame
  // (tests/arithmetic: Rounding, Conversions.DoubleToFloat..., DoubleBeyondFloats...).
  HWY_INLINE auto operator()(hn::Vec<D> x) const {
    return hn::DemoteTo(hn::Rebind<float, D>(), hn::Mul(hn::Sub(x, middle), scale));
  }
};

// Both ends of the vertices with these ids into the frame, and what lies around them.
void Move(const Frame& frame, std::span<const Index> ids, std::span<const double> x0,
          std::span<const double> x1, MovingVertex* vertices, Bounds& bounds) {
  const hn::CappedTag<double, 4> d;
  const hn::Rebind<float, decltype(d)> df;
  Around around;
  for (std::size_t lane = 0; lane < 4; lane += hn::Lanes(d)) {
    const IntoFrame into(d, frame, lane);
    ReadEnds(d, lane, ids, x0, x1, around, [&](std::size_t i, auto p0, auto p1) HWY_ATTR {
      hn::Store(into(p0), df, vertices[i].x + lane);
      hn::Store(into(p1), df, vertices[i].x + 4 + lane);
    });
  }
  around.grow(bounds);
}

// The same for the motion that goes on for `steps` steps as in this one; `reach` is what lies around all.
void MoveAhead(const Frame& frame, std::span<const Index> ids, std::span<const double> x0,
               std::span<const double> x1, double steps, MovingVertex* vertices, Bounds& bounds,
               Bounds& reach) {
  const hn::CappedTag<double, 4> d;
  const hn::Rebind<float, decltype(d)> df;
  const auto more = hn::Set(d, steps - 1);
  Around around, last;
  for (std::size_t lane = 0; lane < 4; lane += hn::Lanes(d)) {
    const IntoFrame into(d, frame, lane);
    auto lowest = hn::Set(d, std::numeric_limits<double>::infinity()), highest = hn::Neg(lowest);
    ReadEnds(d, lane, ids, x0, x1, around, [&](std::size_t i, auto p0, auto p1) HWY_ATTR {
      const auto p = hn::Add(p1, hn::Mul(more, hn::Sub(p1, p0)));
      lowest = hn::Min(lowest, p);
      highest = hn::Max(highest, p);
      hn::Store(into(p0), df, vertices[i].x + lane);
      hn::Store(into(p), df, vertices[i].x + 4 + lane);
    });
    hn::Store(lowest, d, last.low + lane);
    hn::Store(highest, d, last.high + lane);
    hn::Store(hn::Zero(d), d, last.poison + lane);
  }
  around.grow(bounds);
  around.grow(reach);
  last.grow(reach);
}

// How far both ends lie from where their vertices are at two times of their motion: the most along any axis.
float Stray(const Frame& frame, std::span<const Index> ids, std::span<const double> x0,
            std::span<const double> x1, const MovingVertex* vertices, const float (&times)[2],
            Bounds& bounds) {
  const hn::CappedTag<double, 4> d;
  const hn::Rebind<float, decltype(d)> df;
  const auto begin = hn::Set(df, times[0]), end = hn::Set(df, times[1]);
  alignas(16) float farthest[4];
  Around around;
  for (std::size_t lane = 0; lane < 4; lane += hn::Lanes(d)) {
    const IntoFrame into(d, frame, lane);
    auto most = hn::Zero(df);
    ReadEnds(d, lane, ids, x0, x1, around, [&](std::size_t i, auto p0, auto p1) HWY_ATTR {
      const auto from = hn::Load(df, vertices[i].x + lane);
      const auto way = hn::Sub(hn::Load(df, vertices[i].x + 4 + lane), from);
      const auto off0 = hn::Sub(into(p0), hn::Add(from, hn::Mul(begin, way)));
      const auto off1 = hn::Sub(into(p1), hn::Add(from, hn::Mul(end, way)));
      most = hn::Max(most, hn::Max(hn::Abs(off0), hn::Abs(off1)));
    });
    hn::Store(most, df, farthest + lane);
  }
  around.grow(bounds);
  return std::max({farthest[0], farthest[1], farthest[2]});
}

// Children stand behind their parents: one sweep from the back closes a subtree.
void UniteInnerNodes(std::span<const Hierarchy::Node> nodes, Index first, Index count, KineticBox* boxes) {
  const hn::CappedTag<float, 16> d;
  for (std::size_t i = first + count; i-- > first;) {
    if (nodes[i].is_leaf()) continue;
    // All of a box's numbers, one after the other.
    const auto* a = reinterpret_cast<const float*>(&boxes[i + 1]);
    const auto* b = reinterpret_cast<const float*>(&boxes[nodes[i].right]);
    auto* both = reinterpret_cast<float*>(&boxes[i]);
    for (std::size_t lane = 0; lane < 16; lane += hn::Lanes(d)) {
      hn::Store(hn::Min(hn::Load(d, a + lane), hn::Load(d, b + lane)), d, both + lane);
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
HWY_EXPORT(MoveAhead);
HWY_EXPORT(Stray);
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

namespace {

constexpr std::size_t kVerticesOfTask = 4096;

}  // namespace

Bounds KineticTree::move(const Frame& frame, std::span<const double> x0, std::span<const double> x1) {
  const auto ids = hierarchy->vertex_ids();
  return parallel_reduce(
      IndexRange{0, ids.size()}, kVerticesOfTask, Bounds{},
      [&](IndexRange range, Bounds b) {
        HWY_DYNAMIC_DISPATCH(Move)
        (frame, ids.subspan(range.begin, range.size()), x0, x1, &vertices[range.begin], b);
        return b;
      },
      [](const Bounds& a, const Bounds& b) { return around(a, b); });
}

KineticTree::Ahead KineticTree::move_ahead(const Frame& frame, std::span<const double> x0,
                                           std::span<const double> x1, double steps) {
  const auto ids = hierarchy->vertex_ids();
  return parallel_reduce(
      IndexRange{0, ids.size()}, kVerticesOfTask, Ahead{},
      [&](IndexRange range, Ahead a) {
        HWY_DYNAMIC_DISPATCH(MoveAhead)
        (frame, ids.subspan(range.begin, range.size()), x0, x1, steps, &vertices[range.begin], a.step,
         a.reach);
        return a;
      },
      [](const Ahead& a, const Ahead& b) {
        return Ahead{around(a.step, b.step), around(a.reach, b.reach)};
      });
}

KineticTree::Strayed KineticTree::stray(const Frame& frame, std::span<const double> x0,
                                        std::span<const double> x1, const float (&times)[2]) const {
  const auto ids = hierarchy->vertex_ids();
  return parallel_reduce(
      IndexRange{0, ids.size()}, kVerticesOfTask, Strayed{},
      [&](IndexRange range, Strayed s) {
        s.most =
            std::max(s.most, HWY_DYNAMIC_DISPATCH(Stray)(frame, ids.subspan(range.begin, range.size()), x0,
                                                         x1, &vertices[range.begin], times, s.bounds));
        return s;
      },
      [](const Strayed& a, const Strayed& b) {
        return Strayed{around(a.bounds, b.bounds), std::max(a.most, b.most)};
      });
}

void KineticTree::fit() {
  const auto nodes = hierarchy->nodes();
  parallel_for(std::size_t{0}, subtrees_.size(), [&](std::size_t k) {
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
  constexpr double kMost = std::numeric_limits<double>::max();
  Frame frame;
  const Vec3 middle = low / 2 + high / 2;
  // The centre is rounded, hence a little room. |y| < 9/16 always: tests/arithmetic, Frame.
  const double half = (high / 2 - low / 2).maxCoeff();
  const double reach = std::min(half * (1 + 0x1p-50) + middle.cwiseAbs().maxCoeff() * 0x1p-51, kMost);
  frame.center = middle;
  if (!(reach > 0)) return frame;
  // Everything lies within a half of the middle, and that within a sixteenth of the centre.
  frame.scale = std::ldexp(1.0, -std::clamp(std::ilogb(reach) + 2, -1020, 1025));
  // Rounded, the middle of what is nearly as far out as numbers go could be infinite.
  for (double& c : frame.center)
    c = std::clamp(std::nearbyint(c * frame.scale * 8) / (frame.scale * 8), -kMost, kMost);
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
