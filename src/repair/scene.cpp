#include "repair/scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/try.h"

namespace foldproof {
namespace {

Lists neighbors_of(Index vertex_count, std::span<const Edge> edges) {
  Lists lists;
  lists.begin.assign(vertex_count + std::size_t{1}, 0);
  for (const Edge& e : edges) {
    for (const Index v : e) ++lists.begin[v + std::size_t{1}];
  }
  for (std::size_t v = 0; v < vertex_count; ++v) lists.begin[v + 1] += lists.begin[v];
  lists.items.resize(2 * edges.size());
  auto next = lists.begin;
  for (const Edge& e : edges) {
    lists.items[next[e[0]]++] = e[1];
    lists.items[next[e[1]]++] = e[0];
  }
  return lists;
}

// Whether each vertex of an object may move, those in no triangle not.
std::vector<std::uint8_t> movable_of(const RepairObject& object) {
  const Topology& topology = object.object.hierarchy()->topology();
  std::vector<std::uint8_t> movable(topology.vertex_count(), 0);
  for (const Triangle& t : topology.triangles()) {
    for (const Index v : t) movable[v] = object.movable.empty() || object.movable[v] != 0;
  }
  return movable;
}

class RepairFilter final : public PairFilter {
 public:
  RepairFilter(const RepairScene& scene, std::shared_ptr<const PairFilter> inner, std::vector<Index> zone)
      : inner_(std::move(inner)),
        triangles_(scene.triangles().begin(), scene.triangles().end()),
        movable_(scene.movable().begin(), scene.movable().end()),
        zone_(std::move(zone)) {
    for (Index i = 0; i <= scene.objects().size(); ++i) begin_.push_back(scene.begin(i));
    for (Index i = 0; i < scene.objects().size(); ++i) add_nodes(*scene.objects()[i].hierarchy(), begin_[i]);
  }
  bool nodes(Index object_a, Index node_a, Index object_b, Index node_b) const override {
    return (nodes_[object_a][node_a] != 0 || nodes_[object_b][node_b] != 0) &&
           (inner_ == nullptr || inner_->nodes(object_a, node_a, object_b, node_b));
  }
  bool vertex_face(Index vertex_object, Index vertex, Index face_object, Index face) const override {
    const Triangle& t = triangle(face_object, face);
    return tests({begin_[vertex_object].vertices + vertex, t[0], t[1], t[2]}) &&
           (inner_ == nullptr || inner_->vertex_face(vertex_object, vertex, face_object, face));
  }
  bool edge_edge(Index object_a, const Edge& a, Index object_b, const Edge& b) const override {
    const Index va = begin_[object_a].vertices, vb = begin_[object_b].vertices;
    return tests({va + a[0], va + a[1], vb + b[0], vb + b[1]}) &&
           (inner_ == nullptr || inner_->edge_edge(object_a, a, object_b, b));
  }
  bool crossing(Index object_a, Index triangle_a, Index object_b, Index triangle_b) const override {
    const Triangle &a = triangle(object_a, triangle_a), &b = triangle(object_b, triangle_b);
    return tests({a[0], a[1], a[2], b[0], b[1], b[2]}) &&
           (inner_ == nullptr || inner_->crossing(object_a, triangle_a, object_b, triangle_b));
  }
  // Without another filter, answers depend on vertices alone.
  Index kind(Index object, Index triangle) const override {
    return inner_ == nullptr ? 0 : inner_->kind(object, triangle);
  }

 private:
  // Whether anything below each node may move.
  void add_nodes(const Hierarchy& hierarchy, const RepairSceneObject& begin) {
    const auto nodes = hierarchy.nodes();
    auto& any = nodes_.emplace_back(nodes.size(), 0);
    for (std::size_t n = nodes.size(); n-- > 0;) {
      if (!nodes[n].is_leaf()) {
        any[n] = any[n + 1] | any[nodes[n].right];
        continue;
      }
      const auto leaves = hierarchy.leaves();
      for (Index k = leaves[nodes[n].leaf_begin].triangles; k < leaves[nodes[n].leaf_end].triangles; ++k) {
        for (const Index v : triangles_[begin.triangles + std::size_t{hierarchy.triangle_ids()[k]}])
          any[n] |= movable_[v];
      }
    }
  }
  const Triangle& triangle(Index object, Index triangle) const {
    return triangles_[begin_[object].triangles + std::size_t{triangle}];
  }
  // One of the vertices may move, and they are not all in one zone.
  bool tests(std::initializer_list<Index> vertices) const {
    if (std::ranges::none_of(vertices, [&](Index v) { return movable_[v] != 0; })) return false;
    const Index zone = zone_.empty() ? 0 : zone_[*vertices.begin()];
    return zone == 0 || !std::ranges::all_of(vertices, [&](Index v) { return zone_[v] == zone; });
  }

