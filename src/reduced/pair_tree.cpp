#include "reduced/pair_tree.h"

#include <algorithm>
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

class TreeBuilder {
 public:
  TreeBuilder(const BallInput& input, std::span<const ReducedCenter> centers)
      : input_(input),
        centers_(centers),
        nodes_(input.motion.hierarchy()->nodes()),
        pair_balls_([&] { return PairBalls(input); }) {
    tree_.centers = static_cast<Index>(centers.size());
  }

  Result<void> build(std::size_t max_pairs, const ReducedHooks& hooks) {
    const std::size_t max_refined = kRefinedPerLeaf * std::size_t{input_.motion.hierarchy()->leaf_count()};
    add({0, 0});
    measure(0);
    std::size_t refined = 0;
    while (!queue_.empty()) {
      const bool urgent = queue_.top().share == 0 && tree_.nodes.size() < kUrgentBudgets * max_pairs;
      const bool may_split = urgent || tree_.nodes.size() < max_pairs;
      const bool may_refine = urgent || refined < max_refined;
      if (!may_split && !may_refine) break;
      if (hooks.cancel != nullptr && *hooks.cancel)
        return fail(ErrorCode::Interrupted, "cancelled", "the work was ended", "start again");
      if (hooks.progress)
        hooks.progress(std::min(1.0, static_cast<double>(tree_.nodes.size() + refined) /
                                         static_cast<double>(max_pairs + max_refined)));
      to_split_.clear();
      to_refine_.clear();
      while (!queue_.empty() && to_split_.size() + to_refine_.size() < kBatch) {
        const Index pair = queue_.top().pair;
        queue_.pop();
        (is_leaf_pair(tree_.nodes[pair]) ? to_refine_ : to_split_).push_back(pair);
      }
      const std::size_t first = tree_.nodes.size();
      if (may_split) {
        for (const Index pair : to_split_) split(pair);
        measure(first);
      }
      if (may_refine) refine();
      refined += to_refine_.size();
    }
    return {};
  }

  PairTreeResult finish();

 private:
  struct Queued {
    float share;  // the ball's radius as a share of max_radius, the smallest of all centers
    Index pair;
    bool operator<(const Queued& other) const {  // the smallest share on top, then the oldest
      return share != other.share ? share > other.share : pair > other.pair;
    }
  };

  bool is_leaf_pair(const PairTree::Node& n) const { return nodes_[n.a].is_leaf() && nodes_[n.b].is_leaf(); }
  std::array<Index, 2> leaves_of(const PairTree::Node& n) const {
    const auto [first, second] = std::minmax(nodes_[n.a].leaf_begin, nodes_[n.b].leaf_begin);
    return {first, second};
  }
  void add(NodePairIds pair) { tree_.nodes.push_back({pair[0], pair[1]}); }
  void split(Index pair);
  void measure(std::size_t first);
  void refine();
  bool is_proven(std::size_t node) const {
    const float* own = &tree_.balls[node * centers_.size()];
    return std::any_of(own, own + centers_.size(), [](float ball) { return ball > 0; });
  }
  PairTreeResult::AtCenter at_center(Index center) const;

  const BallInput& input_;
  std::span<const ReducedCenter> centers_;
  std::span<const Hierarchy::Node> nodes_;
  PerThread<PairBalls> pair_balls_;
  PairTree tree_;
  std::priority_queue<Queued> queue_;  // pairs with a ball below max_radius
  std::vector<Index> to_split_, to_refine_;
};

void TreeBuilder::split(Index pair) {
  const auto begin = static_cast<Index>(tree_.nodes.size());
  const auto [a, b] = std::pair(tree_.nodes[pair].a, tree_.nodes[pair].b);
  const auto size = [&](Index node) { return nodes_[node].leaf_end - nodes_[node].leaf_begin; };
  if (a == b) {
    add({a + 1, a + 1});
    add({nodes_[a].right, nodes_[a].right});
    add({a + 1, nodes_[a].right});
  } else if (size(a) >= size(b)) {
    add({a + 1, b});
    add({nodes_[a].right, b});
  } else {
    add({a, b + 1});
    add({a, nodes_[b].right});
  }
  tree_.nodes[pair].begin = begin;
  tree_.nodes[pair].count = static_cast<Index>(tree_.nodes.size()) - begin;
}

