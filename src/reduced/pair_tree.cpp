#include "reduced/pair_tree.h"

#include <algorithm>
#include <queue>

#include "base/parallel.h"

namespace foldproof {
namespace {

// Pairs that are split together; a constant, so that the tree does not depend on the number of threads.
constexpr std::size_t kBatch = 64;

// Bounds the pairs of leaves that are looked at feature by feature; the worst come first.
constexpr std::size_t kRefinedPerLeaf = 2;

// What some centre has no ball for is taken apart beyond the budget, up to so many times: it would make that
// centre's radius zero.
constexpr std::size_t kUrgentBudgets = 4;

class Grower {
 public:
  Grower(const BallInput& input, std::span<const ReducedCentre> centres)
      : input_(input),
        centres_(centres),
        nodes_(input.motion.hierarchy()->nodes()),
        makers_([&] { return PairBalls(input); }) {
    tree_.centres = static_cast<Index>(centres.size());
  }

  Result<void> grow(std::size_t most_pairs, const ReducedHooks& hooks) {
    const std::size_t most_refined = kRefinedPerLeaf * std::size_t{input_.motion.hierarchy()->leaf_count()};
    add({0, 0});
    measure(0);
    std::size_t refined = 0;
    while (!open_.empty()) {
      const bool urgent = open_.top().share == 0 && tree_.nodes.size() < kUrgentBudgets * most_pairs;
      const bool may_split = urgent || tree_.nodes.size() < most_pairs;
      const bool may_refine = urgent || refined < most_refined;
      if (!may_split && !may_refine) break;
      if (hooks.cancel != nullptr && *hooks.cancel)
        return fail("cancelled", "the work was ended", "start again");
      if (hooks.progress)
        hooks.progress(std::min(1.0, static_cast<double>(tree_.nodes.size() + refined) /
                                         static_cast<double>(most_pairs + most_refined)));
      batch_.clear();
      refined_.clear();
      while (!open_.empty() && batch_.size() + refined_.size() < kBatch) {
        const Index pair = open_.top().pair;
        open_.pop();
        (is_leaf_pair(tree_.nodes[pair]) ? refined_ : batch_).push_back(pair);
      }
      const std::size_t first = tree_.nodes.size();
      if (may_split) {
        for (const Index pair : batch_) split(pair);
        measure(first);
      }
      if (may_refine) refine();
      refined += refined_.size();
    }
    return {};
  }

  PairTreeResult finish();

 private:
  struct Open {
    float share;  // of what is asked for
    Index pair;
    bool operator<(const Open& other) const {  // the smallest share on top, then the oldest
      return share != other.share ? share > other.share : pair > other.pair;
    }
  };
  using Pairs = std::vector<std::array<Index, 2>>;

  bool is_leaf_pair(const PairTree::Node& n) const { return nodes_[n.a].is_leaf() && nodes_[n.b].is_leaf(); }
  std::array<Index, 2> leaves_of(const PairTree::Node& n) const {
    return {std::minmax(nodes_[n.a].leaf_begin, nodes_[n.b].leaf_begin).first,
            std::minmax(nodes_[n.a].leaf_begin, nodes_[n.b].leaf_begin).second};
  }
  void add(NodePairIds pair) { tree_.nodes.push_back({pair[0], pair[1]}); }
  void split(Index pair);
  void measure(std::size_t first);
  void refine();
  bool is_proven(std::size_t node) const {
    const float* own = &tree_.balls[node * centres_.size()];
    return std::any_of(own, own + centres_.size(), [](float ball) { return ball > 0; });
  }
  void collect(const std::vector<float>& own, Index centre, PairTreeResult::OfCentre& out) const;

