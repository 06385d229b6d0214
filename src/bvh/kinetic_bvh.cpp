#include "bvh/kinetic_bvh.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/parallel.h"

#undef HWY_TARGET_INCLUDE  // Highway compiles this file once per instruction set
#define HWY_TARGET_INCLUDE "bvh/kinetic_bvh.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "bvh/grid.h"

HWY_BEFORE_NAMESPACE();
namespace foldproof::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// The box of the vertices with these ids, at least one. Minima are exact, whichever of two zeros they return
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

// Bounds as lanes.
struct alignas(32) BoundsLanes {
  double low[4], high[4], poison[4];  // poison: zero unless a coordinate is infinite or NaN

  void extend(Bounds& bounds) const {
    for (int axis = 0; axis < 3; ++axis) {
      bounds.low[axis] = std::min(bounds.low[axis], low[axis]);
      bounds.high[axis] = std::max(bounds.high[axis], high[axis]);
      bounds.finite &= poison[axis] == 0;
    }
  }
};

// Reads the vertices from axis `lane` on; calls `visit` for each and computes their bounds.
template <class D, class Visit>
HWY_INLINE void ReadEnds(D d, std::size_t lane, const VerticesAtEnds& given, BoundsLanes& bounds,
                         Visit visit) {
  const auto& [ids, x0, x1] = given;
  const auto three = hn::FirstN(d, lane < 3 ? 3 - lane : 0);
  const auto read = [&](std::span<const double> x, Index id) {
    const std::size_t at = 3 * std::size_t{id};
    const double* from = &x[at];
    double last[4] = {0, 0, 0, 0};  // four numbers cannot be read at the last vertex
    if (at + 4 > x.size()) from = std::copy_n(from, 3, last) - 3;
    return hn::IfThenElseZero(three, hn::LoadU(d, from + lane));
  };
  auto lowest = hn::Set(d, std::numeric_limits<double>::infinity()), highest = hn::Neg(lowest);
  auto poison = hn::Zero(d);
  constexpr std::size_t kPrefetchDistance = 16;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    if (i + kPrefetchDistance < ids.size()) {
      __builtin_prefetch(&x0[3 * std::size_t{ids[i + kPrefetchDistance]}]);
      __builtin_prefetch(&x1[3 * std::size_t{ids[i + kPrefetchDistance]}]);
    }
    const auto p0 = read(x0, ids[i]), p1 = read(x1, ids[i]);
    lowest = hn::Min(lowest, hn::Min(p0, p1));
    highest = hn::Max(highest, hn::Max(p0, p1));
    poison = hn::Add(poison, hn::Add(hn::Mul(p0, hn::Zero(d)), hn::Mul(p1, hn::Zero(d))));
    visit(i, p0, p1);
  }
  hn::Store(lowest, d, bounds.low + lane);
  hn::Store(highest, d, bounds.high + lane);
  hn::Store(poison, d, bounds.poison + lane);
}

// Transforms coordinates to the frame.
template <class D>
struct ToFrame {
  D d;
  hn::Vec<D> center, scale;
  HWY_INLINE ToFrame(D tag, const Frame& frame, std::size_t lane) : d(tag) {
    alignas(32) const double padded[4] = {frame.center.x(), frame.center.y(), frame.center.z(), 0};
    center = hn::Load(d, padded + lane);
    scale = hn::Set(d, frame.scale);
  }
  // B2: one rounding to nearest each; what leaves the range of floats stays beyond the frame
  // (tests/arithmetic: Rounding, Conversions.DoubleToFloat..., DoubleBeyondFloats...).
  HWY_INLINE auto operator()(hn::Vec<D> x) const {
    return hn::DemoteTo(hn::Rebind<float, D>(), hn::Mul(hn::Sub(x, center), scale));
  }
};

// Reads both ends of vertices to the frame; extends the bounds by them.
void SetPositions(const Frame& frame, const VerticesAtEnds& given, MovingVertex* vertices, Bounds& bounds) {
  const hn::CappedTag<double, 4> d;
  const hn::Rebind<float, decltype(d)> df;
  BoundsLanes read;
  for (std::size_t lane = 0; lane < 4; lane += hn::Lanes(d)) {
    const ToFrame to_frame(d, frame, lane);
    ReadEnds(d, lane, given, read, [&](std::size_t i, auto p0, auto p1) HWY_ATTR {
      hn::Store(to_frame(p0), df, vertices[i].x + lane);
      hn::Store(to_frame(p1), df, vertices[i].x + 4 + lane);
    });
  }
  read.extend(bounds);
}

