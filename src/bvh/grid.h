/// Boxes of features, quantized to bytes on the grid of a leaf (docs/soundness.md, B4). Highway includes this
/// file once per instruction set.

#include "bvh/kinetic_bvh.h"

#if defined(FOLDPROOF_BVH_GRID_H) == defined(HWY_TARGET_TOGGLE)
#ifdef FOLDPROOF_BVH_GRID_H
#undef FOLDPROOF_BVH_GRID_H
#else
#define FOLDPROOF_BVH_GRID_H
#endif

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace foldproof::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// One box: lower corner, then upper corner, each at both ends of the step and laid out like MovingVertex.
struct alignas(16) ByteBox {
  std::uint8_t x[2][8];
};

/// Quantizes the box, enlarged by `margin`. B4 needs the cell to be a monotone function of the coordinate: it
/// is clamped to [0, 255] as a float, where both conversions are exact on the integer part. Converting first
/// is not monotone: Highway 1.0.3 converts 32768 to 0 on AVX2.
template <class Floats>
HWY_INLINE void Quantize(Floats lower, Floats upper, float margin, const LeafGrid& grid, std::size_t lane,
                         ByteBox& out) {
  const hn::DFromV<Floats> d;
  const hn::Rebind<std::int32_t, hn::DFromV<Floats>> di;
  const hn::Rebind<std::uint8_t, hn::DFromV<Floats>> d8;
  const auto cell = [&](Floats x) {
    const auto steps = hn::Mul(hn::Sub(x, hn::Load(d, grid.origin + lane)), hn::Load(d, grid.scale + lane));
    const auto clamped = hn::Min(hn::Max(steps, hn::Zero(d)), hn::Set(d, 255.0f));
    return hn::DemoteTo(d8, hn::ConvertTo(di, clamped));
  };
  const auto m = hn::Set(d, margin);
  hn::StoreU(cell(hn::Sub(lower, m)), d8, out.x[0] + lane);
  hn::StoreU(cell(hn::Add(upper, m)), d8, out.x[1] + lane);
}

/// The box of a feature with N vertices.
template <int N>
HWY_INLINE void QuantizeFeature(const MovingVertex* vertices, const IdBlock<N>& ids, int feature,
                                float margin, const LeafGrid& grid, ByteBox& out) {
  const hn::CappedTag<float, 8> d;
  for (std::size_t lane = 0; lane < 8; lane += hn::Lanes(d)) {
    auto lower = hn::Load(d, vertices[ids.v[0][feature]].x + lane), upper = lower;
    for (int k = 1; k < N; ++k) {
      const auto p = hn::Load(d, vertices[ids.v[k][feature]].x + lane);
      lower = hn::Min(lower, p);
      upper = hn::Max(upper, p);
    }
    Quantize(lower, upper, margin, grid, lane, out);
  }
}

/// The box of a node.
HWY_INLINE void QuantizeBox(const KineticBox& box, float margin, const LeafGrid& grid, ByteBox& out) {
  const hn::CappedTag<float, 4> d;
  for (std::size_t lane = 0; lane < 8; lane += hn::Lanes(d)) {
    const auto lower = hn::Load(d, box.x[lane / 4][0] + lane % 4);
    const auto upper = hn::Neg(hn::Load(d, box.x[lane / 4][1] + lane % 4));
    Quantize(lower, upper, margin, grid, lane, out);
  }
}

/// Bit k is set unless the box is separated from lane k of a block on the same grid.
HWY_INLINE std::uint32_t NearLanes(const ByteBox& one, const BoxBlock& block) {
  const hn::CappedTag<std::uint8_t, kBlock> d;
  std::uint32_t near = 0;
  for (std::size_t lane = 0; lane < kBlock; lane += hn::Lanes(d)) {
    auto separation = hn::Zero(d);
    for (int axis = 0; axis < 3; ++axis) {
      const auto above = [&](int end) {
        return hn::SaturatedSub(hn::Load(d, block.x[0][end][axis] + lane),
                                hn::Set(d, one.x[1][4 * end + axis]));
      };
      const auto below = [&](int end) {
        return hn::SaturatedSub(hn::Set(d, one.x[0][4 * end + axis]),
                                hn::Load(d, block.x[1][end][axis] + lane));
      };
      separation = hn::Or(separation, hn::Or(hn::Min(above(0), above(1)), hn::Min(below(0), below(1))));
    }
    std::uint8_t bits[8] = {};
    hn::StoreMaskBits(d, hn::Eq(separation, hn::Zero(d)), bits);
    std::uint32_t some = 0;  // byte by byte, as machines order bytes differently
    for (int byte = 0; byte < 4; ++byte) some |= std::uint32_t{bits[byte]} << (8 * byte);
    near |= some << lane;
  }
  return near;
}

}  // namespace foldproof::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
