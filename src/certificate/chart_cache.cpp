#include "certificate/chart_cache.h"

#include <Eigen/Geometry>

#include <algorithm>

#include "base/parallel.h"

namespace foldproof::internal {
namespace {

// Per patch: larger ones rarely face one plane.
constexpr Index kMaxTriangles = 4096;
// Per slot: later charts replace the oldest.
constexpr std::uint8_t kMaxCharts = 2;
// Back-off of builds: 8 steps after a failure, then 16, and so on up to 8 * 2^5.
constexpr std::uint32_t kBackOff = 8;
constexpr std::uint8_t kMaxFailedBuilds = 5;
// Back-off of tests: after two failures in a row every second step, then every fourth.
constexpr std::uint8_t kMaxFailedTests = 3;
// The smallest cosine between a leaf's normal and the normal of its node's plane for which a build is tried.
constexpr float kMinLeafCosine = 0.3f;

}  // namespace

ChartCache::ChartCache(std::shared_ptr<const PatchSlots> slots, std::shared_ptr<const ChartLibrary> trained)
    : trained_(std::move(trained)),
      own_(std::move(slots)),
      states_(own_.slots()->count()),
      covered_(own_.slots()->hierarchy()->leaf_count(), 0),
      leaf_normals_(own_.slots()->hierarchy()->leaf_count()),
      builders_([this] { return ChartBuilder(*own_.slots()); }) {}

bool ChartCache::holds(const ChartLibrary& library, Index chart, std::span<const MovingVertex> vertices,
                       double gap, ChartTester& tester) const {
  ++tester.tests;
  tester.triangles += library.charts()[chart].triangles.count;
  return chart_holds(view_of(library, library.charts()[chart]), vertices, gap, tester.scratch);
}

// Tests the chart that held last first. Slots whose charts keep failing are tested less and less often.
ChartCache::Proof ChartCache::prove(Index slot, std::span<const MovingVertex> vertices, double gap,
                                    ChartTester& tester) {
  SlotState& state = states_[slot];
  if (state.test_from > step_) return {};
  const std::uint64_t tests_before = tester.tests;
  const auto found = [&](const ChartLibrary& library, Index chart) -> Proof {
    state.last = chart;
    state.last_was_trained = &library == trained_.get();
    tester.first_proofs += state.failed_builds > 0;
    state.failed_builds = state.failed_tests = 0;
    return {&library, chart};
  };
  const ChartLibrary* last = state.last_was_trained ? trained_.get() : &own_;
  if (state.last != kNoIndex && holds(*last, state.last, vertices, gap, tester))
    return found(*last, state.last);
  for (const ChartLibrary* library : {static_cast<const ChartLibrary*>(&own_), trained_.get()}) {
    if (library == nullptr) continue;
    for (Index c = library->first(slot); c != kNoIndex; c = library->charts()[c].next) {
      if (library == last && c == state.last) continue;
      if (holds(*library, c, vertices, gap, tester)) return found(*library, c);
    }
  }
  if (tester.tests > tests_before) {
    state.failed_tests = std::min<std::uint8_t>(state.failed_tests + 1, kMaxFailedTests);
    state.test_from = step_ + (1u << state.failed_tests) / 2;
  }
  return {};
}

void ChartCache::request_node(Index node) {
  if (states_[node].build_from > step_ || slots().triangle_count(node) > kMaxTriangles) return;
  requested_nodes_.push_back(node);
}

void ChartCache::request_pair(Index slot) {
  if (states_[slot].build_from <= step_) requested_pairs_.push_back(slot);
}

void ChartCache::back_off(Index slot, ChartOutcome outcome) {
  SlotState& state = states_[slot];
  state.outcome = outcome;
  state.build_from = step_ + (kBackOff << state.failed_builds);
  state.failed_builds = std::min<std::uint8_t>(state.failed_builds + 1, kMaxFailedBuilds);
}

void ChartCache::add_build(Index slot) {
  if (build_count_ == builds_.size()) builds_.emplace_back();
  builds_[build_count_++].slot = slot;
}

void ChartCache::run_builds(std::span<const MovingVertex> vertices) {
  parallel_for(std::size_t{0}, build_count_,
               [&](std::size_t i) { builders_.local().build(vertices, builds_[i]); });
  for (std::size_t i = 0; i < build_count_; ++i) store(builds_[i]);
  charts_built_ += build_count_;
}

void ChartCache::store(const BuiltChart& build) {
  // Counts as a failure until the chart holds once: one that is built again and again is useless.
  back_off(build.slot, build.outcome);
  if (build.outcome != ChartOutcome::Made) return;
  SlotState& state = states_[build.slot];
  state.failed_tests = 0;
  state.test_from = step_;
  if (state.built < kMaxCharts) {
    own_.add(build.slot, step_, build.patch, build.ring, build.uv_map);
    ++state.built;
    return;
  }
  Index oldest = own_.first(build.slot);
  for (Index c = oldest; c != kNoIndex; c = own_.charts()[c].next) {
    if (own_.charts()[c].source < own_.charts()[oldest].source) oldest = c;
  }
  own_.replace(oldest, step_, build.patch, build.ring, build.uv_map);
}

const Eigen::Vector3f& ChartCache::leaf_normal(Index leaf, std::span<const MovingVertex> vertices) {
  LeafNormal& normal = leaf_normals_[leaf];
  if (normal.step == step_) return normal.direction;
  const Hierarchy& h = *slots().hierarchy();
  const auto corner = [&](Index v) { return Eigen::Map<const Eigen::Vector3f>(vertices[v].x); };
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  for (Index t = h.leaves()[leaf].triangles; t < h.leaves()[leaf + 1].triangles; ++t) {
    const Triangle& c = h.triangles()[t];
    sum += (corner(c[1]) - corner(c[0])).cross(corner(c[2]) - corner(c[0]));
  }
  normal = {sum.normalized(), step_};
  return normal.direction;
}

// A cheap estimate: whether there is a direction that every leaf of the node faces.
bool ChartCache::looks_flat(Index node, std::span<const MovingVertex> vertices) {
  const Hierarchy::Node& n = slots().hierarchy()->nodes()[node];
  Eigen::Vector3f facing = Eigen::Vector3f::Zero();
  for (Index leaf = n.leaf_begin; leaf < n.leaf_end; ++leaf) facing += leaf_normal(leaf, vertices);
  for (int round = 2;; ++round) {
    Index worst = n.leaf_begin;
    for (Index leaf = n.leaf_begin; leaf < n.leaf_end; ++leaf) {
      if (leaf_normals_[leaf].direction.dot(facing) < leaf_normals_[worst].direction.dot(facing))
        worst = leaf;
    }
    const float cosine = leaf_normals_[worst].direction.dot(facing.normalized());
    if (cosine > kMinLeafCosine) return true;
    if (round > 10 || cosine < -0.9f) return false;
    facing = facing.normalized() + leaf_normals_[worst].direction * (1.2f / static_cast<float>(round));
  }
}

// Builds from the largest node to the smallest, in rounds. Nodes below one that is being built wait; those
// whose ancestor fails are tried in the next round.
void ChartCache::build_nodes(std::span<const MovingVertex> vertices, std::size_t& budget) {
  const auto nodes = slots().hierarchy()->nodes();
  // Unlike std::stable_sort, std::sort does not allocate.
  std::sort(requested_nodes_.begin(), requested_nodes_.end(), [&](Index a, Index b) {
    const Index size_a = slots().triangle_count(a), size_b = slots().triangle_count(b);
    return size_a != size_b ? size_a > size_b : a < b;
  });
  std::fill(covered_.begin(), covered_.end(), 0);
  const auto mark = [&](Index node, std::uint8_t value) {
    std::fill(covered_.begin() + nodes[node].leaf_begin, covered_.begin() + nodes[node].leaf_end, value);
  };
  while (!requested_nodes_.empty()) {
    build_count_ = 0;
    std::size_t kept = 0;
    for (const Index node : requested_nodes_) {
      const std::size_t cost = slots().triangle_count(node) * 3 / 2;  // roughly, with a ring
      if (cost > budget) continue;
      if (covered_[nodes[node].leaf_begin]) {
        requested_nodes_[kept++] = node;
      } else if (!looks_flat(node, vertices)) {
        back_off(node, ChartOutcome::TooCurved);
      } else {
        budget -= cost;
        mark(node, 1);
        add_build(node);
      }
    }
    if (build_count_ == 0) break;
    requested_nodes_.resize(kept);
    run_builds(vertices);
    for (std::size_t i = 0; i < build_count_; ++i) {
      if (builds_[i].outcome != ChartOutcome::Made) mark(builds_[i].slot, 0);
    }
  }
  requested_nodes_.clear();
}

void ChartCache::build_pairs(std::span<const MovingVertex> vertices, std::size_t& budget) {
  build_count_ = 0;
  for (const Index slot : requested_pairs_) {
    const auto [a, b] = slots().leaves_of(slot);
    const std::size_t cost = slots().triangle_count(slot);
    if (cost > budget) break;
    // A new chart of a node above may prove the pair as well.
    if (covered_[a] || covered_[b]) continue;
    budget -= cost;
    add_build(slot);
  }
  requested_pairs_.clear();
  run_builds(vertices);
}

void ChartCache::begin_step(std::span<const MovingVertex> vertices, std::size_t budget) {
  ++step_;
  charts_built_ = 0;
  build_nodes(vertices, budget);
  build_pairs(vertices, budget);
}

}  // namespace foldproof::internal