// The same for a motion of `steps` steps that extrapolates this one.
void SetExtrapolatedPositions(const Frame& frame, const VerticesAtEnds& given, double steps,
                              MovingVertex* vertices, Bounds& first_step, Bounds& all_steps) {
  const hn::CappedTag<double, 4> d;
  const hn::Rebind<float, decltype(d)> df;
  const auto more = hn::Set(d, steps - 1);
  BoundsLanes read, last;
  for (std::size_t lane = 0; lane < 4; lane += hn::Lanes(d)) {
    const ToFrame to_frame(d, frame, lane);
    auto lowest = hn::Set(d, std::numeric_limits<double>::infinity()), highest = hn::Neg(lowest);
    ReadEnds(d, lane, given, read, [&](std::size_t i, auto p0, auto p1) HWY_ATTR {
      const auto p = hn::Add(p1, hn::Mul(more, hn::Sub(p1, p0)));
      lowest = hn::Min(lowest, p);
      highest = hn::Max(highest, p);
      hn::Store(to_frame(p0), df, vertices[i].x + lane);
      hn::Store(to_frame(p), df, vertices[i].x + 4 + lane);
    });
    hn::Store(lowest, d, last.low + lane);
    hn::Store(highest, d, last.high + lane);
    hn::Store(hn::Zero(d), d, last.poison + lane);
  }
  read.extend(first_step);
  read.extend(all_steps);
  last.extend(all_steps);
}

// The maximum distance, along any axis, of a step's ends from where the vertices are at two times of their
// motion.
float MaxDeviation(const Frame& frame, const VerticesAtEnds& given, const MovingVertex* vertices,
                   const float (&times)[2], Bounds& bounds) {
  const hn::CappedTag<double, 4> d;
  const hn::Rebind<float, decltype(d)> df;
  const auto time0 = hn::Set(df, times[0]), time1 = hn::Set(df, times[1]);
  alignas(16) float per_axis[4];
  BoundsLanes read;
  for (std::size_t lane = 0; lane < 4; lane += hn::Lanes(d)) {
    const ToFrame to_frame(d, frame, lane);
    auto max = hn::Zero(df);
    ReadEnds(d, lane, given, read, [&](std::size_t i, auto p0, auto p1) HWY_ATTR {
      const auto start = hn::Load(df, vertices[i].x + lane);
      const auto displacement = hn::Sub(hn::Load(df, vertices[i].x + 4 + lane), start);
      const auto deviation0 = hn::Sub(to_frame(p0), hn::Add(start, hn::Mul(time0, displacement)));
      const auto deviation1 = hn::Sub(to_frame(p1), hn::Add(start, hn::Mul(time1, displacement)));
      max = hn::Max(max, hn::Max(hn::Abs(deviation0), hn::Abs(deviation1)));
    });
    hn::Store(max, df, per_axis + lane);
  }
  read.extend(bounds);
  return std::max({per_axis[0], per_axis[1], per_axis[2]});
}

// Children follow their parents, so one backward sweep refits a subtree.
void RefitInnerNodes(std::span<const Hierarchy::Node> nodes, Index first, Index count, KineticBox* boxes) {
  const hn::CappedTag<float, 16> d;
  for (std::size_t i = first + count; i-- > first;) {
    if (nodes[i].is_leaf()) continue;
    const auto* a = reinterpret_cast<const float*>(&boxes[i + 1]);
    const auto* b = reinterpret_cast<const float*>(&boxes[nodes[i].right]);
    auto* both = reinterpret_cast<float*>(&boxes[i]);
    for (std::size_t lane = 0; lane < 16; lane += hn::Lanes(d)) {
      hn::Store(hn::Min(hn::Load(d, a + lane), hn::Load(d, b + lane)), d, both + lane);
    }
  }
}

// The leaf's own features lie in cells 1 to 254, so that others can lie outside.
void FitGrid(const KineticBox& box, LeafGrid& grid) {
  constexpr float kCells = 252, kMinSide = 0x1p-20f;
  for (int end = 0; end < 2; ++end) {
    for (int axis = 0; axis < 4; ++axis) {
      const float side = std::max(-box.x[end][1][axis] - box.x[end][0][axis], kMinSide);
      grid.origin[4 * end + axis] = box.x[end][0][axis] - side * (1.5f / kCells);
      grid.scale[4 * end + axis] = kCells / side;
    }
  }
}

// Array of boxes to array of coordinates.
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
        QuantizeFeature(vertices, features.ids[b], first + k, 0, grid, boxes[k]);
      Transpose(boxes, first, features.boxes[b]);
    }
  }
}

