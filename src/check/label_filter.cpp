// The filter of objects and labels.

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "base/try.h"
#include "check/node_labels.h"
#include "foldproof/check.h"

namespace foldproof {
namespace {

constexpr Index kMaxLabel = 10'000;

// Which pairs of labels are tested. Labels with the same partners are one from here on.
class LabelPairs {
 public:
  LabelPairs(Index count, std::span<const std::array<Index, 2>> ignored) {
    std::vector<std::vector<bool>> rows(count, std::vector<bool>(count, true));
    for (const auto& [a, b] : ignored) rows[a][b] = rows[b][a] = false;
    std::map<std::vector<bool>, Index> classes;
    std::vector<Index> first;  // label of each class
    for (Index label = 0; label < count; ++label) {
      const auto [at, is_new] = classes.try_emplace(rows[label], static_cast<Index>(first.size()));
      if (is_new) first.push_back(label);
      class_of_.push_back(at->second);
    }
    for (const Index label : first) {
      for (const Index other : first) allows_.push_back(rows[label][other]);
    }
    classes_ = static_cast<Index>(first.size());
  }
  Index classes() const { return classes_; }
  Index class_of(Index label) const { return class_of_[label]; }
  bool operator()(Index class_a, Index class_b) const {
    return allows_[std::size_t{class_a} * classes_ + class_b];
  }

 private:
  Index classes_ = 0;
  std::vector<Index> class_of_;  // per label
  std::vector<bool> allows_;     // classes x classes
};

// The labels of the triangles around each vertex, or each edge.
class LabelsAround {
 public:
  explicit LabelsAround(std::size_t count) : set_of_(count, kNoIndex) {}
  void add(Index element, Index label) {
    if (set_of_[element] == kNoIndex) {
      set_of_[element] = label;
    } else if (set_of_[element] != label) {
      more_[element].push_back(label);
    }
  }
  // Their sets. The set of a single label has its number.
  std::vector<Index> sets(LabelSets& sets) {
    for (auto& [element, labels] : more_) {
      labels.push_back(set_of_[element]);
      set_of_[element] = sets.add(std::move(labels));
    }
    return std::move(set_of_);
  }

 private:
  std::vector<Index> set_of_;
  std::map<Index, std::vector<Index>> more_;
};

// The labels of an object.
struct ObjectLabels {
  std::shared_ptr<const Hierarchy> hierarchy;
  Index uniform = kNoIndex;  // label of all triangles, if there is only one; all else is empty then
  std::vector<Index> of_triangle, of_vertex, of_edge;  // the latter two: sets
  NodeLabels of_node;

  ObjectLabels(std::shared_ptr<const Hierarchy> of, std::vector<Index> labels, LabelSets& sets)
      : hierarchy(std::move(of)) {
    if (std::ranges::all_of(labels, [&](Index label) { return label == labels[0]; })) {
      uniform = labels[0];
      return;
    }
    of_triangle = std::move(labels);
    const Topology& topology = hierarchy->topology();
    LabelsAround vertices(topology.vertex_count()), edges(topology.edges().size());
    for (Index t = 0; t < of_triangle.size(); ++t) {
      for (const Index v : topology.triangles()[t]) vertices.add(v, of_triangle[t]);
      for (const Index e : topology.triangle_edges()[t]) {
        if (e != kNoIndex) edges.add(e, of_triangle[t]);
      }
    }
    of_vertex = vertices.sets(sets);
    of_edge = edges.sets(sets);
    of_node = NodeLabels(*hierarchy, [&](Index leaf, std::vector<Index>& out) {
      const Hierarchy::Leaf &begin = hierarchy->leaves()[leaf], &end = hierarchy->leaves()[leaf + 1];
      const auto add = [&](Index set) { out.insert(out.end(), sets[set].begin(), sets[set].end()); };
      for (Index k = begin.triangles; k < end.triangles; ++k)
        out.push_back(of_triangle[hierarchy->triangle_ids()[k]]);
      for (Index k = begin.vertices; k < end.vertices; ++k) add(of_vertex[hierarchy->vertex_ids()[k]]);
      for (Index k = begin.edges; k < end.edges; ++k) add(of_edge[hierarchy->edge_ids()[k]]);
    });
  }
};

class LabelFilter final : public PairFilter {
 public:
  LabelFilter(std::span<const Object> objects, std::span<const std::vector<Index>> labels, LabelPairs pairs)
      : pairs_(std::move(pairs)) {
    for (Index label = 0; label < pairs_.classes(); ++label) sets_.add({label});
    for (std::size_t i = 0; i < objects.size(); ++i) {
      std::vector<Index> classes;
      for (const Index label : labels[i]) classes.push_back(pairs_.class_of(label));
      objects_.emplace_back(objects[i].hierarchy(), std::move(classes), sets_);
    }
  }

