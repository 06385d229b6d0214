/// Verlet lists of features that are close, kept between calls. A list holds all pairs within a skin beyond
/// the inflation, and stays complete until its two leaves have moved towards each other by the skin
/// (docs/soundness.md, V4).
#pragma once

#include "base/parallel.h"
#include "solver/contact_filter.h"
#include "solver/near_boxes.h"
#include "solver/pair_distances.h"

namespace foldproof::inline internal {

/// Ends: 1 for poses, 2 for steps, during which vertices move straight from one end to the other.
template <int Ends>
class CandidateLists {
 public:
  CandidateLists(const CollisionMesh& mesh, const ContactFilter& filter);

  /// Makes the lists complete for these positions and this inflation, which may be infinite. Adds to `work`.
  /// Precondition: positions are finite and fit the mesh.
  void update(const std::array<const double*, Ends>& x, double inflation, Work& work);

  /// After an update: the relevant pairs whose boxes come within the inflation, as features, of a vertex and
  /// something else or of two edges. The result and its order depend on the last positions and inflation
  /// alone. Threads may do different rows at once.
  std::size_t row_count() const { return rows_.size(); }
  void find(IndexRange rows, std::vector<BoxPair>& out) const;
  /// Appends the ids of such pairs.
  void append(std::span<const BoxPair> pairs, Candidates& out) const;
  /// The smallest distance of a relevant pair in a pose if it is <= bound, else infinity. Adds to `work`.
  /// Lists stay as complete as they are. Precondition: as update().
  double nearest(const double* x, double bound, Work& work) requires(Ends == 1);

  /// The positions of the last update, as features are numbered here.
  std::span<const PointAtEnds<Ends>> points() const { return points_; }

 private:
  using Point = PointAtEnds<Ends>;
  using Box = BoxAtEnds<Ends>;
  /// How far vertices moved since the last call, at any end: along each axis the minimum, and the negated
  /// maximum.
  struct DisplacementBounds {
    double x[2][4];
  };
  /// Two separated nodes: the boxes of any two features below them have at least `min_separation`.
  struct SeparatedNodes {
    NodePair nodes;
    double min_separation;
  };
  /// A leaf that was close to the row's leaf, or is that leaf: the boxes of two features that are not listed
  /// have at least `min_separation`.
  struct Neighbor {
    Index node;
    Index end;  ///< Of its part of the row's list, which starts where the last neighbor's part ends.
    double min_separation;
    bool found;  ///< By the present rebuild.
  };
  struct Row {
    std::vector<Neighbor> neighbors;  ///< Ascending.
    std::vector<BoxPair> list;        ///< Features. Of an edge and a point, the edge comes first.
  };
  /// Features of one leaf that are close to another.
  struct Near {
    std::vector<Index> vertices, edges, triangles;
  };
  /// Two nodes that may be nearer than what is known; of the same distance the last one found goes first,
  /// as it is the smallest where boxes overlap.
  struct OpenPair {
    double min_distance;
    std::size_t number;
    NodePair nodes;
    bool operator<(const OpenPair& p) const {
      return min_distance != p.min_distance ? min_distance > p.min_distance : number < p.number;
    }
  };
  /// Scratch of one thread.
  struct Scratch {
    std::array<Near, 2> near;
    std::vector<BoxPair> pairs, list;
    std::uint64_t lists_built = 0;
    std::uint64_t vertex_pairs = 0, edge_pairs = 0;  ///< Measured for the smallest distance.
  };

  double box_separation(Index node_a, Index node_b) const;
  double closing_distance(Index node_a, Index node_b) const;
  double still_separated(double min_separation, Index node_a, Index node_b) const;
  double skin_for(Index node_a, Index node_b) const;
  void clear();
  void set_positions(const std::array<const double*, Ends>& x);
  void fit_leaf(Index leaf);
  void fit_features();
  void update_front();
  void rebuild_front();
  void traverse_pending();
  void add_neighbor(NodePair leaves);
  void update_rows();
  void expire_lists();
  void update_row(Index leaf, Scratch& scratch);
  void open_pair(NodePair pair, double bound) requires(Ends == 1);
  void take_leaves(std::size_t most, double bound) requires(Ends == 1);
  double nearest_of_leaves(NodePair leaves, double bound, Scratch& scratch) const requires(Ends == 1);
  std::size_t list_pairs(Index node_a, Index node_b, double distance, Scratch& scratch) const;
  void rebuild_list(Index node, Neighbor& neighbor, Scratch& scratch) const;
  void find_near(Index node, const Box& other, double distance, Near& near) const;
  template <class Visit>
  void visit_near_pairs(double distance, std::vector<BoxPair>& pairs, Visit visit) const;
  void list_vertices(double distance, const Near& with_vertices, const Near& with_triangles,
                     Scratch& scratch) const;
  void list_edges(bool self, double distance, Scratch& scratch) const;

  const CollisionMesh& mesh_;
  const ContactFilter& filter_;
  const Hierarchy& hierarchy_;
  const bool allows_all_;  // no filter
  const BoxOperations<Ends>& operations_;
  // Features are vertices, then edges, then triangles, each in leaf order.
  Index edges_begin_, triangles_begin_;
  std::vector<Index> ids_;       // per feature: a vertex id, a row of edges(), or the hierarchy's triangle id
  std::vector<Index> elements_;  // per triangle in leaf order: the feature that it represents
  LeafVertexLists leaf_vertices_;
  std::vector<std::array<Index, 1>> vertex_corners_;  // {0}, {1}, {2}, ...
  std::vector<Index> leaf_nodes_;

  bool complete_ = false;  // the last update was not cut off by an exception
  bool reuse_ = false;     // this update starts from the state of the last one
  double inflation_ = 0;
  double required_ = 0;  // features with this separation are beyond the inflation, rounding included
  std::vector<Point> points_, last_points_;        // in leaf order; of this and the last call
  std::vector<Box> boxes_, feature_boxes_;         // of nodes; of features
  std::vector<DisplacementBounds> displacements_;  // of nodes
  std::vector<SeparatedNodes> front_;
  std::vector<Row> rows_;           // per leaf: its neighbors among itself and later leaves
  std::vector<NodePair> pending_;   // to be traversed
  std::size_t neighbor_count_ = 0;  // of all rows
  std::size_t rebuilt_size_ = 0;    // of the front and the neighbors after the last rebuild
  std::uint64_t node_tests_ = 0;
  PerThread<Scratch> scratch_;

  // Of nearest().
  std::vector<OpenPair> open_pairs_;  // a heap
  std::size_t opened_ = 0;
  std::vector<NodePair> leaves_;  // of this round
  std::vector<double> distances_;
};

}  // namespace foldproof::internal
