/// Embree: rtcCollide on hierarchies that are rebuilt or refitted each step. Six variants, for which is
/// fastest differs from motion to motion: rebuilt with Morton codes or with the surface area heuristic, or
/// refitted; one hierarchy per kind of feature, or one over the triangles whose pairs are then split into
/// pairs of features.
#include <embree3/rtcore.h>

#include <memory>
#include <optional>

#include "competitor.h"
#include "swept_boxes.h"

namespace foldproof::bench {
namespace {

struct Release {
  void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
  void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
};
using Device = std::unique_ptr<RTCDeviceTy, Release>;
using Scene = std::unique_ptr<RTCSceneTy, Release>;

RTCBounds rtc_bounds(const Box& box) {
  return {box.lo[0], box.lo[1], box.lo[2], 0, box.hi[0], box.hi[1], box.hi[2], 0};
}

/// How hierarchies are made in each step. Embree refits a geometry's only in scenes of low quality.
struct Build {
  RTCBuildQuality scene, geometry;
};
constexpr Build kMorton{RTC_BUILD_QUALITY_LOW, RTC_BUILD_QUALITY_LOW};
constexpr Build kSah{RTC_BUILD_QUALITY_MEDIUM, RTC_BUILD_QUALITY_MEDIUM};
constexpr Build kRefit{RTC_BUILD_QUALITY_LOW, RTC_BUILD_QUALITY_REFIT};

/// A scene with one user geometry whose primitive i has the box that `bounds` gives.
class BoxScene {
 public:
  BoxScene(RTCDevice device, Index count, const Build& build, RTCBoundsFunction bounds, void* user)
      : scene_(rtcNewScene(device)) {
    rtcSetSceneFlags(scene_.get(), RTC_SCENE_FLAG_DYNAMIC);
    rtcSetSceneBuildQuality(scene_.get(), build.scene);
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryBuildQuality(geometry, build.geometry);
    rtcSetGeometryUserPrimitiveCount(geometry, count);
    rtcSetGeometryUserData(geometry, user);
    rtcSetGeometryBoundsFunction(geometry, bounds, user);
    rtcAttachGeometryByID(scene_.get(), geometry, 0);
    rtcReleaseGeometry(geometry);
  }

  void update() {
    rtcCommitGeometry(rtcGetGeometry(scene_.get(), 0));
    rtcCommitScene(scene_.get());
  }
  RTCScene get() const { return scene_.get(); }

 private:
  Scene scene_;
};

class EmbreePeer : public Peer {
 public:
  explicit EmbreePeer(const Build& build)
      : build_(build), device_(rtcNewDevice("threads=1,set_affinity=0")) {}

  void inflate(double distance) override { boxes_.margin = distance / 2; }

 protected:
  Build build_;
  Device device_;
  const Topology* topology_ = nullptr;
  SweptBoxes boxes_;
  Candidates candidates_;
};

/// Edges against edges, vertices against faces.
class EmbreeFeatures : public EmbreePeer {
 public:
  using EmbreePeer::EmbreePeer;

  void prepare(const Topology& topology) override {
    topology_ = &topology;
    RTCDevice device = device_.get();
    edges_.emplace(device, static_cast<Index>(topology.edges().size()), build_, edge_bounds, this);
    vertices_.emplace(device, topology.vertex_count(), build_, vertex_bounds, this);
    faces_.emplace(device, static_cast<Index>(topology.triangles().size()), build_, face_bounds, this);
  }

  const Candidates& step(std::span<const double> x0, std::span<const double> x1) override {
    boxes_.update(x0, x1);
    candidates_.clear();
    edges_->update();
    vertices_->update();
    faces_->update();
    rtcCollide(edges_->get(), edges_->get(), collect_edges, this);
    rtcCollide(vertices_->get(), faces_->get(), collect_vertices, this);
    return candidates_;
  }

 private:
  static void edge_bounds(const RTCBoundsFunctionArguments* arguments) {
    const auto* self = static_cast<const EmbreeFeatures*>(arguments->geometryUserPtr);
    *arguments->bounds_o = rtc_bounds(self->boxes_.edge(self->topology_->edges()[arguments->primID]));
  }
  static void vertex_bounds(const RTCBoundsFunctionArguments* arguments) {
    const auto* self = static_cast<const EmbreeFeatures*>(arguments->geometryUserPtr);
    *arguments->bounds_o = rtc_bounds(self->boxes_.vertex(arguments->primID));
  }
  static void face_bounds(const RTCBoundsFunctionArguments* arguments) {
    const auto* self = static_cast<const EmbreeFeatures*>(arguments->geometryUserPtr);
    *arguments->bounds_o = rtc_bounds(self->boxes_.face(self->topology_->triangles()[arguments->primID]));
  }

  /// A leaf of a refitted hierarchy has several features, and Embree reports all pairs of two leaves that
  /// meet.
  bool reports_leaves() const { return build_.geometry == RTC_BUILD_QUALITY_REFIT; }

