#include "repair/scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/try.h"
#include "filters/by_vertices.h"
#include "foldproof/filters.h"

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
  std::vector<std::vector<std::uint8_t>> fixed;
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
    auto& fixed_here = fixed.emplace_back();
    for (const std::uint8_t m : movable_of(object)) {
      scene.movable_.push_back(m);
      fixed_here.push_back(m == 0);
    }
    scene.objects_.push_back(object.object);
    scene.names_.push_back(object.name.empty() ? fmt::format("object {}", i) : object.name);
  }
  scene.begin_.push_back({static_cast<Index>(vertices), static_cast<Index>(triangles)});
  if (std::ranges::none_of(scene.movable_, [](std::uint8_t m) { return m != 0; }))
    return fail(ErrorCode::InvalidArgument, "repair", "nothing may move", "leave an object free to move");
  scene.neighbors_ = neighbors_of(scene.vertex_count(), scene.edges_);
  scene.parts_ = input.parts;
  scene.given_filter_ = input.filter;
  scene.filter_ = FOLDPROOF_TRY(ignore_fixed(scene.objects_, fixed));
  const auto is_fixed = [&](Index v) { return !scene.is_movable(v); };
  if (std::ranges::any_of(scene.triangles_,
                          [&](const Triangle& t) { return std::ranges::any_of(t, is_fixed); }))
    scene.fixed_filter_ = ignore_all_but_fixed(scene.objects_, fixed);
  if (input.filter == nullptr) return scene;
  for (auto* filter : {&scene.filter_, &scene.fixed_filter_}) {
    if (*filter != nullptr) *filter = ignore_all({*filter, input.filter});
  }
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
  const Triangle& t = triangle(c.face_object, c.face);
  return {false, {begin_[c.vertex_object].vertices + c.vertex, t[0], t[1], t[2]}};
}

FeaturePair RepairScene::pair_of(const EdgeEdgeCollision& c) const {
  const Index a = begin_[c.object_a].vertices, b = begin_[c.object_b].vertices;
  return {true, {a + c.a[0], a + c.a[1], b + c.b[0], b + c.b[1]}};
}

void RepairScene::pairs_of(const StepResult& step, std::vector<FeaturePair>& out) const {
  for (const auto& c : step.vertex_face) out.push_back(pair_of(c));
  for (const auto& c : step.edge_edge) out.push_back(pair_of(c));
}

Result<const StepResult*> Prover::check(std::span<const double> x0, std::span<const double> x1) {
  FOLDPROOF_TRY(checker_.check(scene_->positions(x0, from_), scene_->positions(x1, to_), settings_, step_));
  return &step_;
}

Result<void> Prover::find_near(std::span<const double> x0, std::span<const double> x1, double distance,
                               std::vector<FeaturePair>& out) {
  const double thickness = std::exchange(settings_.thickness, distance);
  const auto near = check(x0, x1);
  settings_.thickness = thickness;
  scene_->pairs_of(*FOLDPROOF_TRY(near), out);
  return {};
}

Result<const StaticResult*> Prover::check_pose(std::span<const double> x) {
  FOLDPROOF_TRY(checker_.check_static(scene_->positions(x, from_), settings_, pose_));
  return &pose_;
}

Result<bool> Prover::is_free(std::span<const double> x) {
  if (!FOLDPROOF_TRY(check_pose(x))->clean()) return false;
  return settings_.thickness == 0 || FOLDPROOF_TRY(check(x, x))->clean();
}

}  // namespace foldproof
