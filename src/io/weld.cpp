// Merges vertices that have exactly the same position in the first frame.
#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "base/try.h"
#include "io/readers.h"

namespace foldproof::io {
namespace {

class WeldedMotion final : public Motion {
 public:
  WeldedMotion(std::unique_ptr<Motion> motion, Topology topology, std::vector<Index> first)
      : motion_(std::move(motion)), topology_(std::move(topology)), first_(std::move(first)) {}

  const std::string& name() const override { return motion_->name(); }
  const Topology& topology() const override { return topology_; }
  const MotionInfo& info() const override { return motion_->info(); }
  Index frame_count() const override { return motion_->frame_count(); }

  Result<void> read_frame(Index k, std::span<double> out) override {
    FOLDPROOF_TRY(check_request(*this, k, out));
    frame_.resize(std::size_t{3} * motion_->topology().vertex_count());
    FOLDPROOF_TRY(motion_->read_frame(k, frame_));
    auto kept = out.begin();
    for (Index v = 0; v < first_.size(); ++v) {
      const double *x = &frame_[std::size_t{3} * v], *merged_into = &frame_[std::size_t{3} * first_[v]];
      if (!std::equal(x, x + 3, merged_into)) {
        return fail(ErrorCode::InvalidMesh, name(),
                    fmt::format("vertices {} and {}, which --weld merged, part in frame {}", first_[v], v, k),
                    "check without --weld");
      }
      if (first_[v] == v) kept = std::copy_n(x, 3, kept);
    }
    return {};
  }

 private:
  std::unique_ptr<Motion> motion_;
  Topology topology_;
  std::vector<Index> first_;  // per old vertex, the first one that has its position in the first frame
  std::vector<double> frame_;
};

/// Of every vertex, the first one that has its position in the first frame.
Result<std::vector<Index>> first_at_same_place(Motion& motion) {
  const Index count = motion.topology().vertex_count();
  std::vector<double> positions(std::size_t{3} * count);
  FOLDPROOF_TRY(motion.read_frame(0, positions));
  // Compares numbers, not bits: -0 equals 0.
  const auto compare = [&](Index a, Index b) {
    const double *p = &positions[std::size_t{3} * a], *q = &positions[std::size_t{3} * b];
    for (int k = 0; k < 3; ++k) {
      if (p[k] != q[k]) return p[k] < q[k] ? -1 : 1;
    }
    return 0;
  };
  std::vector<Index> order(count);
  std::iota(order.begin(), order.end(), Index{0});
  std::sort(order.begin(), order.end(), [&](Index a, Index b) {
    const int sign = compare(a, b);
    return sign != 0 ? sign < 0 : a < b;
  });
  std::vector<Index> first(count);
  for (Index i = 0; i < count; ++i) {
    const bool same = i > 0 && compare(order[i - 1], order[i]) == 0;
    first[order[i]] = same ? first[order[i - 1]] : order[i];
  }
  return first;
}

}  // namespace

Result<Index> count_weldable(Motion& motion) {
  const auto first = FOLDPROOF_TRY(first_at_same_place(motion));
  Index count = 0;
  for (Index v = 0; v < first.size(); ++v) count += first[v] != v;
  return count;
}

Result<std::unique_ptr<Motion>> weld(std::unique_ptr<Motion> motion) {
  const Topology& topology = motion->topology();
  const Index count = topology.vertex_count();
  auto first = FOLDPROOF_TRY(first_at_same_place(*motion));
  Index kept = 0;
  std::vector<Index> renumbered(count);
  for (Index v = 0; v < count; ++v) renumbered[v] = first[v] == v ? kept++ : renumbered[first[v]];
  std::vector<Triangle> triangles(topology.triangles().begin(), topology.triangles().end());
  for (Triangle& t : triangles) {
    for (Index& v : t) v = renumbered[v];
  }
  auto welded = FOLDPROOF_TRY(Topology::make(kept, std::move(triangles)));
  return std::make_unique<WeldedMotion>(std::move(motion), std::move(welded), std::move(first));
}

}  // namespace foldproof::io
