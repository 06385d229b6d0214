#include "certificate/book.h"

#include <tbb/parallel_for.h>
#include <Eigen/Geometry>

#include <algorithm>
#include <functional>

namespace foldproof {
namespace {

// After a slot was drawn in vain it rests for 4 steps, then for 8, and so on up to 4 * 2^5.
constexpr std::uint32_t kRest = 4;
constexpr std::uint8_t kMostFailures = 5;
// How far the leaves of a node that is worth drawing must face its plane at least, as a cosine.
constexpr float kFlatEnough = 0.3f;

}  // namespace

ChartBook::ChartBook(std::shared_ptr<const PatchSlots> slots, std::shared_ptr<const ChartLibrary> trained,
                     const LearnSettings& settings)
    : settings_(settings),
      trained_(std::move(trained)),
      own_(slots),
      patience_(slots->count()),
      drawn_(slots->hierarchy()->leaf_count(), 0),
      leaf_normals_(slots->hierarchy()->leaf_count()),
      workshops_(std::cref(*slots)) {}

bool ChartBook::any_holds(Index slot, std::span<const MovingVertex> vertices, double gap,
                          ChartTester& tester) {
  const auto any = [&](const ChartLibrary& library) {
    for (Index c = library.first(slot); c != kNoIndex; c = library.charts()[c].next) {
      const ChartLibrary::Chart& chart = library.charts()[c];
      ++tester.tests;
      const ChartView view{library.vertices(chart), library.points(chart), library.triangles(chart),
                           chart.fit};
      if (chart_holds(view, vertices, gap, tester.scratch)) return true;
    }
    return false;
  };
  if (!any(own_) && !(trained_ && any(*trained_))) return false;
  patience_[slot].failures = 0;
  return true;
}

NodeProof ChartBook::prove_node(Index node, std::span<const MovingVertex> vertices, double gap,
                                ChartTester& tester) {
  if (any_holds(slots().of_collared(node), vertices, gap, tester)) return NodeProof::WithCollar;
  return any_holds(slots().of_node(node), vertices, gap, tester) ? NodeProof::Inside : NodeProof::None;
}

bool ChartBook::prove_pair(Index slot, std::span<const MovingVertex> vertices, double gap,
                           ChartTester& tester) {
  return any_holds(slot, vertices, gap, tester);
}

void ChartBook::want_node(Index node) {
  if (patience_[node].until > step_ || slots().size_of(node) > settings_.most_triangles) return;
  wanted_nodes_.push_back(node);
}

void ChartBook::want_pair(Index slot) {
  if (patience_[slot].until <= step_) wanted_pairs_.push_back(slot);
}

void ChartBook::lose_patience(Index slot) {
  Patience& patience = patience_[slot];
  patience.until = step_ + (kRest << patience.failures);
  patience.failures = std::min<std::uint8_t>(patience.failures + 1, kMostFailures);
}

void ChartBook::order(Index slot) {
  if (order_count_ == orders_.size()) orders_.emplace_back();
  orders_[order_count_++].slot = slot;
}

void ChartBook::draw(Order& order, std::span<const MovingVertex> vertices) {
  Workshop& shop = workshops_.local();
  const auto attempt = [&] {
    shop.reader.read(order.slot, order.patch);
    shop.positions.clear();
    for (const Index v : order.patch.vertices) {
      const float* x = vertices[v].x;
      shop.positions.push_back({x[0], x[1], x[2]});
    }
    order.outcome = shop.maker.draw(order.patch, shop.positions, order.drawing);
  };
  attempt();
  if (order.outcome == ChartOutcome::Made || !slots().is_collared(order.slot)) return;
  order.slot = slots().node_of(order.slot);
  attempt();
}

void ChartBook::draw_orders(std::span<const MovingVertex> vertices) {
  tbb::parallel_for(std::size_t{0}, order_count_, [&](std::size_t i) { draw(orders_[i], vertices); });
  for (std::size_t i = 0; i < order_count_; ++i) enter(orders_[i]);
}

void ChartBook::enter(const Order& order) {
  // Counts as a failure until a test holds: a chart that is drawn again and again is of no use.
  lose_patience(slots().is_pair(order.slot) ? order.slot : slots().node_of(order.slot));
  if (order.outcome != ChartOutcome::Made) return;
  Patience& patience = patience_[order.slot];
  if (patience.drawn < settings_.most_charts) {
    own_.add(order.slot, step_, order.patch, order.drawing);
    ++patience.drawn;
    return;
  }
  Index oldest = own_.first(order.slot);
  for (Index c = oldest; c != kNoIndex; c = own_.charts()[c].next) {
    if (own_.charts()[c].source < own_.charts()[oldest].source) oldest = c;
  }
  own_.replace(oldest, step_, order.drawing);
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
  std::stable_sort(wanted_nodes_.begin(), wanted_nodes_.end(),
                   [&](Index a, Index b) { return slots().size_of(a) > slots().size_of(b); });
  std::fill(drawn_.begin(), drawn_.end(), 0);
  const auto mark = [&](Index node, std::uint8_t value) {
    std::fill(drawn_.begin() + nodes[node].leaf_begin, drawn_.begin() + nodes[node].leaf_end, value);
  };
  while (!wanted_nodes_.empty()) {
    order_count_ = 0;
    std::size_t kept = 0;
    for (const Index node : wanted_nodes_) {
      const std::size_t cost = slots().size_of(slots().of_collared(node));
      if (cost > budget) continue;
      if (drawn_[nodes[node].leaf_begin]) {
        wanted_nodes_[kept++] = node;
      } else if (!looks_flat(node, vertices)) {
        lose_patience(node);
      } else {
        budget -= cost;
        mark(node, 1);
        order(slots().of_collared(node));
      }
    }
    if (order_count_ == 0) break;
    wanted_nodes_.resize(kept);
    draw_orders(vertices);
    for (std::size_t i = 0; i < order_count_; ++i) {
      if (orders_[i].outcome != ChartOutcome::Made) mark(slots().node_of(orders_[i].slot), 0);
    }
  }
  wanted_nodes_.clear();
}

void ChartBook::draw_pairs(std::span<const MovingVertex> vertices, std::size_t& budget) {
  order_count_ = 0;
  for (const Index slot : wanted_pairs_) {
    const auto [a, b] = slots().leaves_of(slot);
    const std::size_t cost = slots().size_of(slot);
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
  draw_nodes(vertices, budget);
  draw_pairs(vertices, budget);
}

}  // namespace foldproof
