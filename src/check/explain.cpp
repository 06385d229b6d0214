// Culling::explain: which pairs certificates proved, and why others were tested.

#include <algorithm>
#include <limits>
#include <span>

#include "base/parallel.h"
#include "check/culling.h"

namespace foldproof::internal {
namespace {

Reason reason_of_slot(const ChartCache& charts, SlotIndex slot) {
  if (charts.has_charts(slot)) return Reason::TestFailed;
  switch (charts.last_outcome(slot)) {
    case ChartOutcome::TooCurved:
      return Reason::TooCurved;
    case ChartOutcome::Overlapping:
      return Reason::Overlapping;
    case ChartOutcome::Made:
    case ChartOutcome::TooLarge:
      break;
  }
  return Reason::NotBuilt;
}

// Whether a node with both leaves below it has charts.
bool ancestor_has_charts(const ChartCache& charts, LeafPair leaves) {
  const auto nodes = charts.slots().hierarchy()->nodes();
  const auto [first, last] = std::minmax(leaves.a, leaves.b);
  for (Index node = 0;;) {
    if (charts.has_charts(SlotIndex(charts.slots().of_node(node)))) return true;
    if (nodes[node].is_leaf()) return false;
    const Index middle = nodes[nodes[node].right].leaf_begin;
    if (first < middle && middle <= last) return false;
    node = first < middle ? node + 1 : nodes[node].right;
  }
}

Index depth_of(const Hierarchy& h, Index node) {
  Index depth = 0;
  for (Index above = 0; above != node; ++depth)
    above = node < h.nodes()[above].right ? above + 1 : h.nodes()[above].right;
  return depth;
}

// Raises the reasons of a leaf's triangles to at least `reason`.
void raise_reasons(std::span<Reason> reasons, const Hierarchy& h, Index leaf, Reason reason) {
  for (Index t = h.leaves()[leaf].triangles; t < h.leaves()[leaf + 1].triangles; ++t) {
    Reason& old = reasons[h.triangle_ids()[t]];
    old = std::max(old, reason);
  }
}

}  // namespace

Reason Culling::reason_of(const TraversalTask& task, LeafPair leaves) const {
  const Reason no_plane = tests_planes_ ? Reason::NearOther : Reason::NotBuilt;
  if (task.object_a != task.object_b) return no_plane;
  const auto [a, b] = leaves;
  const ChartCache& charts = *charts_[task.object_a];
  const SlotIndex slot(a == b ? charts.slots().of_node(task.traversal.a->leaf_node(a))
                              : charts.slots().of_leaves(a, b));
  if (slot == kNoIndex) return no_plane;
  const Reason reason = reason_of_slot(charts, slot);
  return reason == Reason::NotBuilt && ancestor_has_charts(charts, leaves) ? Reason::TestFailed : reason;
}

void Culling::explain(const StepMotion& motion, std::span<const TraversalTask> tasks,
                      std::span<const TaskLeaves> leaf_pairs, Explanation& out) {
  out.objects.resize(motion.size());
  for (Index i = 0; i < motion.size(); ++i) {
    const std::size_t triangles = motion.hierarchy(i).topology().triangles().size();
    out.objects[i].level.assign(triangles, -1);
    out.objects[i].margin.assign(triangles, 0);
    out.objects[i].reason.assign(triangles, certificates_ ? Reason::Certified : Reason::Off);
  }
  // Proven nodes have no triangle in common.
  parallel_for(std::size_t{0}, proven_nodes_.size(), [&](std::size_t k) {
    const auto& [object, node, proof] = proven_nodes_[k];
    const Hierarchy& h = motion.hierarchy(object);
    const Index level = depth_of(h, node);
    const auto capped_level =
        static_cast<std::int8_t>(std::min<Index>(level, std::numeric_limits<std::int8_t>::max()));
    const double margin =
        charts_[object]->margin(proof, motion.bvhs()[object].vertices, locals_.local().tester.scratch);
    const Index begin = h.leaves()[h.nodes()[node].leaf_begin].triangles;
    const Index end = h.leaves()[h.nodes()[node].leaf_end].triangles;
    for (Index t = begin; t < end; ++t) {
      out.objects[object].level[h.triangle_ids()[t]] = capped_level;
      out.objects[object].margin[h.triangle_ids()[t]] = static_cast<float>(std::clamp(margin, 0.0, 1.0));
    }
  });
  out.leaf_pairs = {};
  for (const TaskLeaves& pair : leaf_pairs) {
    const TraversalTask& task = tasks[pair.task];
    const Reason reason = certificates_ ? reason_of(task, pair.leaves) : Reason::Off;
    ++out.leaf_pairs[static_cast<std::size_t>(reason)];
    raise_reasons(out.objects[task.object_a].reason, motion.hierarchy(task.object_a), pair.leaves.a, reason);
    raise_reasons(out.objects[task.object_b].reason, motion.hierarchy(task.object_b), pair.leaves.b, reason);
  }
}

}  // namespace foldproof::internal