void FillLeafFeatures(KineticBvh& tree, LeafIndex leaf) {
  LeafGrid& grid = tree.grids[leaf];
  FitGrid(tree.boxes[tree.leaf_node(leaf)], grid);
  FillBlocks(tree.vertices.data(), grid, leaf, tree.vertex_blocks);
  FillBlocks(tree.vertices.data(), grid, leaf, tree.edge_blocks);
  FillBlocks(tree.vertices.data(), grid, leaf, tree.face_blocks);
}

}  // namespace foldproof::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace foldproof::internal {

HWY_EXPORT(FitLeaves);
HWY_EXPORT(RefitInnerNodes);
HWY_EXPORT(SetPositions);
HWY_EXPORT(SetExtrapolatedPositions);
HWY_EXPORT(MaxDeviation);
HWY_EXPORT(FillLeafFeatures);

namespace {

// Packs features [begin_of(leaf), begin_of(leaf + 1)) of every leaf into blocks.
template <int N, class BeginOf, class VerticesOf>
FeatureBlocks<N> pack_features(Index leaf_count, BeginOf begin_of, VerticesOf vertices_of) {
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

KineticBvh::KineticBvh(std::shared_ptr<const Hierarchy> tree)
    : hierarchy(std::move(tree)), subtrees_(*hierarchy, 256) {
  const Hierarchy& h = *hierarchy;
  const auto leaves = h.leaves();
  vertices.resize(h.vertex_ids().size());
  boxes.resize(h.nodes().size());
  grids.resize(h.leaf_count());
  vertex_blocks = pack_features<1>(
      h.leaf_count(), [&](Index leaf) { return leaves[leaf].vertices; },
      [](Index v) { return std::array<Index, 1>{v}; });
  edge_blocks = pack_features<2>(
      h.leaf_count(), [&](Index leaf) { return leaves[leaf].edges; }, [&](Index e) { return h.edges()[e]; });
  face_blocks = pack_features<3>(
      h.leaf_count(), [&](Index leaf) { return leaves[leaf].triangles; },
      [&](Index t) { return h.triangles()[t]; });
  find_leaves();
  has_thin_faces = std::ranges::any_of(
      h.topology().faces(), [](const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; });
}

void KineticBvh::find_leaves() {
  const Hierarchy& h = *hierarchy;
  auto lists = list_leaf_vertices(h);
  leaf_vertex_ids_ = std::move(lists.vertices);
  for (Index node = 0; node < h.nodes().size(); ++node) {
    if (!h.nodes()[node].is_leaf()) continue;
    const Index leaf = h.nodes()[node].leaf_begin, begin = lists.begin[leaf];
    leaves_.push_back(
        {std::span(leaf_vertex_ids_).subspan(begin, lists.begin[leaf + 1] - begin), NodeIndex(node)});
  }
}

namespace {

constexpr std::size_t kVerticesPerTask = 4096;

}  // namespace

Bounds KineticBvh::set_positions(const Frame& frame, std::span<const double> x0, std::span<const double> x1) {
  const auto ids = hierarchy->vertex_ids();
  return parallel_reduce(
      IndexRange{0, ids.size()}, kVerticesPerTask, Bounds{},
      [&](IndexRange range, Bounds b) {
        HWY_DYNAMIC_DISPATCH(SetPositions)
        (frame, {ids.subspan(range.begin, range.size()), x0, x1}, &vertices[range.begin], b);
        return b;
      },
      [](const Bounds& a, const Bounds& b) { return united(a, b); });
}

KineticBvh::ExtrapolatedBounds KineticBvh::set_extrapolated_positions(const Frame& frame,
                                                                      std::span<const double> x0,
                                                                      std::span<const double> x1,
                                                                      double steps) {
  const auto ids = hierarchy->vertex_ids();
  return parallel_reduce(
      IndexRange{0, ids.size()}, kVerticesPerTask, ExtrapolatedBounds{},
      [&](IndexRange range, ExtrapolatedBounds b) {
        HWY_DYNAMIC_DISPATCH(SetExtrapolatedPositions)
        (frame, {ids.subspan(range.begin, range.size()), x0, x1}, steps, &vertices[range.begin], b.first_step,
         b.all_steps);
        return b;
      },
      [](const ExtrapolatedBounds& a, const ExtrapolatedBounds& b) {
        return ExtrapolatedBounds{united(a.first_step, b.first_step), united(a.all_steps, b.all_steps)};
      });
}

KineticBvh::Deviation KineticBvh::deviation(const Frame& frame, std::span<const double> x0,
                                            std::span<const double> x1, const float (&times)[2]) const {
  const auto ids = hierarchy->vertex_ids();
  return parallel_reduce(
      IndexRange{0, ids.size()}, kVerticesPerTask, Deviation{},
      [&](IndexRange range, Deviation d) {
        d.max = std::max(
            d.max, HWY_DYNAMIC_DISPATCH(MaxDeviation)(frame, {ids.subspan(range.begin, range.size()), x0, x1},
                                                      &vertices[range.begin], times, d.bounds));
        return d;
      },
      [](const Deviation& a, const Deviation& b) {
        return Deviation{united(a.bounds, b.bounds), std::max(a.max, b.max)};
      });
}

void KineticBvh::refit_boxes() {
  const auto nodes = hierarchy->nodes();
  parallel_for(std::size_t{0}, subtrees_.roots.size(), [&](std::size_t k) {
    const Hierarchy::Node& root = nodes[subtrees_.roots[k]];
    const Index count = root.leaf_end - root.leaf_begin;
    HWY_DYNAMIC_DISPATCH(FitLeaves)
    (vertices.data(), std::span(leaves_).subspan(root.leaf_begin, count), boxes.data());
    HWY_DYNAMIC_DISPATCH(RefitInnerNodes)(nodes, subtrees_.roots[k], 2 * count - 1, boxes.data());
  });
  for (auto node = subtrees_.top.rbegin(); node != subtrees_.top.rend(); ++node)
    HWY_DYNAMIC_DISPATCH(RefitInnerNodes)(nodes, *node, 1, boxes.data());
}

void KineticBvh::set_vertex(const Frame& frame, Index vertex, const double* x0, const double* x1) {
  const Index only = 0;
  Bounds unused;
  HWY_DYNAMIC_DISPATCH(SetPositions)(frame, {{&only, 1}, {x0, 3}, {x1, 3}}, &vertices[vertex], unused);
}

void KineticBvh::refit_leaf(LeafIndex leaf) {
  HWY_DYNAMIC_DISPATCH(FitLeaves)(vertices.data(), std::span(leaves_).subspan(leaf, 1), boxes.data());
}

void KineticBvh::fill_features(LeafIndex leaf) { HWY_DYNAMIC_DISPATCH(FillLeafFeatures)(*this, leaf); }

LeafVertexLists list_leaf_vertices(const Hierarchy& h) {
  LeafVertexLists lists{{0}, {}};
  for (Index leaf = 0; leaf < h.leaf_count(); ++leaf) {
    const auto offset = static_cast<std::ptrdiff_t>(lists.begin.back());
    for (Index t = h.leaves()[leaf].triangles; t < h.leaves()[leaf + 1].triangles; ++t)
      lists.vertices.insert(lists.vertices.end(), h.triangles()[t].begin(), h.triangles()[t].end());
    std::sort(lists.vertices.begin() + offset, lists.vertices.end());
    lists.vertices.erase(std::unique(lists.vertices.begin() + offset, lists.vertices.end()),
                         lists.vertices.end());
    lists.begin.push_back(static_cast<Index>(lists.vertices.size()));
  }
  lists.vertices.shrink_to_fit();
  return lists;
}

// Divides before it subtracts, so that the largest doubles do not overflow.
Frame frame_around(const Vec3& low, const Vec3& high) {
  constexpr double kMax = std::numeric_limits<double>::max();
  Frame frame;
  const Vec3 middle = low / 2 + high / 2;
  // The radius is enlarged by the rounding of the middle. |y| < 9/16 always: tests/arithmetic, Frame.
  const double half = (high / 2 - low / 2).maxCoeff();
  const double radius = std::min(half * (1 + 0x1p-50) + middle.cwiseAbs().maxCoeff() * 0x1p-51, kMax);
  frame.center = middle;
  if (!(radius > 0)) return frame;
  // Everything lies within a half of the middle, which lies within a sixteenth of the center.
  frame.scale = std::ldexp(1.0, -std::clamp(std::ilogb(radius) + 2, -1020, 1025));
  // Near the largest doubles the rounded middle could be infinite.
  for (double& c : frame.center)
    c = std::clamp(std::nearbyint(c * frame.scale * 8) / (frame.scale * 8), -kMax, kMax);
  return frame;
}

Frame frame_around(std::span<const double> x) {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (std::size_t i = 0; i < x.size(); i += 3) {
    const Vec3 corner = Vec3::load(&x[i]);
    low = low.cwiseMin(corner);
    high = high.cwiseMax(corner);
  }
  return frame_around(low, high);
}

float separation_margin(const Frame& frame, double distance) {
  constexpr double kRounding = 0x1.1p-22;  // docs/soundness.md, B2
  const double margin = distance * frame.scale * (1 + 0x1p-50) + kRounding;
  // Never infinite: the infinite boxes of empty lanes must stay separated.
  if (!(margin < 0x1p127)) return std::numeric_limits<float>::max();
  return std::nextafter(static_cast<float>(margin), std::numeric_limits<float>::infinity());
}

}  // namespace foldproof::internal
#endif  // HWY_ONCE
