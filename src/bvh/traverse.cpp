#include "bvh/traverse.h"

#include <algorithm>

#undef HWY_TARGET_INCLUDE  // Highway compiles this file once per instruction set
#define HWY_TARGET_INCLUDE "bvh/traverse.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "bvh/grid.h"
#include "bvh/touch.h"

HWY_BEFORE_NAMESPACE();
namespace foldproof::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Theorem 1: one side of one axis separates the boxes at both ends of the step. B2: one rounding per gap, and
// comparisons that are false for NaN (tests/arithmetic: Rounding, Order).
HWY_INLINE bool Separated(const KineticBox& a, const KineticBox& b, float margin) {
  const hn::CappedTag<float, 4> d;
  const auto m = hn::Set(d, margin);
  bool separated = false;
  for (std::size_t lane = 0; lane < 4; lane += hn::Lanes(d)) {
    const auto load = [&](const KineticBox& box, int end, int side) {
      return hn::Load(d, box.x[end][side] + lane);
    };
    const auto above = hn::Min(hn::Add(load(b, 0, 0), load(a, 0, 1)), hn::Add(load(b, 1, 0), load(a, 1, 1)));
    const auto below = hn::Min(hn::Add(load(a, 0, 0), load(b, 0, 1)), hn::Add(load(a, 1, 0), load(b, 1, 1)));
    separated |= !hn::AllFalse(d, hn::Or(hn::Gt(above, m), hn::Gt(below, m)));
  }
  return separated;
}

// By boxes, or else by what the traversal has beside them.
HWY_INLINE bool SeparatedNodes(const Traversal& traversal, NodePair pair, const TraversalResult& out) {
  return Separated(traversal.a->boxes[pair.a], traversal.b->boxes[pair.b], traversal.margin) ||
         (out.certificate != nullptr && out.certificate->separates(pair));
}

void FindSubtreePairs(const Traversal& traversal, NodePair start, Index max_leaves,
                      std::vector<NodePair>& stack, TraversalResult& out) {
  const NodePairs nodes = traversal.nodes();
  stack.assign(1, start);
  traverse_pairs(nodes, stack, [&](NodePair pair) HWY_ATTR {
    if (out.filter != nullptr && !out.filter->visits(pair)) return false;
    ++out.node_tests;
    if (SeparatedNodes(traversal, pair, out)) return false;
    if (std::max(leaf_count(nodes.a[pair.a]), leaf_count(nodes.b[pair.b])) > max_leaves) return true;
    out.subtree_pairs.push_back(pair);
    return false;
  });
}

void Traverse(const Traversal& traversal, std::span<const NodePair> starts, std::vector<NodePair>& stack,
              TraversalResult& out) {
  const NodePairs nodes = traversal.nodes();
  const KineticBox *boxes_a = traversal.a->boxes.data(), *boxes_b = traversal.b->boxes.data();
  constexpr std::size_t kPrefetchDistance = 8;
  for (std::size_t i = 0; i < starts.size(); ++i) {
    if (i + kPrefetchDistance < starts.size()) {
      __builtin_prefetch(&boxes_a[starts[i + kPrefetchDistance].a]);
      __builtin_prefetch(&boxes_b[starts[i + kPrefetchDistance].b]);
    }
    stack.assign(1, starts[i]);
    traverse_pairs(nodes, stack, [&](NodePair pair) HWY_ATTR {
      if (out.filter != nullptr && !out.filter->visits(pair)) return false;
      ++out.node_tests;
      if (!nodes.is_self(pair) && SeparatedNodes(traversal, pair, out)) {
        if (out.front != nullptr) out.front->push_back(pair);
        return false;
      }
      if (!nodes.are_leaves(pair)) return true;
      out.leaf_pairs.push_back(nodes.leaves(pair));
      return false;
    });
  }
}

