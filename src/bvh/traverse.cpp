#include "bvh/traverse.h"

#include <limits>

#undef HWY_TARGET_INCLUDE  // Highway compiles this file once per instruction set
#define HWY_TARGET_INCLUDE "bvh/traverse.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace foldproof::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Theorem 1: one side of one axis separates the boxes at both ends of the step.
HWY_INLINE bool Apart(const KineticBox& a, const KineticBox& b, float margin) {
  const hn::CappedTag<float, 4> d;
  const auto m = hn::Set(d, margin);
  bool apart = false;
  for (std::size_t lane = 0; lane < 4; lane += hn::Lanes(d)) {
    const auto load = [&](const KineticBox& box, int end, int side) {
      return hn::Load(d, box.x[end][side] + lane);
    };
    const auto above = hn::Min(hn::Add(load(b, 0, 0), load(a, 0, 1)), hn::Add(load(b, 1, 0), load(a, 1, 1)));
    const auto below = hn::Min(hn::Add(load(a, 0, 0), load(b, 0, 1)), hn::Add(load(a, 1, 0), load(b, 1, 1)));
    apart |= !hn::AllFalse(d, hn::Or(hn::Gt(above, m), hn::Gt(below, m)));
  }
  return apart;
}

// Visits one pair: emits it, or pushes what lies below it.
HWY_INLINE void Visit(const Traversal& traversal, NodePair pair, std::vector<NodePair>& below,
                      TraversalResult& out) {
  const auto nodes_a = traversal.a->hierarchy->nodes(), nodes_b = traversal.b->hierarchy->nodes();
  const Hierarchy::Node &a = nodes_a[pair.a], &b = nodes_b[pair.b];
  ++out.node_tests;
  if (traversal.a == traversal.b && pair.a == pair.b) {
    if (a.is_leaf()) {
      out.leaf_pairs.push_back({a.leaf_begin, a.leaf_begin});
    } else {
      push_below_self(nodes_a, pair.a, below);
    }
    return;
  }
  if (Apart(traversal.a->boxes[pair.a], traversal.b->boxes[pair.b], traversal.margin)) {
    if (out.front != nullptr) out.front->push_back(pair);
    return;
  }
  if (a.is_leaf() && b.is_leaf()) {
    if (out.front != nullptr) out.front->push_back(pair);
    out.leaf_pairs.push_back({a.leaf_begin, b.leaf_begin});
  } else {
    push_below(nodes_a, nodes_b, pair, below);
  }
}

void DescendOnce(const Traversal& traversal, std::vector<NodePair>& front, std::vector<NodePair>& scratch,
                 TraversalResult& out) {
  scratch.clear();
  for (const NodePair pair : front) Visit(traversal, pair, scratch, out);
  front.swap(scratch);
}

void Traverse(const Traversal& traversal, NodePair start, std::vector<NodePair>& stack,
              TraversalResult& out) {
  stack.assign(1, start);
  while (!stack.empty()) {
    const NodePair pair = stack.back();
    stack.pop_back();
    Visit(traversal, pair, stack, out);
  }
}

// One feature's box against eight: bit k is set unless lane k is apart.
HWY_INLINE unsigned NearLanes(const float (&one)[12], const BoxBlock& block, float margin) {
  const hn::CappedTag<float, 8> d;
  const auto m = hn::Set(d, margin);
  unsigned near = 0;
  for (std::size_t lane = 0; lane < 8; lane += hn::Lanes(d)) {
    auto gap = hn::Set(d, -std::numeric_limits<float>::infinity());
    for (int axis = 0; axis < 3; ++axis) {
      const auto above0 = hn::Add(hn::Load(d, block.x[0][0][axis] + lane), hn::Set(d, one[3 + axis]));
      const auto above1 = hn::Add(hn::Load(d, block.x[1][0][axis] + lane), hn::Set(d, one[9 + axis]));
      const auto below0 = hn::Add(hn::Load(d, block.x[0][1][axis] + lane), hn::Set(d, one[axis]));
      const auto below1 = hn::Add(hn::Load(d, block.x[1][1][axis] + lane), hn::Set(d, one[6 + axis]));
      gap = hn::Max(gap, hn::Max(hn::Min(above0, above1), hn::Min(below0, below1)));
    }
    std::uint8_t bits[8] = {};
    hn::StoreMaskBits(d, hn::Not(hn::Gt(gap, m)), bits);
    near |= static_cast<unsigned>(bits[0]) << lane;
  }
  return near;
}

// Bit k is set when lane k names one of the feature's vertices.
template <int NA, int NB>
HWY_INLINE unsigned IncidentLanes(const IdBlock<NA>& a, int lane_a, const IdBlock<NB>& b) {
  const hn::CappedTag<std::uint32_t, 8> d;
  unsigned incident = 0;
  for (std::size_t lane = 0; lane < 8; lane += hn::Lanes(d)) {
    auto same = hn::Eq(hn::Set(d, a.v[0][lane_a]), hn::Load(d, b.v[0] + lane));
    for (int i = 0; i < NA; ++i) {
      const auto id = hn::Set(d, a.v[i][lane_a]);
      for (int k = 0; k < NB; ++k) same = hn::Or(same, hn::Eq(id, hn::Load(d, b.v[k] + lane)));
    }
    std::uint8_t bits[8] = {};
    hn::StoreMaskBits(d, same, bits);
    incident |= static_cast<unsigned>(bits[0]) << lane;
  }
  return incident;
}

