/// FCL: its broad phase over the features as separate objects, a dynamic AABB tree that is refitted and
/// rebalanced each step. FCL's own continuous collision serves rigid bodies only and cannot play here
/// (docs/benchmarks).
#include <fcl/broadphase/broadphase_dynamic_AABB_tree.h>
#include <fcl/config.h>
#include <fcl/narrowphase/collision_object.h>

#include "competitor.h"
#include "swept_boxes.h"

namespace foldproof::bench {
namespace {

/// A shape of which the broad phase needs nothing but the box.
class FeatureBox : public fcl::CollisionGeometryd {
 public:
  void computeLocalAABB() override {}
};

/// The features of one kind, each an object of its own in one manager.
class Objects {
 public:
  template <class BoxOf>
  void update(Index count, BoxOf box_of) {
    if (shapes_.empty()) register_all(count, box_of);
    for (Index i = 0; i < count; ++i) set_box(i, box_of(i));
    manager_.update();
  }
  fcl::DynamicAABBTreeCollisionManagerd& manager() { return manager_; }
  static Index id_of(const fcl::CollisionObjectd* object) {
    return static_cast<Index>(reinterpret_cast<std::uintptr_t>(object->getUserData()));
  }

 private:
  template <class BoxOf>
  void register_all(Index count, BoxOf box_of) {
    std::vector<fcl::CollisionObjectd*> pointers;
    for (Index i = 0; i < count; ++i) {
      shapes_.push_back(std::make_shared<FeatureBox>());
      objects_.push_back(std::make_unique<fcl::CollisionObjectd>(shapes_.back()));
      // NOLINTNEXTLINE(performance-no-int-to-ptr): FCL hands the index back
      objects_.back()->setUserData(reinterpret_cast<void*>(static_cast<std::uintptr_t>(i)));
      set_box(i, box_of(i));
      pointers.push_back(objects_.back().get());
    }
    manager_.registerObjects(pointers);
    manager_.setup();
  }

  void set_box(Index i, const Box& box) {
    shapes_[i]->aabb_local.min_ = {box.lo[0], box.lo[1], box.lo[2]};
    shapes_[i]->aabb_local.max_ = {box.hi[0], box.hi[1], box.hi[2]};
    objects_[i]->computeAABB();
  }

  std::vector<std::shared_ptr<FeatureBox>> shapes_;
  std::vector<std::unique_ptr<fcl::CollisionObjectd>> objects_;
  fcl::DynamicAABBTreeCollisionManagerd manager_;
};

class FclPeer : public Peer {
 public:
  void inflate(double distance) override { boxes_.margin = distance / 2; }
  void prepare(const Topology& topology) override { topology_ = &topology; }

  const Candidates& step(std::span<const double> x0, std::span<const double> x1) override {
    boxes_.update(x0, x1);
    const auto edges = topology_->edges();
    const auto triangles = topology_->triangles();
    edges_.update(static_cast<Index>(edges.size()), [&](Index e) { return boxes_.edge(edges[e]); });
    vertices_.update(topology_->vertex_count(), [&](Index v) { return boxes_.vertex(v); });
    faces_.update(static_cast<Index>(triangles.size()), [&](Index f) { return boxes_.face(triangles[f]); });
    candidates_.clear();
    edges_.manager().collide(this, collect_edges);
    vertices_.manager().collide(&faces_.manager(), this, collect_vertices);
    return candidates_;
  }

 private:
  static bool collect_edges(fcl::CollisionObjectd* a, fcl::CollisionObjectd* b, void* user) {
    auto* self = static_cast<FclPeer*>(user);
    const auto edges = self->topology_->edges();
    const auto [i, j] = ordered(Objects::id_of(a), Objects::id_of(b));
    if (!incident(edges[i], edges[j])) self->candidates_.edge_edge.push_back({i, j});
    return false;  // Go on: every pair is wanted.
  }
  static bool collect_vertices(fcl::CollisionObjectd* a, fcl::CollisionObjectd* b, void* user) {
    auto* self = static_cast<FclPeer*>(user);
    const Index v = Objects::id_of(a), f = Objects::id_of(b);
    if (!incident(v, self->topology_->triangles()[f])) self->candidates_.vertex_face.push_back({v, f});
    return false;
  }

  const Topology* topology_ = nullptr;
  SweptBoxes boxes_;
  Objects edges_, vertices_, faces_;
  Candidates candidates_;
};

const RegisterPeer kFcl{
    {"FCL", "FCL dynamic AABB tree", FCL_VERSION, [] { return std::make_unique<FclPeer>(); }}};

}  // namespace
}  // namespace foldproof::bench