// Finds the balls of the pairs from `first` on, and queues those that fall short of max_radius.
void TreeBuilder::measure(std::size_t first) {
  const std::size_t count = tree_.nodes.size(), width = centers_.size();
  tree_.balls.resize(count * width);
  parallel_for(first, count, [&](std::size_t i) {
    const NodePairIds pair{tree_.nodes[i].a, tree_.nodes[i].b};
    for (Index c = 0; c < width; ++c)
      tree_.balls[i * width + c] = round_down(pair_balls_.local().radius(pair, c, centers_[c].max_radius));
  });
  for (std::size_t i = first; i < count; ++i) {
    float share = 1;
    for (std::size_t c = 0; c < width; ++c)
      share = std::min(share, tree_.balls[i * width + c] / static_cast<float>(centers_[c].max_radius));
    if (share < 1) queue_.push({share, static_cast<Index>(i)});
  }
}

// Pairs of leaves cannot be split; their features are tested one by one.
void TreeBuilder::refine() {
  const std::size_t width = centers_.size();
  parallel_for(std::size_t{0}, to_refine_.size(), [&](std::size_t i) {
    const NodePairIds pair{tree_.nodes[to_refine_[i]].a, tree_.nodes[to_refine_[i]].b};
    for (Index c = 0; c < width; ++c) {
      float& ball = tree_.balls[to_refine_[i] * width + c];
      if (ball >= centers_[c].max_radius) continue;
      const double found = pair_balls_.local().feature_radius(pair, c, ball, centers_[c].max_radius);
      ball = std::max(ball, round_down(found));
    }
  });
}

// As finish(), but for one center alone and without all pairs of leaves that this center does not prove.
PairTreeResult::AtCenter TreeBuilder::at_center(Index center) const {
  PairTreeResult::AtCenter result;
  const std::size_t width = centers_.size();
  std::vector<float> radius(tree_.nodes.size());
  for (std::size_t i = tree_.nodes.size(); i-- > 0;) {
    const PairTree::Node& node = tree_.nodes[i];
    radius[i] = tree_.balls[i * width + center];
    if (node.count > 0) {
      const auto children = radius.begin() + node.begin;
      radius[i] = std::max(radius[i], *std::min_element(children, children + node.count));
    } else if (radius[i] == 0 && is_leaf_pair(node)) {
      radius[i] = std::numeric_limits<float>::infinity();
      result.uncertified.push_back(leaves_of(node));
    }
  }
  std::sort(result.uncertified.begin(), result.uncertified.end());
  result.radius = std::min(double{radius[0]}, centers_[center].max_radius);
  return result;
}

PairTreeResult TreeBuilder::finish() {
  PairTreeResult result;
  const std::size_t width = centers_.size();
  for (Index c = 0; c < width; ++c) result.at_center.push_back(at_center(c));
  // Children come after their parents: one sweep from the back counts them in.
  for (std::size_t i = tree_.nodes.size(); i-- > 0;) {
    const PairTree::Node& node = tree_.nodes[i];
    if (node.count == 0 && !is_proven(i) && is_leaf_pair(node)) {
      result.never_certified.push_back(leaves_of(node));
      std::fill_n(&tree_.balls[i * width], width, std::numeric_limits<float>::infinity());
    }
    for (std::size_t c = 0; c < width && node.count > 0; ++c) {
      float smallest = std::numeric_limits<float>::infinity();
      for (Index child = node.begin; child < node.begin + node.count; ++child)
        smallest = std::min(smallest, tree_.balls[child * width + c]);
      tree_.balls[i * width + c] = std::max(tree_.balls[i * width + c], smallest);
    }
  }
  std::sort(result.never_certified.begin(), result.never_certified.end());
  result.tree = std::move(tree_);
  return result;
}

}  // namespace

Result<PairTreeResult> build_pair_tree(const BallInput& input, std::span<const ReducedCenter> centers,
                                       std::size_t max_pairs, const ReducedHooks& hooks) {
  TreeBuilder builder(input, centers);
  FOLDPROOF_TRY(builder.build(max_pairs, hooks));
  return builder.finish();
}

}  // namespace foldproof::internal