  /// Embree visits a scene against itself in both orders: the half with a < b is kept.
  static void collect_edges(void* user, RTCCollision* collisions, unsigned int count) {
    auto* self = static_cast<EmbreeFeatures*>(user);
    const auto edges = self->topology_->edges();
    for (unsigned int i = 0; i < count; ++i) {
      const Index a = collisions[i].primID0, b = collisions[i].primID1;
      if (a >= b || incident(edges[a], edges[b])) continue;
      if (self->reports_leaves() && !overlap(self->boxes_.edge(edges[a]), self->boxes_.edge(edges[b])))
        continue;
      self->candidates_.edge_edge.push_back({a, b});
    }
  }
  static void collect_vertices(void* user, RTCCollision* collisions, unsigned int count) {
    auto* self = static_cast<EmbreeFeatures*>(user);
    const auto triangles = self->topology_->triangles();
    for (unsigned int i = 0; i < count; ++i) {
      const Index v = collisions[i].primID0, f = collisions[i].primID1;
      if (incident(v, triangles[f])) continue;
      if (self->reports_leaves() && !overlap(self->boxes_.vertex(v), self->boxes_.face(triangles[f])))
        continue;
      self->candidates_.vertex_face.push_back({v, f});
    }
  }

  std::optional<BoxScene> edges_, vertices_, faces_;
};

/// Triangles against triangles. Each vertex and edge is represented by one triangle that has it, so that a
/// pair of triangles yields those feature pairs which no other pair of triangles yields.
class EmbreeTriangles : public EmbreePeer {
 public:
  using EmbreePeer::EmbreePeer;

  void prepare(const Topology& topology) override {
    topology_ = &topology;
    const auto triangles = topology.triangles();
    owned_.assign(triangles.size(), {});
    std::vector<bool> vertex_taken(topology.vertex_count()), edge_taken(topology.edges().size());
    for (Index t = 0; t < triangles.size(); ++t)
      for (int k = 0; k < 3; ++k) {
        own(triangles[t][k], vertex_taken, owned_[t].vertices, owned_[t].vertex_count);
        own(topology.triangle_edges()[t][k], edge_taken, owned_[t].edges, owned_[t].edge_count);
      }
    faces_.emplace(device_.get(), static_cast<Index>(triangles.size()), build_, face_bounds, this);
  }

  const Candidates& step(std::span<const double> x0, std::span<const double> x1) override {
    boxes_.update(x0, x1);
    edge_boxes_.clear();
    for (const Edge& e : topology_->edges()) edge_boxes_.push_back(boxes_.edge(e));
    face_boxes_.clear();
    for (const Triangle& t : topology_->triangles()) face_boxes_.push_back(boxes_.face(t));
    candidates_.clear();
    faces_->update();
    rtcCollide(faces_->get(), faces_->get(), collect, this);
    return candidates_;
  }

 private:
  static void face_bounds(const RTCBoundsFunctionArguments* arguments) {
    const auto* self = static_cast<const EmbreeTriangles*>(arguments->geometryUserPtr);
    *arguments->bounds_o = rtc_bounds(self->face_boxes_[arguments->primID]);
  }

  struct Owned {
    std::array<Index, 3> vertices, edges;
    int vertex_count = 0, edge_count = 0;
  };

  static void own(Index id, std::vector<bool>& taken, std::array<Index, 3>& ids, int& count) {
    if (id == kNoIndex || taken[id]) return;
    taken[id] = true;
    ids[count++] = id;
  }

  static void collect(void* user, RTCCollision* collisions, unsigned int count) {
    auto* self = static_cast<EmbreeTriangles*>(user);
    for (unsigned int i = 0; i < count; ++i) {
      const Index t = collisions[i].primID0, u = collisions[i].primID1;
      if (t < u) self->split(t, u);
    }
  }

  void split(Index t, Index u) {
    vertices_against(owned_[t], u);
    vertices_against(owned_[u], t);
    const auto edges = topology_->edges();
    for (int i = 0; i < owned_[t].edge_count; ++i)
      for (int j = 0; j < owned_[u].edge_count; ++j) {
        const auto [a, b] = ordered(owned_[t].edges[i], owned_[u].edges[j]);
        if (overlap(edge_boxes_[a], edge_boxes_[b]) && !incident(edges[a], edges[b]))
          candidates_.edge_edge.push_back({a, b});
      }
  }

  void vertices_against(const Owned& owned, Index f) {
    for (int i = 0; i < owned.vertex_count; ++i) {
      const Index v = owned.vertices[i];
      if (overlap(boxes_.vertex(v), face_boxes_[f]) && !incident(v, topology_->triangles()[f]))
        candidates_.vertex_face.push_back({v, f});
    }
  }

  std::vector<Owned> owned_;
  std::vector<Box> edge_boxes_, face_boxes_;
  std::optional<BoxScene> faces_;
};

template <class Variant, const Build& build>
PeerEntry entry(const char* name) {
  return {"Embree", name, RTC_VERSION_STRING, [] { return std::make_unique<Variant>(build); }};
}

const RegisterPeer kPeers[] = {RegisterPeer(entry<EmbreeFeatures, kMorton>("Embree features Morton")),
                               RegisterPeer(entry<EmbreeFeatures, kSah>("Embree features SAH")),
                               RegisterPeer(entry<EmbreeFeatures, kRefit>("Embree features refit")),
                               RegisterPeer(entry<EmbreeTriangles, kMorton>("Embree triangles Morton")),
                               RegisterPeer(entry<EmbreeTriangles, kSah>("Embree triangles SAH")),
                               RegisterPeer(entry<EmbreeTriangles, kRefit>("Embree triangles refit"))};

}  // namespace
}  // namespace foldproof::bench