void TestLeaves(const Traversal& traversal, std::span<const LeafPair> leaves, std::uint8_t* separated) {
  const KineticBvh &a = *traversal.a, &b = *traversal.b;
  for (const LeafPair pair : leaves)
    *separated++ = Separated(a.boxes[a.leaf_node(pair.a)], b.boxes[b.leaf_node(pair.b)], traversal.margin);
}

// Bit k is set when lane k has one of the feature's vertices (tests/arithmetic, Masks). Lanes that are not in
// `lanes` may be wrong.
template <int NA, int NB>
HWY_INLINE std::uint32_t IncidentLanes(const IdBlock<NA>& a, int lane_a, const IdBlock<NB>& b,
                                       std::uint32_t lanes) {
  const hn::CappedTag<std::uint32_t, 8> d;
  std::uint32_t incident = 0;
  for (std::size_t lane = 0; lane < kBlock && lanes >> lane != 0; lane += hn::Lanes(d)) {
    auto same = hn::Eq(hn::Set(d, a.v[0][lane_a]), hn::Load(d, b.v[0] + lane));
    for (int i = 0; i < NA; ++i) {
      const auto id = hn::Set(d, a.v[i][lane_a]);
      for (int k = 0; k < NB; ++k) same = hn::Or(same, hn::Eq(id, hn::Load(d, b.v[k] + lane)));
    }
    std::uint8_t bits[8] = {};
    hn::StoreMaskBits(d, same, bits);
    incident |= std::uint32_t{bits[0]} << lane;
  }
  return incident;
}

// Both are sorted.
HWY_INLINE bool ShareVertex(std::span<const Index> a, std::span<const Index> b) {
  if (a.back() < b.front() || b.back() < a.front()) return false;
  std::size_t i = 0, k = 0;
  while (i < a.size() && k < b.size()) {
    if (a[i] == b[k]) return true;
    const bool less = a[i] < b[k];
    i += less;
    k += !less;
  }
  return false;
}

// No distance in the frame exceeds 2, so a larger margin would only make the grid's numbers large.
HWY_INLINE float ClampedMargin(const Traversal& traversal) { return std::min(traversal.margin, 4.0f); }

// A leaf of a pair, with what all tests of its features share.
struct LeafSide {
  const KineticBvh& bvh;
  Index leaf;
  ByteBox other;  // the box of the other leaf, on this one's grid

  HWY_INLINE LeafSide(const KineticBvh& own_bvh, Index own_leaf, const KineticBox& other_box, float margin)
      : bvh(own_bvh), leaf(own_leaf) {
    QuantizeBox(other_box, margin, grid(), other);
  }
  const LeafGrid& grid() const { return bvh.grids[leaf]; }
};

struct LeafTest {
  float margin;
  bool drop_incident;  // leave out pairs with a common vertex
  bool halve;          // a set with itself: each unordered pair once
};

// Appends the pairs of feature a with the lanes of `near`, at least one. There are usually few, so two are
// written at a time without a branch; the last one may be surplus.
HWY_INLINE void Append(Index a, Index first_b, std::uint32_t near, std::vector<CandidatePair>& out) {
  const std::size_t at = out.size(), count = __builtin_popcount(near);
  out.resize(at + count + 2);
  CandidatePair* next = &out[at];
  do {
    for (int k = 0; k < 2; ++k, near &= near - 1)
      *next++ = {FeatureIndex(a), FeatureIndex(first_b + static_cast<Index>(__builtin_ctz(near | 1u << 31)))};
  } while (near != 0);
  out.resize(at + count);
}

