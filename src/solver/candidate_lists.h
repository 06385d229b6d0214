/// Which features come near each other, from call to call. What Verlet lists are to particles: pairs are
/// listed with some room, and a list holds until what it speaks of has moved by its room, one part against
/// the other (docs/soundness.md, V4).
#pragma once

#include "base/parallel.h"
#include "solver/contact_filter.h"
#include "solver/near_boxes.h"

namespace foldproof {

/// Ends: 1 for poses, 2 for steps, during which vertices go straight from one end to the other.
template <int Ends>
class CandidateLists {
 public:
  CandidateLists(const CollisionMesh& mesh, const ContactFilter& filter);

  /// Makes the lists complete for these positions and this inflation. Adds to `work`. Precondition: positions
  /// are finite and have the mesh's size.
  void update(const std::array<const double*, Ends>& x, double inflation, Work& work);

  /// After an update: the pairs that count and whose boxes come within the inflation. Which these are, and
  /// their order, depends on the last positions and inflation alone. By rows, several threads at once.
  /// Appends to `out`.
  std::size_t row_count() const { return rows_.size(); }
  void find(IndexRange rows, std::vector<BoxPair>& scratch, Candidates& out) const;

 private:
  using Point = PlacedPoint<Ends>;
  using Box = PlacedBox<Ends>;
  /// How far vertices went since the call before, at any end: along each axis the least, and the negated
  /// most.
  struct Drift {
    double x[2][4];
  };
  /// Two nodes that are apart: whatever is below them, `covers` lies between the boxes of any two features.
  struct Apart {
    Index a, b;
    double covers;
  };
  /// A leaf that was near the row's leaf, or is that leaf: between features that are not listed lies
  /// `covers`.
  struct Neighbour {
    Index node;
    Index end;  ///< Of what is listed for it in the row; it begins where that of the one before ends.
    double covers;
    bool seen;  ///< While all is looked at again.
  };
  struct Row {
    std::vector<Neighbour> neighbours;  ///< Ascending.
    std::vector<BoxPair> list;          ///< Features; of an edge and a point the edge comes first.
  };
  /// Features of one leaf that are near another.
  struct Near {
    std::vector<Index> vertices, edges, triangles;
  };
  struct Local {
    std::array<Near, 2> near;
    std::vector<BoxPair> pairs, list;
    std::uint64_t listed = 0;  ///< How many lists were made.
  };

  double between(Index node_a, Index node_b) const;
  double melted(Index node_a, Index node_b) const;
  double room_for(Index node_a, Index node_b) const;
  void clear();
  void move(const std::array<const double*, Ends>& x);
  void fit_leaf(Index leaf);
  void fit_features();
  void renew_front();
  void renew_all();
  void descend();
  void add_neighbour(NodePair leaves);
  void renew_rows();
  void renew_row(Index leaf, Local& local);
  void renew(Index node, Neighbour& neighbour, Local& local) const;
  void list_near(Index node, const Box& other, double reach, Near& near) const;
  template <class Visit>
  void each_near(double reach, std::vector<BoxPair>& pairs, Visit visit) const;
  void list_vertices(double reach, const Near& with_vertices, const Near& with_triangles, Local& local) const;
  void list_edges(bool self, double reach, Local& local) const;

  const CollisionMesh& mesh_;
  const ContactFilter& filter_;
  const Hierarchy& tree_;
  const bool all_may_;  // no filter
  const BoxOperations<Ends>& operations_;
  // Features are vertices, then edges, then triangles, each in leaf order.
  Index edges_begin_, triangles_begin_;
  std::vector<Index> ids_;  // per feature: of a vertex, the row of an edge, of a triangle of the hierarchy
  std::vector<Index> elements_;  // per triangle in leaf order: the feature that it stands for
  LeafVertexLists leaf_vertices_;
  std::vector<std::array<Index, 1>> vertex_places_;  // 0, 1, 2, ...
  std::vector<Index> leaf_nodes_;

  bool complete_ = false;  // what follows is of the call before, which was not cut off by an exception
  bool started_ = false;   // there was such a call
  double inflation_ = 0;
  double needed_ = 0;  // a little more: what lies so far apart is not within the inflation by the test either
  std::vector<Point> points_, before_;      // in leaf order; at the call before
  std::vector<Box> boxes_, feature_boxes_;  // of nodes; of features
  std::vector<Drift> drifts_;               // of nodes
  std::vector<Apart> front_;
  std::vector<Row> rows_;            // per leaf: it and leaves that come later
  std::vector<NodePair> pending_;    // to be looked at, with what lies below
  std::size_t neighbours_ = 0;       // of all rows
  std::size_t proofs_at_first_ = 0;  // how many there were when all was looked at
  std::uint64_t tests_ = 0;
  PerThread<Local> locals_;
};

}  // namespace foldproof