  std::shared_ptr<const PairFilter> inner_;
  std::vector<Triangle> triangles_;
  std::vector<std::uint8_t> movable_;
  std::vector<Index> zone_;
  std::vector<RepairSceneObject> begin_;
  std::vector<std::vector<std::uint8_t>> nodes_;
};

Result<void> check_object(const RepairObject& object, std::size_t i) {
  const Index count = object.object.hierarchy()->topology().vertex_count();
  const auto refuse = [&](const char* what, std::size_t size) {
    return fail(ErrorCode::InvalidArgument, fmt::format("object {}", i),
                fmt::format("{} is for {} vertices", what, size),
                fmt::format("give a number for each of the {}", count));
  };
  if (!object.movable.empty() && object.movable.size() != count)
    return refuse("what may move", object.movable.size());
  if (!object.merged.empty() && object.merged.size() != count) return refuse("merged", object.merged.size());
  if (std::ranges::any_of(object.merged, [&](Index v) { return v >= count; }))
    return fail(ErrorCode::InvalidMesh, fmt::format("object {}", i), "merged names a vertex beyond its last",
                "give the reader's MotionInfo::merged");
  return {};
}

}  // namespace

Result<RepairScene> RepairScene::make(const RepairInput& input) {
  RepairScene scene;
  std::size_t vertices = 0, triangles = 0;
  for (std::size_t i = 0; i < input.objects.size(); ++i) {
    const RepairObject& object = input.objects[i];
    FOLDPROOF_TRY(check_object(object, i));
    const Topology& topology = object.object.hierarchy()->topology();
    const auto first = static_cast<Index>(vertices);
    scene.begin_.push_back({first, static_cast<Index>(triangles)});
    vertices += topology.vertex_count();
    triangles += topology.triangles().size();
    if (vertices >= kNoIndex || triangles > Topology::kMaxTriangles)
      return fail(ErrorCode::LimitExceeded, "the objects", "have too many vertices or triangles together",
                  "repair fewer at once");
    for (const Triangle& t : topology.triangles())
      scene.triangles_.push_back({t[0] + first, t[1] + first, t[2] + first});
    for (const Edge& e : topology.edges()) scene.edges_.push_back({e[0] + first, e[1] + first});
    for (Index v = 0; v < object.merged.size(); ++v) {
      if (object.merged[v] != v) scene.copies_.emplace_back(first + v, first + object.merged[v]);
    }
    for (const std::uint8_t m : movable_of(object)) scene.movable_.push_back(m);
    scene.objects_.push_back(object.object);
  }
  scene.begin_.push_back({static_cast<Index>(vertices), static_cast<Index>(triangles)});
  if (std::ranges::none_of(scene.movable_, [](std::uint8_t m) { return m != 0; }))
    return fail(ErrorCode::InvalidArgument, "repair", "nothing may move", "leave an object free to move");
  scene.neighbors_ = neighbors_of(scene.vertex_count(), scene.edges_);
  scene.inner_filter_ = input.filter;
  scene.filter_ = scene.filter_with({});
  return scene;
}

std::vector<const Topology*> RepairScene::topologies() const {
  std::vector<const Topology*> out;
  for (const Object& object : objects_) out.push_back(&object.hierarchy()->topology());
  return out;
}

Positions RepairScene::positions(std::span<const double> x,
                                 std::vector<std::span<const double>>& views) const {
  views.clear();
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    const std::size_t begin = begin_[i].vertices, end = begin_[i + 1].vertices;
    views.push_back(x.subspan(3 * begin, 3 * (end - begin)));
  }
  return views;
}

Index RepairScene::object_of_vertex(Index v) const {
  Index object = 0;
  while (v >= begin_[object + std::size_t{1}].vertices) ++object;
  return object;
}

void RepairScene::move_copies(std::span<double> x) const {
  for (const auto& [copy, of] : copies_) put(x, copy, at(x, of));
}

FeaturePair RepairScene::pair_of(const VertexFaceCollision& c) const {
  const Triangle& t = triangles_[begin_[c.face_object].triangles + std::size_t{c.face}];
  return {false, {begin_[c.vertex_object].vertices + c.vertex, t[0], t[1], t[2]}};
}

FeaturePair RepairScene::pair_of(const EdgeEdgeCollision& c) const {
  const Index a = begin_[c.object_a].vertices, b = begin_[c.object_b].vertices;
  return {true, {a + c.a[0], a + c.a[1], b + c.b[0], b + c.b[1]}};
}

std::shared_ptr<const PairFilter> RepairScene::filter_with(std::vector<Index> zone) const {
  return std::make_shared<RepairFilter>(*this, inner_filter_, std::move(zone));
}

}  // namespace foldproof