// Tests the features of leaf a against those of leaf b, block by block. All masks are computed before any is
// read, so that no computation waits for a mispredicted branch.
template <int NA, int NB>
HWY_INLINE void TestFeatures(const LeafSide& a, const FeatureBlocks<NA>& fa, const LeafSide& b,
                             const FeatureBlocks<NB>& fb, const LeafTest& test,
                             std::vector<CandidatePair>& out) {
  const auto test_blocks = [&](Index ia, Index ib) {
    ByteBox boxes[kBlock];
    std::uint8_t lanes[kBlock];
    int count = 0;
    for (std::uint32_t left = NearLanes(a.other, fa.boxes[ia]) & fa.used[ia]; left != 0; left &= left - 1) {
      const int lane = __builtin_ctz(left);
      QuantizeFeature(a.bvh.vertices.data(), fa.ids[ia], lane, test.margin, b.grid(), boxes[count]);
      lanes[count++] = static_cast<std::uint8_t>(lane);
    }
    std::uint32_t near[kBlock];
    for (int i = 0; i < count; ++i) near[i] = NearLanes(boxes[i], fb.boxes[ib]) & fb.used[ib];
    if (test.halve && ia == ib) {
      for (int i = 0; i < count; ++i) near[i] &= ~((2u << lanes[i]) - 1);
    }
    for (int i = 0; i < count; ++i) {
      if (near[i] == 0) continue;
      if (test.drop_incident) near[i] &= ~IncidentLanes(fa.ids[ia], lanes[i], fb.ids[ib], near[i]);
      if (near[i] != 0) Append(fa.first[ia] + lanes[i], fb.first[ib], near[i], out);
    }
  };
  for (Index ia = fa.begin[a.leaf]; ia < fa.begin[a.leaf + 1]; ++ia) {
    for (Index ib = test.halve ? ia : fb.begin[b.leaf]; ib < fb.begin[b.leaf + 1]; ++ib) test_blocks(ia, ib);
  }
}

// Two points come as each other's vertex and triangle. Of one object the vertex with the smaller id is taken,
// of two the first object's, whatever the hierarchy.
void FindPointPairs(const LeafSide& a, const LeafSide& b, const LeafTest& test,
                    std::vector<CandidatePair>& out) {
  const std::size_t begin = out.size();
  TestFeatures(a, a.bvh.vertex_blocks, b, b.bvh.face_blocks, test, out);
  if (&a.bvh != &b.bvh) return;
  if (a.leaf != b.leaf) TestFeatures(b, b.bvh.vertex_blocks, a, a.bvh.face_blocks, test, out);
  const Hierarchy& h = *a.bvh.hierarchy;
  const auto comes_twice = [&](const CandidatePair& pair) {
    return h.vertex_ids()[h.triangles()[pair.b][0]] < h.vertex_ids()[pair.a];
  };
  out.erase(std::remove_if(out.begin() + static_cast<std::ptrdiff_t>(begin), out.end(), comes_twice),
            out.end());
}

// The box of a feature, laid out like MovingVertex.
struct alignas(32) MovingBox {
  float lower[8], upper[8];
};

template <std::size_t N>
HWY_INLINE MovingBox BoxOf(const MovingVertex* vertices, const std::array<Index, N>& feature) {
  const hn::CappedTag<float, 8> d;
  MovingBox box;
  for (std::size_t lane = 0; lane < 8; lane += hn::Lanes(d)) {
    auto lower = hn::Load(d, vertices[feature[0]].x + lane), upper = lower;
    for (std::size_t k = 1; k < N; ++k) {
      const auto p = hn::Load(d, vertices[feature[k]].x + lane);
      lower = hn::Min(lower, p);
      upper = hn::Max(upper, p);
    }
    hn::Store(lower, d, box.lower + lane);
    hn::Store(upper, d, box.upper + lane);
  }
  return box;
}

// The corners of the difference of two features.
template <std::size_t NA, std::size_t NB>
HWY_INLINE void SetCorners(const MovingVertex* va, const std::array<Index, NA>& a, const MovingVertex* vb,
                           const std::array<Index, NB>& b, Ends (&corners)[NA * NB]) {
  for (std::size_t k = 0; k < NB; ++k) {
    const Ends of_b = Ends::Load(vb[b[k]]);
    for (std::size_t i = 0; i < NA; ++i) corners[NA * k + i] = Ends::Load(va[a[i]]) - of_b;
  }
}