struct LeafTest {
  float margin;
  bool drop_incident;  // leave out pairs with a common vertex
  bool halve;          // one set with itself: each unordered pair once
};

HWY_INLINE void CopyBox(const KineticBox& box, float (&one)[12]) {
  for (int k = 0; k < 12; ++k) one[k] = (&box.x[0][0][0])[k / 3 * 4 + k % 3];
}

HWY_INLINE void CopyLane(const BoxBlock& block, int lane, float (&one)[12]) {
  for (int k = 0; k < 12; ++k) one[k] = (&block.x[0][0][0][0])[8 * k + lane];
}

// All pairs of a feature of leaf `leaf_a` and one of leaf `leaf_b`; `box_b` holds the whole of leaf b.
template <int NA, int NB>
HWY_INLINE void TestFeatures(const FeatureBlocks<NA>& fa, Index leaf_a, const FeatureBlocks<NB>& fb,
                             Index leaf_b, const KineticBox& box_b, const LeafTest& test,
                             std::vector<CandidateBuffer::Pair>& out) {
  float one[12];
  for (Index ia = fa.begin[leaf_a]; ia < fa.begin[leaf_a + 1]; ++ia) {
    CopyBox(box_b, one);
    unsigned lanes = NearLanes(one, fa.boxes[ia], test.margin);
    for (; lanes != 0; lanes &= lanes - 1) {
      const int lane_a = __builtin_ctz(lanes);
      const Index feature_a = fa.first[ia] + static_cast<Index>(lane_a);
      CopyLane(fa.boxes[ia], lane_a, one);
      for (Index ib = test.halve ? ia : fb.begin[leaf_b]; ib < fb.begin[leaf_b + 1]; ++ib) {
        unsigned near = NearLanes(one, fb.boxes[ib], test.margin);
        if (test.halve && ib == ia) near &= ~((2u << lane_a) - 1);
        if (near != 0 && test.drop_incident) near &= ~IncidentLanes(fa.ids[ia], lane_a, fb.ids[ib]);
        for (; near != 0; near &= near - 1) {
          out.push_back({feature_a, fb.first[ib] + static_cast<Index>(__builtin_ctz(near))});
        }
      }
    }
  }
}

void FindCandidates(const Traversal& traversal, NodePair leaves, CandidateBuffer& out) {
  const KineticTree &a = *traversal.a, &b = *traversal.b;
  const KineticBox &box_a = a.boxes[a.leaf_node(leaves.a)], &box_b = b.boxes[b.leaf_node(leaves.b)];
  const bool same_object = &a == &b, same_leaf = same_object && leaves.a == leaves.b;
  const LeafTest test{traversal.margin, same_object, false},
      edge_test{traversal.margin, same_object, same_leaf};
  TestFeatures(a.vertex_blocks, leaves.a, b.face_blocks, leaves.b, box_b, test, out.vertex_face);
  TestFeatures(a.edge_blocks, leaves.a, b.edge_blocks, leaves.b, box_b, edge_test, out.edge_edge);
  if (same_leaf) return;
  auto& other = same_object ? out.vertex_face : out.face_vertex;
  const std::size_t begin = other.size();
  TestFeatures(b.vertex_blocks, leaves.b, a.face_blocks, leaves.a, box_a, test, other);
  if (same_object) return;
  for (std::size_t i = begin; i < other.size(); ++i) std::swap(other[i].a, other[i].b);
}

void FindFacePairs(const Traversal& traversal, NodePair leaves, CandidateBuffer& out) {
  const KineticTree &a = *traversal.a, &b = *traversal.b;
  const LeafTest test{traversal.margin, false, &a == &b && leaves.a == leaves.b};
  TestFeatures(a.face_blocks, leaves.a, b.face_blocks, leaves.b, b.boxes[b.leaf_node(leaves.b)], test,
               out.face_face);
}

}  // namespace foldproof::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace foldproof {

HWY_EXPORT(DescendOnce);
HWY_EXPORT(Traverse);
HWY_EXPORT(FindCandidates);
HWY_EXPORT(FindFacePairs);

void descend_once(const Traversal& traversal, std::vector<NodePair>& front, std::vector<NodePair>& scratch,
                  TraversalResult& out) {
  HWY_DYNAMIC_DISPATCH(DescendOnce)(traversal, front, scratch, out);
}

void traverse(const Traversal& traversal, NodePair start, std::vector<NodePair>& stack,
              TraversalResult& out) {
  HWY_DYNAMIC_DISPATCH(Traverse)(traversal, start, stack, out);
}

void find_candidates(const Traversal& traversal, NodePair leaves, CandidateBuffer& out) {
  HWY_DYNAMIC_DISPATCH(FindCandidates)(traversal, leaves, out);
}

void find_face_pairs(const Traversal& traversal, NodePair leaves, CandidateBuffer& out) {
  HWY_DYNAMIC_DISPATCH(FindFacePairs)(traversal, leaves, out);
}

}  // namespace foldproof
#endif  // HWY_ONCE