  const BallInput& input_;
  std::span<const ReducedCentre> centres_;
  std::span<const Hierarchy::Node> nodes_;
  PerThread<PairBalls> makers_;
  PairTree tree_;
  std::priority_queue<Open> open_;
  std::vector<Index> batch_, refined_;  // to be split, to be looked at feature by feature
};

void Grower::split(Index pair) {
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

// Finds the balls of the pairs from `first` on, and puts up for splitting what they leave to ask for.
void Grower::measure(std::size_t first) {
  const std::size_t count = tree_.nodes.size(), width = centres_.size();
  tree_.balls.resize(count * width);
  parallel_for(first, count, [&](std::size_t i) {
    const NodePairIds pair{tree_.nodes[i].a, tree_.nodes[i].b};
    for (Index c = 0; c < width; ++c)
      tree_.balls[i * width + c] = round_down(makers_.local().radius(pair, c, centres_[c].reach));
  });
  for (std::size_t i = first; i < count; ++i) {
    float share = 1;
    for (std::size_t c = 0; c < width; ++c)
      share = std::min(share, tree_.balls[i * width + c] / static_cast<float>(centres_[c].reach));
    if (share < 1) open_.push({share, static_cast<Index>(i)});
  }
}

// Leaf pairs have nothing below them but their features.
void Grower::refine() {
  const std::size_t width = centres_.size();
  parallel_for(std::size_t{0}, refined_.size(), [&](std::size_t i) {
    const NodePairIds pair{tree_.nodes[refined_[i]].a, tree_.nodes[refined_[i]].b};
    for (Index c = 0; c < width; ++c) {
      float& ball = tree_.balls[refined_[i] * width + c];
      if (ball >= centres_[c].reach) continue;
      const double found = makers_.local().feature_radius(pair, c, ball, centres_[c].reach);
      ball = std::max(ball, round_down(found));
    }
  });
}

// The same over the tree for one centre alone, with all that this centre does not prove left out.
void Grower::collect(const std::vector<float>& own, Index centre, PairTreeResult::OfCentre& out) const {
  const std::size_t width = centres_.size();
  std::vector<float> radius(tree_.nodes.size());
  for (std::size_t i = tree_.nodes.size(); i-- > 0;) {
    const PairTree::Node& node = tree_.nodes[i];
    radius[i] = own[i * width + centre];
    if (node.count > 0) {
      const auto below = radius.begin() + node.begin;
      radius[i] = std::max(radius[i], *std::min_element(below, below + node.count));
    } else if (radius[i] == 0 && is_leaf_pair(node)) {
      radius[i] = std::numeric_limits<float>::infinity();
      out.left_out.push_back(leaves_of(node));
    }
  }
  std::sort(out.left_out.begin(), out.left_out.end());
  out.radius = std::min(double{radius[0]}, centres_[centre].reach);
}

PairTreeResult Grower::finish() {
  PairTreeResult result;
  const std::size_t width = centres_.size();
  result.of_centre.resize(width);
  for (Index c = 0; c < width; ++c) collect(tree_.balls, c, result.of_centre[c]);
  // Children stand behind their parents: one sweep from the back counts them in.
  std::vector<bool> proven(tree_.nodes.size());
  for (std::size_t i = 0; i < proven.size(); ++i) proven[i] = is_proven(i);
  for (std::size_t i = tree_.nodes.size(); i-- > 0;) {
    const PairTree::Node& node = tree_.nodes[i];
    if (node.count == 0 && !proven[i] && is_leaf_pair(node)) {
      result.always_open.push_back(leaves_of(node));
      std::fill_n(&tree_.balls[i * width], width, std::numeric_limits<float>::infinity());
    }
    for (std::size_t c = 0; c < width && node.count > 0; ++c) {
      float least = std::numeric_limits<float>::infinity();
      for (Index child = node.begin; child < node.begin + node.count; ++child)
        least = std::min(least, tree_.balls[child * width + c]);
      tree_.balls[i * width + c] = std::max(tree_.balls[i * width + c], least);
    }
  }
  std::sort(result.always_open.begin(), result.always_open.end());
  result.tree = std::move(tree_);
  return result;
}

}  // namespace

Result<PairTreeResult> grow_pair_tree(const BallInput& input, std::span<const ReducedCentre> centres,
                                      std::size_t most_pairs, const ReducedHooks& hooks) {
  Grower grower(input, centres);
  if (const auto done = grower.grow(most_pairs, hooks); !done) return tl::unexpected(done.error());
  return grower.finish();
}

}  // namespace foldproof
