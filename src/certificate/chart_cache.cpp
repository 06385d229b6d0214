#include "certificate/chart_cache.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <numeric>

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

using View = Eigen::Map<const Eigen::Vector3f>;

}  // namespace

ChartCache::ChartCache(std::shared_ptr<const PatchSlots> slots, std::shared_ptr<const ChartLibrary> trained)
    : trained_(std::move(trained)),
      own_(std::move(slots)),
      states_(own_.slots()->count()),
      covered_(own_.slots()->hierarchy()->leaf_count(), Cover::None),
      leaf_normals_(own_.slots()->hierarchy()->leaf_count()),
      builders_([this] { return ChartBuilder(*own_.slots()); }) {}

bool ChartCache::holds(const ChartLibrary& library, Index chart, std::span<const MovingVertex> vertices,
                       double gap, ChartTester& tester) const {
  ++tester.tests;
  tester.triangles += library.charts()[chart].triangles.count;
  return chart_holds(view_of(library, library.charts()[chart]), vertices, gap, tester.scratch);
}

// Tests the chart that held last first. Slots whose charts keep failing are tested less and less often.
ChartCache::Proof ChartCache::prove(SlotIndex slot, std::span<const MovingVertex> vertices, double gap,
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

bool ChartCache::wants_node(NodeIndex node) const {
  return states_[node].build_from <= step_ && slots().triangle_count(node) <= kMaxTriangles;
}

void ChartCache::back_off(SlotIndex slot, ChartOutcome outcome) {
  SlotState& state = states_[slot];
  state.outcome = outcome;
  state.build_from = step_ + (kBackOff << state.failed_builds);
  state.failed_builds = std::min<std::uint8_t>(state.failed_builds + 1, kMaxFailedBuilds);
}

void ChartCache::add_build(SlotIndex slot) {
  if (build_count_ == builds_.size()) builds_.emplace_back();
  builds_[build_count_++].slot = slot;
}

void ChartCache::run_builds(std::span<const MovingVertex> vertices) {
  parallel_for(std::size_t{0}, build_count_,
               [&](std::size_t i) { builders_.local().build(vertices, builds_[i]); });
  places_.clear();
  for (std::size_t i = 0; i < build_count_; ++i) places_.push_back(place(builds_[i]));
  parallel_for(std::size_t{0}, build_count_, [&](std::size_t i) {
    if (places_[i] != kNoIndex) own_.fill(places_[i], builds_[i].patch, builds_[i].ring, builds_[i].uv_map);
  });
  charts_built_ += build_count_;
}

// Makes room for a chart. Returns its index in the library, or kNoIndex where the build failed. The slots of
// one run are different, so are their charts.
Index ChartCache::place(const BuiltChart& build) {
  // Counts as a failure until the chart holds once: one that is built again and again is useless.
  back_off(SlotIndex(build.slot), build.outcome);
  if (build.outcome != ChartOutcome::Made) return kNoIndex;
  SlotState& state = states_[build.slot];
  state.failed_tests = 0;
  state.test_from = step_;
  Index oldest = kNoIndex;
  if (state.built < kMaxCharts) {
    ++state.built;
  } else {
    oldest = own_.first(build.slot);
    for (Index c = oldest; c != kNoIndex; c = own_.charts()[c].next) {
      if (own_.charts()[c].source < own_.charts()[oldest].source) oldest = c;
    }
  }
  return own_.place(build.slot, step_, oldest, build.patch, build.ring, build.uv_map);
}

const std::array<float, 3>& ChartCache::leaf_normal(Index leaf, std::span<const MovingVertex> vertices) {
  LeafNormal& normal = leaf_normals_[leaf];
  if (normal.step == step_) return normal.direction;
  const Hierarchy& h = *slots().hierarchy();
  const auto corner = [&](Index v) { return View(vertices[v].x); };
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  for (Index t = h.leaves()[leaf].triangles; t < h.leaves()[leaf + 1].triangles; ++t) {
    const Triangle& c = h.triangles()[t];
    sum += (corner(c[1]) - corner(c[0])).cross(corner(c[2]) - corner(c[0]));
  }
  sum.normalize();
  normal = {{sum.x(), sum.y(), sum.z()}, step_};
  return normal.direction;
}

// A cheap estimate: whether there is a direction that every leaf of the node faces.
bool ChartCache::looks_flat(NodeIndex node, std::span<const MovingVertex> vertices) {
  const Hierarchy::Node& n = slots().hierarchy()->nodes()[node];
  const auto normal = [&](Index leaf) { return View(leaf_normals_[leaf].direction.data()); };
  Eigen::Vector3f facing = Eigen::Vector3f::Zero();
  for (Index leaf = n.leaf_begin; leaf < n.leaf_end; ++leaf)
    facing += View(leaf_normal(leaf, vertices).data());
  for (int round = 2;; ++round) {
    Index worst = n.leaf_begin;
    for (Index leaf = n.leaf_begin; leaf < n.leaf_end; ++leaf) {
      if (normal(leaf).dot(facing) < normal(worst).dot(facing)) worst = leaf;
    }
    const float cosine = normal(worst).dot(facing.normalized());
    if (cosine > kMinLeafCosine) return true;
    if (round > 10 || cosine < -0.9f) return false;
    facing = facing.normalized() + normal(worst) * (1.2f / static_cast<float>(round));
  }
}

// The largest first. A counting sort: comparisons would read the sizes of nodes far apart again and again.
void ChartCache::sort_requested_nodes() {
  const Index largest = std::min(kMaxTriangles, slots().triangle_count(0));
  size_begin_.assign(largest + 2, 0);
  const auto rank = [&](NodeIndex node) { return largest - slots().triangle_count(node); };
  for (const NodeIndex node : requested_nodes_) ++size_begin_[rank(node) + 1];
  std::partial_sum(size_begin_.begin(), size_begin_.end(), size_begin_.begin());
  sorted_nodes_.resize(requested_nodes_.size());
  for (const NodeIndex node : requested_nodes_) sorted_nodes_[size_begin_[rank(node)]++] = node;
  requested_nodes_.swap(sorted_nodes_);
}

// Builds from the largest node to the smallest, in rounds. Nodes below one that is being built wait; those
// whose ancestor fails are tried in the next round, unless a smaller share of triangles than `least_made` got
// a chart in this one.
void ChartCache::build_nodes(std::span<const MovingVertex> vertices, std::size_t& budget, double least_made) {
  std::fill(covered_.begin(), covered_.end(), Cover::None);
  if (requested_nodes_.empty()) return;
  sort_requested_nodes();
  while (!requested_nodes_.empty()) {
    build_count_ = 0;
    choose_nodes(vertices, budget);
    if (build_count_ == 0) break;
    run_builds(vertices);
    double tried = 0, made = 0;
    for (std::size_t i = 0; i < build_count_; ++i) {
      const double triangles = slots().triangle_count(builds_[i].slot);
      tried += triangles;
      if (builds_[i].outcome == ChartOutcome::Made) {
        made += triangles;
      } else {
        cover(NodeIndex(builds_[i].slot), Cover::None);
      }
    }
    if (made < least_made * tried) break;
  }
  requested_nodes_.clear();
}

// Adds the builds of a round; keeps the requests of nodes that wait. Nodes that are not below one another and
// that the budget allows are tested at once; the choice is that of testing one after the other.
void ChartCache::choose_nodes(std::span<const MovingVertex> vertices, std::size_t& budget) {
  const auto cost_of = [&](NodeIndex node) {
    return slots().triangle_count(node) * std::size_t{3} / 2;
  };  // with a ring
  std::size_t kept = 0;
  for (auto next = requested_nodes_.begin(); next != requested_nodes_.end();) {
    maybe_flat_.clear();
    for (std::size_t total = 0; next != requested_nodes_.end(); ++next) {
      const std::size_t cost = cost_of(*next);
      if (cost > budget) continue;
      const Cover covered = covered_[slots().hierarchy()->nodes()[*next].leaf_begin];
      if (covered == Cover::Built) {
        requested_nodes_[kept++] = *next;
        continue;
      }
      if (covered == Cover::MaybeBuilt || total + cost > budget) break;
      total += cost;
      cover(*next, Cover::MaybeBuilt);
      maybe_flat_.push_back(*next);
    }
    is_flat_.resize(maybe_flat_.size());
    parallel_for(std::size_t{0}, maybe_flat_.size(),
                 [&](std::size_t k) { is_flat_[k] = looks_flat(maybe_flat_[k], vertices); });
    for (std::size_t k = 0; k < maybe_flat_.size(); ++k) {
      const NodeIndex node = maybe_flat_[k];
      const SlotIndex slot(slots().of_node(node));
      cover(node, is_flat_[k] ? Cover::Built : Cover::None);
      if (is_flat_[k]) {
        budget -= cost_of(node);
        add_build(slot);
      } else {
        back_off(slot, ChartOutcome::TooCurved);
      }
    }
  }
  requested_nodes_.resize(kept);
}

void ChartCache::cover(NodeIndex node, Cover value) {
  const Hierarchy::Node& n = slots().hierarchy()->nodes()[node];
  std::fill(covered_.begin() + n.leaf_begin, covered_.begin() + n.leaf_end, value);
}

void ChartCache::build_pairs(std::span<const MovingVertex> vertices, std::size_t& budget) {
  build_count_ = 0;
  for (const SlotIndex slot : requested_pairs_) {
    const auto [a, b] = slots().leaves_of(slot);
    const std::size_t cost = slots().triangle_count(slot);
    if (cost > budget) break;
    // A new chart of a node above may prove the pair as well.
    if (covered_[a] != Cover::None || covered_[b] != Cover::None) continue;
    budget -= cost;
    add_build(slot);
  }
  requested_pairs_.clear();
  run_builds(vertices);
}

void ChartCache::begin_step(std::span<const MovingVertex> vertices, std::size_t budget) {
  ++step_;
  charts_built_ = 0;
  build_nodes(vertices, budget, 0);
  build_pairs(vertices, budget);
}

void ChartCache::begin_pose(std::span<const MovingVertex> vertices) {
  constexpr double kLeastMade = 0.5;
  ++step_;
  charts_built_ = 0;
  for (Index node = 0; node < slots().hierarchy()->nodes().size(); ++node) {
    if (wants_node(NodeIndex(node))) requested_nodes_.emplace_back(node);
  }
  std::size_t budget = std::numeric_limits<std::size_t>::max();
  build_nodes(vertices, budget, kLeastMade);
}

}  // namespace foldproof::internal