  bool nodes(Index object_a, Index node_a, Index object_b, Index node_b) const override {
    const ObjectLabels &a = objects_[object_a], &b = objects_[object_b];
    if (a.uniform == kNoIndex && b.uniform == kNoIndex)
      return NodeLabels::any(a.of_node, node_a, b.of_node, node_b, pairs_);
    if (a.uniform == kNoIndex) return a.of_node.any_with(node_a, b.uniform, pairs_);
    if (b.uniform == kNoIndex) return b.of_node.any_with(node_b, a.uniform, pairs_);
    return pairs_(a.uniform, b.uniform);
  }
  bool vertex_face(Index vertex_object, Index vertex, Index face_object, Index face) const override {
    const ObjectLabels& a = objects_[vertex_object];
    return any(a.uniform == kNoIndex ? a.of_vertex[vertex] : a.uniform, kind(face_object, face));
  }
  bool edge_edge(Index object_a, const Edge& a, Index object_b, const Edge& b) const override {
    return any(edge_set(objects_[object_a], a), edge_set(objects_[object_b], b));
  }
  bool crossing(Index object_a, Index triangle_a, Index object_b, Index triangle_b) const override {
    return pairs_(kind(object_a, triangle_a), kind(object_b, triangle_b));
  }
  Index kind(Index object, Index triangle) const override {
    const ObjectLabels& labels = objects_[object];
    return labels.uniform == kNoIndex ? labels.of_triangle[triangle] : labels.uniform;
  }

 private:
  // Of two sets; that of a single label has its number.
  bool any(Index set_a, Index set_b) const {
    if (is_single(set_a) && is_single(set_b)) return pairs_(set_a, set_b);
    return NodeLabels::any(std::span(sets_[set_a]), std::span(sets_[set_b]), pairs_);
  }
  bool is_single(Index set) const { return set < pairs_.classes(); }
  // Only an edge between two borders needs a search.
  Index edge_set(const ObjectLabels& labels, const Edge& edge) const {
    if (labels.uniform != kNoIndex) return labels.uniform;
    for (const Index v : edge) {
      if (is_single(labels.of_vertex[v])) return labels.of_vertex[v];
    }
    const auto edges = labels.hierarchy->topology().edges();
    return labels.of_edge[std::ranges::lower_bound(edges, edge) - edges.begin()];
  }

  LabelPairs pairs_;
  LabelSets sets_;
  std::vector<ObjectLabels> objects_;
};

Result<void> check_label(const std::string& where, Index label) {
  if (label <= kMaxLabel) return {};
  return fail(ErrorCode::LimitExceeded, where, fmt::format("is {}", label),
              fmt::format("number labels from 0 to at most {}", kMaxLabel));
}

}  // namespace

Result<std::shared_ptr<const PairFilter>> ignore_labels(std::span<const Object> objects,
                                                        std::span<const std::vector<Index>> labels,
                                                        std::span<const std::array<Index, 2>> ignored) {
  if (labels.size() != objects.size()) {
    return fail(ErrorCode::InvalidArgument, "labels",
                fmt::format("are of {} objects instead of {}", labels.size(), objects.size()),
                "give labels for each object");
  }
  Index count = 0;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const std::size_t triangles = objects[i].hierarchy()->topology().triangles().size();
    if (labels[i].size() != 1 && labels[i].size() != triangles) {
      return fail(ErrorCode::InvalidArgument, fmt::format("labels of object {}", i),
                  fmt::format("are {} for {} triangles", labels[i].size(), triangles),
                  "give one per triangle, or a single one");
    }
    for (const Index label : labels[i]) {
      FOLDPROOF_TRY(check_label(fmt::format("a label of object {}", i), label));
      count = std::max(count, label + 1);
    }
  }
  for (const auto& pair : ignored) {
    for (const Index label : pair) {
      FOLDPROOF_TRY(check_label("an ignored label", label));
      count = std::max(count, label + 1);
    }
  }
  return std::make_shared<const LabelFilter>(objects, labels, LabelPairs(count, ignored));
}

}  // namespace foldproof
