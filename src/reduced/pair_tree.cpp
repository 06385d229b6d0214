#include "reduced/pair_tree.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>

#include "base/parallel.h"
#include "base/try.h"

namespace foldproof::internal {
namespace {

// Pairs that are split together; a constant, so that the tree does not depend on the number of threads.
constexpr std::size_t kBatch = 64;

// Limits the pairs of leaves that are refined feature by feature; the smallest balls come first.
constexpr std::size_t kRefinedPerLeaf = 2;

// A pair without a ball would make its center's radius zero. Such pairs are split beyond the budget, up to
// this multiple of it.
constexpr std::size_t kUrgentBudgets = 4;

using Pair = ReducedBalls::Pair;

bool is_leaf_pair(std::span<const Hierarchy::Node> nodes, const Pair& pair) {
  return nodes[pair.a].is_leaf() && nodes[pair.b].is_leaf();
}

std::array<Index, 2> leaves_of(std::span<const Hierarchy::Node> nodes, const Pair& pair) {
  const auto [first, second] = std::minmax(nodes[pair.a].leaf_begin, nodes[pair.b].leaf_begin);
  return {first, second};
}

// The pairs that have all features of a pair between them (R4). Precondition: one of its nodes has children.
std::span<const NodePairIds> split_pair(std::span<const Hierarchy::Node> nodes, NodePairIds pair,
                                        std::array<NodePairIds, 3>& parts) {
  const auto [a, b] = pair;
  const auto size = [&](Index node) { return nodes[node].leaf_end - nodes[node].leaf_begin; };
  if (a == b) {
    parts = {{{a + 1, a + 1}, {nodes[a].right, nodes[a].right}, {a + 1, nodes[a].right}}};
    return parts;
  }
  if (size(a) >= size(b)) {
    parts = {{{a + 1, b}, {nodes[a].right, b}}};
  } else {
    parts = {{{a, b + 1}, {a, nodes[b].right}}};
  }
  return std::span(parts).first(2);
}

class BallBuilder {
 public:
  BallBuilder(const BallInput& input, std::span<const ReducedCenter> centers)
      : input_(input),
        centers_(centers),
        nodes_(input.motion.hierarchy()->nodes()),
        pair_balls_([&] { return PairBalls(input); }) {
    balls_.clearance = input.gap;
  }

  Result<ReducedBalls> build(std::size_t max_pairs, const ReducedHooks& hooks) {
    const std::size_t max_refined = kRefinedPerLeaf * std::size_t{input_.motion.hierarchy()->leaf_count()};
    balls_.pairs.push_back({0, 0});
    measure(0);
    std::size_t refined = 0;
    while (!queue_.empty()) {
      const bool urgent = queue_.top().share == 0 && balls_.pairs.size() < kUrgentBudgets * max_pairs;
      const bool may_split = urgent || balls_.pairs.size() < max_pairs;
      const bool may_refine = urgent || refined < max_refined;
      if (!may_split && !may_refine) break;
      if (hooks.cancel != nullptr && *hooks.cancel)
        return fail(ErrorCode::Interrupted, "cancelled", "the work was ended", "start again");
      if (hooks.progress)
        hooks.progress(std::min(1.0, static_cast<double>(balls_.pairs.size() + refined) /
                                         static_cast<double>(max_pairs + max_refined)));
      to_split_.clear();
      to_refine_.clear();
      while (!queue_.empty() && to_split_.size() + to_refine_.size() < kBatch) {
        const Index pair = queue_.top().pair;
        queue_.pop();
        (is_leaf_pair(nodes_, balls_.pairs[pair]) ? to_refine_ : to_split_).push_back(pair);
      }
      const std::size_t first = balls_.pairs.size();
      if (may_split) {
        for (const Index pair : to_split_) split(pair);
        measure(first);
      }
      if (may_refine) refine();
      refined += to_refine_.size();
    }
    return std::move(balls_);
  }

 private:
  struct Queued {
    float share;  // the ball's radius as a share of max_radius, the smallest of all centers
    Index pair;
    bool operator<(const Queued& other) const {  // the smallest share on top, then the oldest
      return share != other.share ? share > other.share : pair > other.pair;
    }
  };

  void split(Index pair);
  void measure(std::size_t first);
  void refine();