// Keeps those of the pairs from `begin` on for which `drops` is false. There are many, and which ones is not
// predictable, so each is written.
template <class Drops>
HWY_INLINE void DropIf(std::vector<CandidatePair>& pairs, std::size_t begin, Drops drops) {
  std::size_t kept = begin;
  for (std::size_t i = begin; i < pairs.size(); ++i) {
    const CandidatePair pair = pairs[i];
    pairs[kept] = pair;
    kept += !drops(pair);
  }
  pairs.resize(kept);
}

// Drops those of the pairs from `begin` on that cannot come within the margin. corners(pair, d) sets the N
// corners of a pair.
template <int N, class Corners>
HWY_INLINE void DropFar(Corners corners, float margin, std::size_t begin, std::vector<CandidatePair>& pairs) {
  DropIf(pairs, begin, [&](const CandidatePair& pair) HWY_ATTR {
    Ends d[N];
    corners(pair, d);
    return ApartAlongDiagonals(d, margin);
  });
  DropIf(pairs, begin, [&](const CandidatePair& pair) HWY_ATTR {
    Ends d[N];
    corners(pair, d);
    return NeverCoplanar(d[0], d[1], d[2], margin);
  });
}

void FindCandidates(const Traversal& traversal, LeafPair leaves, CandidateBuffer& out) {
  const KineticBvh &ta = *traversal.a, &tb = *traversal.b;
  const float margin = ClampedMargin(traversal);
  const LeafSide a(ta, leaves.a, tb.boxes[tb.leaf_node(leaves.b)], margin);
  const LeafSide b(tb, leaves.b, ta.boxes[ta.leaf_node(leaves.a)], margin);
  const bool same_object = &ta == &tb, same_leaf = same_object && leaves.a == leaves.b;
  const bool incident = same_object && ShareVertex(ta.leaf_vertices(leaves.a), tb.leaf_vertices(leaves.b));
  const LeafTest test{margin, incident, false}, edge_test{margin, incident, same_leaf};
  const Element of_a = ta.hierarchy->element(leaves.a), of_b = tb.hierarchy->element(leaves.b);
  const auto tests = [](const KineticBvh& vertices, Element of_vertices, Element of_triangles) {
    return tests_vertices(of_vertices, of_triangles) ||
           (vertices.has_thin_faces && of_vertices == Element::Face && of_triangles == Element::Line);
  };
  if (of_a == Element::Point && of_b == Element::Point)
    return FindPointPairs(a, b, test, out[FeaturePair::VertexFace]);
  const auto test_edges = [&](std::vector<CandidatePair>& pairs) HWY_ATTR {
    const std::size_t begin = pairs.size();
    TestFeatures(a, ta.edge_blocks, b, tb.edge_blocks, edge_test, pairs);
    const auto edges_a = ta.hierarchy->edges(), edges_b = tb.hierarchy->edges();
    const auto corners = [&](const CandidatePair& pair, Ends(&d)[4]) HWY_ATTR {
      SetCorners(ta.vertices.data(), edges_a[pair.a], tb.vertices.data(), edges_b[pair.b], d);
    };
    DropFar<4>(corners, margin, begin, pairs);
  };
  const auto test_faces = [&](const LeafSide& v, const LeafSide& f, std::vector<CandidatePair>& pairs)
                              HWY_ATTR {
                                const std::size_t begin = pairs.size();
                                TestFeatures(v, v.bvh.vertex_blocks, f, f.bvh.face_blocks, test, pairs);
                                const auto faces = f.bvh.hierarchy->triangles();
                                const auto corners = [&](const CandidatePair& pair, Ends(&d)[3]) HWY_ATTR {
                                  SetCorners(v.bvh.vertices.data(), std::array<Index, 1>{pair.a},
                                             f.bvh.vertices.data(), faces[pair.b], d);
                                };
                                DropFar<3>(corners, margin, begin, pairs);
                              };
  if (tests(ta, of_a, of_b)) test_faces(a, b, out[FeaturePair::VertexFace]);
  test_edges(out[FeaturePair::EdgeEdge]);
  if (same_leaf || !tests(tb, of_b, of_a)) return;
  auto& other = out[same_object ? FeaturePair::VertexFace : FeaturePair::FaceVertex];
  const std::size_t begin = other.size();
  test_faces(b, a, other);
  if (same_object) return;
  for (std::size_t i = begin; i < other.size(); ++i) std::swap(other[i].a, other[i].b);
}

