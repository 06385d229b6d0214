// What certificates did in a traversal, and why they did not do more.

#include <algorithm>
#include <limits>
#include <span>

#include "base/parallel.h"
#include "check/culling.h"

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

Reason Culling::reason_of(const TraversalTask& task, NodePair leaves) const {
  const Reason no_plane = ask_for_planes_ ? Reason::NearOther : Reason::NotDrawn;
  if (task.object_a != task.object_b) return no_plane;
  const auto [a, b] = leaves;
  const ChartBook& book = *books_[task.object_a];
  const Index slot =
      a == b ? book.slots().of_node(task.traversal.a->leaf_node(a)) : book.slots().of_leaves(a, b);
  if (slot == kNoIndex) return no_plane;
  const Reason reason = reason_of_slot(book, slot);
  return reason == Reason::NotDrawn && has_charts_around(book, leaves) ? Reason::TestFailed : reason;
}

void Culling::explain(const StepMotion& motion, std::span<const TraversalTask> tasks,
                      std::span<const LeafPairRef> leaf_pairs, Explanation& out) {
  out.objects.resize(motion.size());
  for (Index i = 0; i < motion.size(); ++i) {
    const std::size_t triangles = motion.hierarchy(i).topology().triangles().size();
    out.objects[i].level.assign(triangles, -1);
    out.objects[i].margin.assign(triangles, 0);
    out.objects[i].reason.assign(triangles, certificates_ ? Reason::Certified : Reason::Off);
  }
  // Proven nodes share no triangle.
  parallel_for(std::size_t{0}, proven_nodes_.size(), [&](std::size_t k) {
    const auto& [object, node, level, proof] = proven_nodes_[k];
    const Hierarchy& h = motion.hierarchy(object);
    const auto shown =
        static_cast<std::int8_t>(std::min<Index>(level, std::numeric_limits<std::int8_t>::max()));
    const double margin =
        books_[object]->margin(proof, motion.trees()[object].vertices, locals_.local().tester.scratch);
    const Index begin = h.leaves()[h.nodes()[node].leaf_begin].triangles;
    const Index end = h.leaves()[h.nodes()[node].leaf_end].triangles;
    for (Index t = begin; t < end; ++t) {
      out.objects[object].level[h.triangle_ids()[t]] = shown;
      out.objects[object].margin[h.triangle_ids()[t]] = static_cast<float>(std::clamp(margin, 0.0, 1.0));
    }
  });
  out.leaf_pairs = {};
  for (const LeafPairRef& pair : leaf_pairs) {
    const TraversalTask& task = tasks[pair.task];
    const Reason reason = certificates_ ? reason_of(task, pair.leaves) : Reason::Off;
    ++out.leaf_pairs[static_cast<std::size_t>(reason)];
    at_least(out.objects[task.object_a].reason, motion.hierarchy(task.object_a), pair.leaves.a, reason);
    at_least(out.objects[task.object_b].reason, motion.hierarchy(task.object_b), pair.leaves.b, reason);
  }
}

}  // namespace foldproof
