/// Bullet: btDbvt, the dynamic hierarchy under its broad phase and its soft bodies. Built once, then refitted
/// each step, as Bullet does for deformable bodies.
#include <BulletCollision/BroadphaseCollision/btDbvt.h>
#include <LinearMath/btScalar.h>

#include "competitor.h"
#include "swept_boxes.h"

namespace foldproof::bench {
namespace {

btDbvtVolume volume(const Box& box) {
  return btDbvtVolume::FromMM(btVector3(box.lo[0], box.lo[1], box.lo[2]),
                              btVector3(box.hi[0], box.hi[1], box.hi[2]));
}

Index id_of(const btDbvtNode* leaf) { return static_cast<Index>(leaf->dataAsInt); }

/// One btDbvt over one kind of feature.
class Tree {
 public:
  template <class BoxOf>
  void update(Index count, BoxOf box_of) {
    if (leaves_.empty()) {
      for (Index i = 0; i < count; ++i) {
        leaves_.push_back(tree_.insert(volume(box_of(i)), nullptr));
        leaves_.back()->dataAsInt = static_cast<int>(i);
      }
      tree_.optimizeTopDown();
    }
    for (Index i = 0; i < count; ++i) leaves_[i]->volume = volume(box_of(i));
    refit(tree_.m_root);
  }
  btDbvt& get() { return tree_; }

 private:
  static void refit(btDbvtNode* node) {
    if (node->isleaf()) return;
    refit(node->childs[0]);
    refit(node->childs[1]);
    Merge(node->childs[0]->volume, node->childs[1]->volume, node->volume);
  }

  btDbvt tree_;
  std::vector<btDbvtNode*> leaves_;
};

class BulletPeer : public Peer {
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
    CollectEdges collect_edges(*topology_, candidates_);
    edges_.get().collideTTpersistentStack(edges_.get().m_root, edges_.get().m_root, collect_edges);
    CollectVertices collect_vertices(*topology_, candidates_);
    vertices_.get().collideTTpersistentStack(vertices_.get().m_root, faces_.get().m_root, collect_vertices);
    return candidates_;
  }

 private:
  struct Collect : btDbvt::ICollide {
    Collect(const Topology& t, Candidates& c) : topology(t), candidates(c) {}
    const Topology& topology;
    Candidates& candidates;
  };
  struct CollectEdges : Collect {
    using Collect::Collect;
    void Process(const btDbvtNode* a, const btDbvtNode* b) override {
      const auto [i, j] = ordered(id_of(a), id_of(b));
      const auto edges = topology.edges();
      if (!incident(edges[i], edges[j])) candidates.edge_edge.push_back({i, j});
    }
  };
  struct CollectVertices : Collect {
    using Collect::Collect;
    void Process(const btDbvtNode* v, const btDbvtNode* f) override {
      if (!incident(id_of(v), topology.triangles()[id_of(f)]))
        candidates.vertex_face.push_back({id_of(v), id_of(f)});
    }
  };

  const Topology* topology_ = nullptr;
  SweptBoxes boxes_;
  Tree edges_, vertices_, faces_;
  Candidates candidates_;
};

std::string version() {
  const int number = btGetVersion();
  return std::to_string(number / 100) + "." + std::to_string(number % 100);
}

const RegisterPeer kBullet{
    {"Bullet", "Bullet btDbvt", version(), [] { return std::make_unique<BulletPeer>(); }}};

}  // namespace
}  // namespace foldproof::bench