void FindFacePairs(const Traversal& traversal, LeafPair leaves, std::vector<CandidatePair>& out) {
  const KineticBvh &ta = *traversal.a, &tb = *traversal.b;
  const float margin = ClampedMargin(traversal);
  const LeafSide a(ta, leaves.a, tb.boxes[tb.leaf_node(leaves.b)], margin);
  const LeafSide b(tb, leaves.b, ta.boxes[ta.leaf_node(leaves.a)], margin);
  const LeafTest test{margin, false, &ta == &tb && leaves.a == leaves.b};
  TestFeatures(a, ta.face_blocks, b, tb.face_blocks, test, out);
}

// On each side of each axis the gap between the boxes changes linearly from `first` to `last`; they are
// separated while one gap is positive.
HWY_INLINE ContactInterval IntervalOf(const MovingBox& a, const MovingBox& b, float margin) {
  const hn::CappedTag<float, 4> d;
  const auto m = hn::Set(d, margin), zero = hn::Zero(d), one = hn::Set(d, 1);
  alignas(16) float begin[4] = {0, 0, 0, 0}, end[4] = {1, 1, 1, 1};
  bool always_separated = false;
  for (std::size_t lane = 0; lane < 4; lane += hn::Lanes(d)) {
    auto from = zero, to = one;
    for (int side = 0; side < 2; ++side) {
      const float *above = side == 0 ? a.lower : b.lower, *below = side == 0 ? b.upper : a.upper;
      const auto first = hn::Sub(hn::Sub(hn::Load(d, above + lane), hn::Load(d, below + lane)), m);
      const auto last = hn::Sub(hn::Sub(hn::Load(d, above + 4 + lane), hn::Load(d, below + 4 + lane)), m);
      const auto separated_first = hn::Gt(first, zero), separated_last = hn::Gt(last, zero);
      const auto root = hn::Div(first, hn::Sub(first, last));
      always_separated |= !hn::AllFalse(d, hn::And(separated_first, separated_last));
      from = hn::Max(from, hn::IfThenElseZero(separated_first, root));
      to = hn::Min(to, hn::IfThenElse(separated_last, root, one));
    }
    hn::Store(from, d, begin + lane);
    hn::Store(to, d, end + lane);
  }
  const float from = std::max({begin[0], begin[1], begin[2]}), to = std::min({end[0], end[1], end[2]});
  // Covers the rounding of the quotients, as does the unit that is added at both ends.
  constexpr float kRounding = 0x1p-20;
  if (always_separated || from > to + kRounding) return ContactInterval::none();
  constexpr float kUnits = ContactInterval::kUnits;
  return {static_cast<std::uint8_t>(std::max(0.f, from * kUnits - 1)),
          static_cast<std::uint8_t>(std::min(to * kUnits + 2, kUnits))};
}

void FindContactIntervals(const Traversal& traversal, FeaturePair kind, std::span<const CandidatePair> pairs,
                          ContactInterval* out) {
  const Hierarchy &ha = *traversal.a->hierarchy, &hb = *traversal.b->hierarchy;
  const MovingVertex *va = traversal.a->vertices.data(), *vb = traversal.b->vertices.data();
  const float margin = ClampedMargin(traversal);
  for (const auto [a, b] : pairs) {
    const auto add = [&](const auto& feature_a, const auto& feature_b) {
      *out++ = IntervalOf(BoxOf(va, feature_a), BoxOf(vb, feature_b), margin);
    };
    if (kind == FeaturePair::EdgeEdge) {
      add(ha.edges()[a], hb.edges()[b]);
    } else if (kind == FeaturePair::VertexFace) {
      add(std::array<Index, 1>{a}, hb.triangles()[b]);
    } else {
      add(ha.triangles()[a], std::array<Index, 1>{b});
    }
  }
}

}  // namespace foldproof::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace foldproof::internal {

