// What certificates did in a traversal, and why they did not do more.

#include <algorithm>
#include <atomic>
#include <limits>
#include <span>

#include "base/parallel.h"
#include "query/scene.h"

namespace foldproof {
namespace {

Reason reason_of_slot(const ChartBook& book, Index slot) {
  if (book.has_charts(slot)) return Reason::TestFailed;
  switch (book.last_drawing(slot)) {
    case ChartOutcome::TooCurved:
      return Reason::TooCurved;
    case ChartOutcome::Tangled:
      return Reason::Tangled;
    case ChartOutcome::Made:
    case ChartOutcome::TooLarge:
      break;
  }
  return Reason::NotDrawn;
}

// Whether a node with both leaves below it has charts.
bool has_charts_around(const ChartBook& book, NodePair leaves) {
  const auto nodes = book.slots().hierarchy()->nodes();
  const auto [first, last] = std::minmax(leaves.a, leaves.b);
  for (Index node = 0;;) {
    if (book.has_charts(book.slots().of_node(node))) return true;
    if (nodes[node].is_leaf()) return false;
    const Index middle = nodes[nodes[node].right].leaf_begin;
    if (first < middle && middle <= last) return false;
    node = first < middle ? node + 1 : nodes[node].right;
  }
}

void at_least(std::span<Reason> reasons, const Hierarchy& h, Index leaf, Reason reason) {
  for (Index t = h.leaves()[leaf].triangles; t < h.leaves()[leaf + 1].triangles; ++t) {
    Reason& now = reasons[h.triangle_ids()[t]];
    now = std::max(now, reason);
  }
}

}  // namespace

// The pairs of leaves that there are when certificates are off.
std::uint64_t Scene::count_near_leaves(const StepSettings& settings, double distance) {
  const float margin = separation_margin(frame_, distance);
  std::atomic<std::uint64_t> count{0};
  const auto follow = [&](const Traversal& traversal, NodePair start) {
    Local& local = locals_.local();
    local.counted.leaf_pairs.clear();
    foldproof::traverse(traversal, start, local.stack, local.counted);
    count += local.counted.leaf_pairs.size();
  };
  for (Index a = 0; settings.within && a < trees_.size(); ++a) {
    const auto nodes = hierarchy(a).nodes();
    count += hierarchy(a).leaf_count();
    const Traversal traversal{&trees_[a], &trees_[a], margin};
    parallel_for(Index{0}, static_cast<Index>(nodes.size()), [&](Index n) {
      if (!nodes[n].is_leaf()) follow(traversal, {n + 1, nodes[n].right});
    });
  }
  if (settings.between) {
    const auto near = near_objects(margin);
    parallel_for(std::size_t{0}, near.size(), [&](std::size_t k) {
      follow({&trees_[near[k][0]], &trees_[near[k][1]], margin}, {0, 0});
    });
  }
  return count;
}

Reason Scene::reason_of(const LeafPairRef& pair) const {
  const TraversalTask& task = tasks_[pair.task];
  const Reason no_plane = ask_for_planes_ ? Reason::NearOther : Reason::NotDrawn;
  if (task.object_a != task.object_b) return no_plane;
  const auto [a, b] = pair.leaves;
  const ChartBook& book = *books_[task.object_a];
  const Index slot =
      a == b ? book.slots().of_node(trees_[task.object_a].leaf_node(a)) : book.slots().of_leaves(a, b);
  if (slot == kNoIndex) return no_plane;
  const Reason reason = reason_of_slot(book, slot);
  return reason == Reason::NotDrawn && has_charts_around(book, pair.leaves) ? Reason::TestFailed : reason;
}

void Scene::explain(const StepSettings& settings, double distance, Explanation& out) {
  out.objects.resize(trees_.size());
  for (Index i = 0; i < trees_.size(); ++i) {
    const std::size_t triangles = hierarchy(i).topology().triangles().size();
    out.objects[i].level.assign(triangles, -1);
    out.objects[i].margin.assign(triangles, 0);
    out.objects[i].reason.assign(triangles, settings.certificates ? Reason::Certified : Reason::Off);
  }
  // Proven nodes share no triangle.
  parallel_for(std::size_t{0}, proven_nodes_.size(), [&](std::size_t k) {
    const auto& [object, node, level, proof] = proven_nodes_[k];
    const Hierarchy& h = hierarchy(object);
    const auto shown =
        static_cast<std::int8_t>(std::min<Index>(level, std::numeric_limits<std::int8_t>::max()));
    const double margin =
        books_[object]->margin(proof, trees_[object].vertices, locals_.local().tester.scratch);
    const Index begin = h.leaves()[h.nodes()[node].leaf_begin].triangles;
    const Index end = h.leaves()[h.nodes()[node].leaf_end].triangles;
    for (Index t = begin; t < end; ++t) {
      out.objects[object].level[h.triangle_ids()[t]] = shown;
      out.objects[object].margin[h.triangle_ids()[t]] = static_cast<float>(std::clamp(margin, 0.0, 1.0));
    }
  });
  out.leaf_pairs = {};
  for (const LeafPairRef& pair : leaf_pairs_) {
    const Reason reason = settings.certificates ? reason_of(pair) : Reason::Off;
    ++out.leaf_pairs[static_cast<std::size_t>(reason)];
    const TraversalTask& task = tasks_[pair.task];
    at_least(out.objects[task.object_a].reason, hierarchy(task.object_a), pair.leaves.a, reason);
    at_least(out.objects[task.object_b].reason, hierarchy(task.object_b), pair.leaves.b, reason);
  }
  if (!settings.certificates) return;  // everything was tested
  out.leaf_pairs[static_cast<std::size_t>(Reason::Certified)] =
      count_near_leaves(settings, distance) - leaf_pairs_.size();
}

}  // namespace foldproof
