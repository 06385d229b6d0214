#include "certificate/book.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <functional>

#include "base/parallel.h"

namespace foldproof {
namespace {

// After a slot was drawn in vain it rests for 8 steps, then for 16, and so on up to 8 * 2^5.
constexpr std::uint32_t kRest = 8;
constexpr std::uint8_t kMostVainDraws = 5;
// After its charts failed twice in a row a slot is asked every second step, then every fourth.
constexpr std::uint8_t kMostVainTests = 3;
// How far the leaves of a node that is worth drawing must face its plane at least, as a cosine.
constexpr float kFlatEnough = 0.3f;

}  // namespace

ChartBook::ChartBook(std::shared_ptr<const PatchSlots> slots, std::shared_ptr<const ChartLibrary> trained,
                     const BookSettings& settings)
    : settings_(settings),
      trained_(std::move(trained)),
      own_(std::move(slots)),
      memory_(own_.slots()->count()),
      drawn_(own_.slots()->hierarchy()->leaf_count(), 0),
      leaf_normals_(own_.slots()->hierarchy()->leaf_count()),
      drawers_([this] { return PatchDrawer(*own_.slots()); }) {}

bool ChartBook::holds(const ChartLibrary& library, Index chart, std::span<const MovingVertex> vertices,
                      double gap, ChartTester& tester) const {
  ++tester.tests;
  tester.triangles += library.charts()[chart].triangles.count;
  return chart_holds(view_of(library, library.charts()[chart]), vertices, gap, tester.scratch);
}

// The chart that held last is asked first. A slot whose charts fail again and again is asked less and less
// often.
ChartBook::Proof ChartBook::prove(Index slot, std::span<const MovingVertex> vertices, double gap,
                                  ChartTester& tester) {
  Memory& memory = memory_[slot];
  if (memory.test_from > step_) return {};
  const std::uint64_t tests_before = tester.tests;
  const auto found = [&](const ChartLibrary& library, Index chart) -> Proof {
    memory.last = chart;
    memory.last_was_trained = &library == trained_.get();
    tester.of_use += memory.vain_draws > 0;
    memory.vain_draws = memory.vain_tests = 0;
    return {&library, chart};
  };
  const ChartLibrary* last = memory.last_was_trained ? trained_.get() : &own_;
  if (memory.last != kNoIndex && holds(*last, memory.last, vertices, gap, tester))
    return found(*last, memory.last);
  for (const ChartLibrary* library : {static_cast<const ChartLibrary*>(&own_), trained_.get()}) {
    if (library == nullptr) continue;
    for (Index c = library->first(slot); c != kNoIndex; c = library->charts()[c].next) {
      if (library == last && c == memory.last) continue;
      if (holds(*library, c, vertices, gap, tester)) return found(*library, c);
    }
  }
  if (tester.tests > tests_before) {
    memory.vain_tests = std::min<std::uint8_t>(memory.vain_tests + 1, kMostVainTests);
    memory.test_from = step_ + (1u << memory.vain_tests) / 2;
  }
  return {};
}

void ChartBook::want_node(Index node) {
  if (memory_[node].draw_from > step_ || slots().triangles_of(node) > settings_.most_triangles) return;
  wanted_nodes_.push_back(node);
}

void ChartBook::want_pair(Index slot) {
  if (memory_[slot].draw_from <= step_) wanted_pairs_.push_back(slot);
}

void ChartBook::rest_from_drawing(Index slot, ChartOutcome outcome) {
  Memory& memory = memory_[slot];
  memory.outcome = outcome;
  memory.draw_from = step_ + (kRest << memory.vain_draws);
  memory.vain_draws = std::min<std::uint8_t>(memory.vain_draws + 1, kMostVainDraws);
}

void ChartBook::order(Index slot) {
  if (order_count_ == orders_.size()) orders_.emplace_back();
  orders_[order_count_++].slot = slot;
}

void ChartBook::draw_orders(std::span<const MovingVertex> vertices) {
  parallel_for(std::size_t{0}, order_count_,
               [&](std::size_t i) { drawers_.local().draw(vertices, orders_[i]); });
  for (std::size_t i = 0; i < order_count_; ++i) enter(orders_[i]);
  drawings_ += order_count_;
}

void ChartBook::enter(const DrawnPatch& order) {
  // Counts as a failure until a test holds: a chart that is drawn again and again is of no use.
  rest_from_drawing(order.slot, order.outcome);
  if (order.outcome != ChartOutcome::Made) return;
  Memory& memory = memory_[order.slot];
  memory.vain_tests = 0;
  memory.test_from = step_;
  if (memory.drawn < settings_.most_charts) {
    own_.add(order.slot, step_, order.patch, order.collar, order.drawing);
    ++memory.drawn;
    return;
  }
  Index oldest = own_.first(order.slot);
  for (Index c = oldest; c != kNoIndex; c = own_.charts()[c].next) {
    if (own_.charts()[c].source < own_.charts()[oldest].source) oldest = c;
  }
  own_.replace(oldest, step_, order.patch, order.collar, order.drawing);
}

const Eigen::Vector3f& ChartBook::leaf_normal(Index leaf, std::span<const MovingVertex> vertices) {
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

// A guess: there is a direction that every leaf of the node faces.
bool ChartBook::looks_flat(Index node, std::span<const MovingVertex> vertices) {
  const Hierarchy::Node& n = slots().hierarchy()->nodes()[node];
  Eigen::Vector3f facing = Eigen::Vector3f::Zero();
  for (Index leaf = n.leaf_begin; leaf < n.leaf_end; ++leaf) facing += leaf_normal(leaf, vertices);
  for (int round = 2;; ++round) {
    Index worst = n.leaf_begin;
    for (Index leaf = n.leaf_begin; leaf < n.leaf_end; ++leaf) {
      if (leaf_normals_[leaf].direction.dot(facing) < leaf_normals_[worst].direction.dot(facing))
        worst = leaf;
    }
    const float least = leaf_normals_[worst].direction.dot(facing.normalized());
    if (least > kFlatEnough) return true;
    if (round > 10 || least < -0.9f) return false;
    facing = facing.normalized() + leaf_normals_[worst].direction * (1.2f / static_cast<float>(round));
  }
}

// From the largest to the smallest, in rounds: what lies below a node that could be drawn is left out, what
// lies below one that could not has its turn in the next round.
void ChartBook::draw_nodes(std::span<const MovingVertex> vertices, std::size_t& budget) {
  const auto nodes = slots().hierarchy()->nodes();
  // Unlike std::stable_sort this allocates nothing.
  std::sort(wanted_nodes_.begin(), wanted_nodes_.end(), [&](Index a, Index b) {
    const Index size_a = slots().triangles_of(a), size_b = slots().triangles_of(b);
    return size_a != size_b ? size_a > size_b : a < b;
  });
  std::fill(drawn_.begin(), drawn_.end(), 0);
  const auto mark = [&](Index node, std::uint8_t value) {
    std::fill(drawn_.begin() + nodes[node].leaf_begin, drawn_.begin() + nodes[node].leaf_end, value);
  };
  while (!wanted_nodes_.empty()) {
    order_count_ = 0;
    std::size_t kept = 0;
    for (const Index node : wanted_nodes_) {
      const std::size_t cost = slots().triangles_of(node) * 3 / 2;  // with a collar, more or less
      if (cost > budget) continue;
      if (drawn_[nodes[node].leaf_begin]) {
        wanted_nodes_[kept++] = node;
      } else if (!looks_flat(node, vertices)) {
        rest_from_drawing(node, ChartOutcome::TooCurved);
      } else {
        budget -= cost;
        mark(node, 1);
        order(node);
      }
    }
    if (order_count_ == 0) break;
    wanted_nodes_.resize(kept);
    draw_orders(vertices);
    for (std::size_t i = 0; i < order_count_; ++i) {
      if (orders_[i].outcome != ChartOutcome::Made) mark(orders_[i].slot, 0);
    }
  }
  wanted_nodes_.clear();
}

void ChartBook::draw_pairs(std::span<const MovingVertex> vertices, std::size_t& budget) {
  order_count_ = 0;
  for (const Index slot : wanted_pairs_) {
    const auto [a, b] = slots().leaves_of(slot);
    const std::size_t cost = slots().triangles_of(slot);
    if (cost > budget) break;
    // A new chart of a node above may prove the pair.
    if (drawn_[a] || drawn_[b]) continue;
    budget -= cost;
    order(slot);
  }
  wanted_pairs_.clear();
  draw_orders(vertices);
}

void ChartBook::begin_step(std::span<const MovingVertex> vertices, std::size_t budget) {
  ++step_;
  drawings_ = 0;
  draw_nodes(vertices, budget);
  draw_pairs(vertices, budget);
}

}  // namespace foldproof