namespace {

constexpr std::size_t kCacheLine = 64;

template <class T>
void prefetch(const T* first, std::size_t count) {
  const char* bytes = reinterpret_cast<const char*>(first);
  for (std::size_t i = 0; i < count * sizeof(T); i += kCacheLine) __builtin_prefetch(bytes + i);
}

template <int N>
void prefetch_blocks(const FeatureBlocks<N>& features, Index leaf) {
  const Index begin = features.begin[leaf];  // past the last block where the last leaves have none
  prefetch(features.boxes.data() + begin, 1);
  prefetch(features.ids.data() + begin, 1);
  __builtin_prefetch(features.used.data() + begin);
  __builtin_prefetch(features.first.data() + begin);
}

void prefetch_leaf(const KineticBvh& bvh, LeafIndex leaf) {
  prefetch_blocks(bvh.vertex_blocks, leaf);
  prefetch_blocks(bvh.edge_blocks, leaf);
  prefetch_blocks(bvh.face_blocks, leaf);
  prefetch(&bvh.grids[leaf], 1);
  prefetch(&bvh.boxes[bvh.leaf_node(leaf)], 1);
  prefetch(bvh.vertices.data() + bvh.hierarchy->leaves()[leaf].vertices, 8);
}

}  // namespace

HWY_EXPORT(FindSubtreePairs);
HWY_EXPORT(Traverse);
HWY_EXPORT(TestLeaves);
HWY_EXPORT(FindCandidates);
HWY_EXPORT(FindFacePairs);
HWY_EXPORT(FindContactIntervals);

void find_subtree_pairs(const Traversal& traversal, NodePair start, Index max_leaves,
                        std::vector<NodePair>& stack, TraversalResult& out) {
  HWY_DYNAMIC_DISPATCH(FindSubtreePairs)(traversal, start, max_leaves, stack, out);
}

void traverse(const Traversal& traversal, std::span<const NodePair> starts, std::vector<NodePair>& stack,
              TraversalResult& out) {
  HWY_DYNAMIC_DISPATCH(Traverse)(traversal, starts, stack, out);
}

void test_leaf_boxes(const Traversal& traversal, std::span<const LeafPair> leaves,
                     std::vector<std::uint8_t>& separated) {
  separated.resize(leaves.size());
  HWY_DYNAMIC_DISPATCH(TestLeaves)(traversal, leaves, separated.data());
}

void find_candidates(const Traversal& traversal, LeafPair leaves, CandidateBuffer& out) {
  HWY_DYNAMIC_DISPATCH(FindCandidates)(traversal, leaves, out);
}

void find_contact_intervals(const Traversal& traversal, FeaturePair kind,
                            std::span<const CandidatePair> pairs, ContactInterval* out) {
  HWY_DYNAMIC_DISPATCH(FindContactIntervals)(traversal, kind, pairs, out);
}

void prefetch_features(const Traversal& traversal, LeafPair leaves) {
  prefetch_leaf(*traversal.a, leaves.a);
  if (traversal.a != traversal.b || leaves.a != leaves.b) prefetch_leaf(*traversal.b, leaves.b);
}

void find_face_pairs(const Traversal& traversal, LeafPair leaves, std::vector<CandidatePair>& out) {
  HWY_DYNAMIC_DISPATCH(FindFacePairs)(traversal, leaves, out);
}

}  // namespace foldproof::internal
#endif  // HWY_ONCE