  const BallInput& input_;
  std::span<const ReducedCenter> centers_;
  std::span<const Hierarchy::Node> nodes_;
  PerThread<PairBalls> pair_balls_;
  ReducedBalls balls_;
  std::priority_queue<Queued> queue_;  // pairs with a ball below max_radius
  std::vector<Index> to_split_, to_refine_;
};

void BallBuilder::split(Index pair) {
  const auto begin = static_cast<Index>(balls_.pairs.size());
  std::array<NodePairIds, 3> parts;
  for (const auto& [a, b] : split_pair(nodes_, {balls_.pairs[pair].a, balls_.pairs[pair].b}, parts))
    balls_.pairs.push_back({a, b});
  balls_.pairs[pair].begin = begin;
  balls_.pairs[pair].count = static_cast<Index>(balls_.pairs.size()) - begin;
}

// Finds the balls of the pairs from `first` on, and queues those that fall short of max_radius.
void BallBuilder::measure(std::size_t first) {
  const std::size_t count = balls_.pairs.size(), width = centers_.size();
  balls_.radii.resize(count * width);
  parallel_for(first, count, [&](std::size_t i) {
    const NodePairIds pair{balls_.pairs[i].a, balls_.pairs[i].b};
    for (Index c = 0; c < width; ++c)
      balls_.radii[i * width + c] = round_down(pair_balls_.local().radius(pair, c, centers_[c].max_radius));
  });
  for (std::size_t i = first; i < count; ++i) {
    float share = 1;
    for (std::size_t c = 0; c < width; ++c)
      share = std::min(share, balls_.radii[i * width + c] / static_cast<float>(centers_[c].max_radius));
    if (share < 1) queue_.push({share, static_cast<Index>(i)});
  }
}

// Pairs of leaves cannot be split; their features are tested one by one.
void BallBuilder::refine() {
  const std::size_t width = centers_.size();
  parallel_for(std::size_t{0}, to_refine_.size(), [&](std::size_t i) {
    const NodePairIds pair{balls_.pairs[to_refine_[i]].a, balls_.pairs[to_refine_[i]].b};
    for (Index c = 0; c < width; ++c) {
      float& ball = balls_.radii[to_refine_[i] * width + c];
      if (ball >= centers_[c].max_radius) continue;
      const double found = pair_balls_.local().feature_radius(pair, c, ball, centers_[c].max_radius);
      ball = std::max(ball, round_down(found));
    }
  });
}

// As make_pair_tree, but for one center alone and without all pairs of leaves that this center does not
// prove.
PairTreeResult::AtCenter at_center(const Hierarchy& hierarchy, std::span<const ReducedCenter> centers,
                                   const ReducedBalls& balls, Index center) {
  PairTreeResult::AtCenter result;
  const std::size_t width = centers.size();
  std::vector<float> radius(balls.pairs.size());
  for (std::size_t i = balls.pairs.size(); i-- > 0;) {
    const Pair& pair = balls.pairs[i];
    radius[i] = balls.radii[i * width + center];
    if (pair.count > 0) {
      const auto children = radius.begin() + pair.begin;
      radius[i] = std::max(radius[i], *std::min_element(children, children + pair.count));
    } else if (radius[i] == 0 && is_leaf_pair(hierarchy.nodes(), pair)) {
      radius[i] = std::numeric_limits<float>::infinity();
      result.uncertified.push_back(leaves_of(hierarchy.nodes(), pair));
    }
  }
  std::sort(result.uncertified.begin(), result.uncertified.end());
  result.radius = std::min(double{radius[0]}, centers[center].max_radius);
  return result;
}

}  // namespace

Result<ReducedBalls> build_balls(const BallInput& input, std::span<const ReducedCenter> centers,
                                 std::size_t max_pairs, const ReducedHooks& hooks) {
  return BallBuilder(input, centers).build(max_pairs, hooks);
}

bool are_balls_of(const Hierarchy& hierarchy, std::size_t centers, const ReducedBalls& balls) {
  const auto nodes = hierarchy.nodes();
  const auto& pairs = balls.pairs;
  if (pairs.empty() || pairs[0].a != 0 || pairs[0].b != 0) return false;
  if (balls.radii.size() % pairs.size() != 0 || balls.radii.size() / pairs.size() != centers) return false;
  if (!(balls.clearance > 0) || !std::isfinite(balls.clearance)) return false;
  // Each pair is a part of one before it, and compared with it: so its nodes are in range.
  std::vector<bool> is_part(pairs.size(), false);
  is_part[0] = true;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const Pair& pair = pairs[i];
    if (!is_part[i]) return false;
    if (pair.count == 0) continue;
    if (is_leaf_pair(nodes, pair)) return false;
    std::array<NodePairIds, 3> parts;
    const auto expected = split_pair(nodes, {pair.a, pair.b}, parts);
    if (pair.count != expected.size() || pair.begin <= i || pair.begin >= pairs.size() ||
        expected.size() > pairs.size() - pair.begin)
      return false;
    for (std::size_t k = 0; k < expected.size(); ++k) {
      const Pair& part = pairs[pair.begin + k];
      if (part.a != expected[k][0] || part.b != expected[k][1] || is_part[pair.begin + k]) return false;
      is_part[pair.begin + k] = true;
    }
  }
  return std::ranges::all_of(balls.radii, [](float radius) { return radius >= 0; });
}

PairTreeResult make_pair_tree(const Hierarchy& hierarchy, std::span<const ReducedCenter> centers,
                              const ReducedBalls& balls) {
  PairTreeResult result;
  const std::size_t width = centers.size();
  for (Index c = 0; c < width; ++c) result.at_center.push_back(at_center(hierarchy, centers, balls, c));
  result.radii = balls.radii;
  // Children come after their parents: one sweep from the back counts them in.
  for (std::size_t i = balls.pairs.size(); i-- > 0;) {
    const Pair& pair = balls.pairs[i];
    const auto own = std::span(result.radii).subspan(i * width, width);
    const bool proven = std::ranges::any_of(own, [](float radius) { return radius > 0; });
    if (pair.count == 0 && !proven && is_leaf_pair(hierarchy.nodes(), pair)) {
      result.never_certified.push_back(leaves_of(hierarchy.nodes(), pair));
      std::fill(own.begin(), own.end(), std::numeric_limits<float>::infinity());
    }
    for (std::size_t c = 0; c < width && pair.count > 0; ++c) {
      float smallest = std::numeric_limits<float>::infinity();
      for (Index child = pair.begin; child < pair.begin + pair.count; ++child)
        smallest = std::min(smallest, result.radii[child * width + c]);
      own[c] = std::max(own[c], smallest);
    }
  }
  std::sort(result.never_certified.begin(), result.never_certified.end());
  return result;
}

}  // namespace foldproof::internal
