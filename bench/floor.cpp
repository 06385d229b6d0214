#include "floor.h"

#include <algorithm>

#undef HWY_TARGET_INCLUDE  // Highway compiles this file once per instruction set
#define HWY_TARGET_INCLUDE "floor.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace foldproof::bench::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Reads four numbers of each vertex, so behind each must be a next one.
void GatherPoints(const double* x, std::span<const Index> ids, float* points) {
  const hn::CappedTag<double, 4> d;
  const hn::Rebind<float, decltype(d)> df;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    for (std::size_t lane = 0; lane < 4; lane += hn::Lanes(d))
      hn::StoreU(hn::DemoteTo(df, hn::LoadU(d, x + std::size_t{3} * ids[i] + lane)), df,
                 points + 4 * i + lane);
  }
}

void FitLeaf(const float* points, std::span<const Index> places, float* box) {
  const hn::CappedTag<float, 4> d;
  for (std::size_t lane = 0; lane < 4; lane += hn::Lanes(d)) {
    auto lower = hn::Load(d, points + std::size_t{4} * places[0] + lane), upper = lower;
    for (const Index place : places.subspan(1)) {
      const auto p = hn::Load(d, points + std::size_t{4} * place + lane);
      lower = hn::Min(lower, p);
      upper = hn::Max(upper, p);
    }
    hn::Store(lower, d, box + lane);
    hn::Store(hn::Neg(upper), d, box + 4 + lane);
  }
}

// Children stand behind their parents. `boxes`: eight floats per node.
void FitInnerNodes(std::span<const Index> right, float* boxes) {
  const hn::CappedTag<float, 8> d;
  for (std::size_t i = right.size(); i-- > 0;) {
    if (right[i] == 0) continue;
    const float *a = boxes + 8 * (i + 1), *b = boxes + std::size_t{8} * right[i];
    for (std::size_t lane = 0; lane < 8; lane += hn::Lanes(d))
      hn::Store(hn::Min(hn::Load(d, a + lane), hn::Load(d, b + lane)), d, boxes + 8 * i + lane);
  }
}

void FitLeaves(const float* points, std::span<const Index> places, std::span<const Floor::Leaf> leaves,
               float* boxes) {
  for (const Floor::Leaf& leaf : leaves)
    FitLeaf(points, places.subspan(leaf.begin, leaf.end - leaf.begin), boxes + std::size_t{8} * leaf.node);
}

}  // namespace foldproof::bench::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace foldproof::bench {

HWY_EXPORT(GatherPoints);
HWY_EXPORT(FitLeaves);
HWY_EXPORT(FitInnerNodes);

Floor::Floor(const Hierarchy& h)
    : ids_(h.vertex_ids().begin(), h.vertex_ids().end()), points_(ids_.size()), boxes_(h.nodes().size()) {
  const Index last = h.topology().vertex_count() - 1;
  place_of_last_ = static_cast<std::size_t>(std::find(ids_.begin(), ids_.end(), last) - ids_.begin());
  for (Index node = 0; node < h.nodes().size(); ++node) {
    right_.push_back(h.nodes()[node].right);
    if (!h.nodes()[node].is_leaf()) continue;
    const auto* leaf = &h.leaves()[h.nodes()[node].leaf_begin];
    const auto begin = static_cast<std::ptrdiff_t>(places_.size());
    for (Index t = leaf[0].triangles; t < leaf[1].triangles; ++t)
      places_.insert(places_.end(), h.triangles()[t].begin(), h.triangles()[t].end());
    std::sort(places_.begin() + begin, places_.end());
    places_.erase(std::unique(places_.begin() + begin, places_.end()), places_.end());
    leaves_.push_back({node, static_cast<Index>(begin), static_cast<Index>(places_.size())});
  }
}

void Floor::fit(std::span<const double> x) {
  const std::span<const Index> ids(ids_);
  const auto gather = [&](std::size_t begin, std::size_t end) {
    HWY_DYNAMIC_DISPATCH(GatherPoints)
    (x.data(), ids.subspan(begin, end - begin), reinterpret_cast<float*>(points_.data() + begin));
  };
  gather(0, place_of_last_);
  if (place_of_last_ < ids.size()) {
    for (int axis = 0; axis < 3; ++axis)
      points_[place_of_last_].x[axis] = static_cast<float>(x[x.size() - 3 + axis]);
    gather(place_of_last_ + 1, ids.size());
  }
  float* boxes = boxes_.front().x;
  HWY_DYNAMIC_DISPATCH(FitLeaves)(points_.front().x, places_, leaves_, boxes);
  HWY_DYNAMIC_DISPATCH(FitInnerNodes)(right_, boxes);
}

}  // namespace foldproof::bench
#endif
