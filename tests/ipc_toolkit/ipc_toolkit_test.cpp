// The interfaces of ipc-toolkit, asked as it asks, against all pairs by exact arithmetic. Compiled for each
// release whose interfaces differ.

#include "foldproof/ipc_toolkit.h"

#include <gmock/gmock.h>

#include <ipc/ipc.hpp>
#include <limits>

#include "oracle/oracle.h"
#include "solver/soups.h"

namespace foldproof::oracle {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;
using Keys = std::set<std::pair<Features, std::array<Index, 2>>>;

Eigen::MatrixXd matrix_of(const std::vector<double>& x) {
  return Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>>(x.data(), x.size() / 3,
                                                                                     3);
}
template <std::size_t n>
Eigen::MatrixXi matrix_of(const std::vector<std::array<Index, n>>& rows) {
  Eigen::MatrixXi matrix(rows.size(), n);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    for (std::size_t k = 0; k < n; ++k) matrix(i, k) = static_cast<int>(rows[i][k]);
  }
  return matrix;
}

// A soup as ipc-toolkit has it, with the edges of faces.
struct IpcScene {
  Soup soup;
  std::vector<Edge> edges;
  Eigen::MatrixXd x0, x1;
  ipc::CollisionMesh mesh;

  explicit IpcScene(Soup given)
      : soup(std::move(given)),
        edges(all_edges(soup)),
        x0(matrix_of(soup.x0)),
        x1(matrix_of(soup.x1)),
        mesh(x0, matrix_of(edges), matrix_of(soup.faces)) {}

  static std::vector<Edge> all_edges(const Soup& soup) {
    std::vector<Edge> edges = soup.edges;
    for (const Triangle& t : soup.faces) {
      for (int k = 0; k < 3; ++k) edges.push_back({t[k], t[(k + 1) % 3]});
    }
    return edges;
  }
};

IpcScene random_scene(std::uint64_t seed, double speed = 0.2) {
  Rng rng(seed);
  return IpcScene(random_soup(rng, 4, 6, 6, speed, seed % 3 == 0 ? 0x1p-4 : 0x1p-40));
}

bool some_may(Index i, Index j) { return (i ^ j) % 3 != 0; }

Keys keys_of(const ipc::Candidates& found) {
  Keys keys;
  const auto add = [&](Features features, auto a, auto b) {
    keys.insert({features, {static_cast<Index>(a), static_cast<Index>(b)}});
  };
  for (const auto& [face, vertex] : found.fv_candidates) add(Features::VertexFace, vertex, face);
  for (const auto& [a, b] : found.ee_candidates) add(Features::EdgeEdge, std::min(a, b), std::max(a, b));
  for (const auto& [edge, vertex] : found.ev_candidates) add(Features::EdgeVertex, edge, vertex);
  for (const auto& [a, b] : found.vv_candidates) add(Features::VertexVertex, std::min(a, b), std::max(a, b));
  return keys;
}

// Candidates hold all pairs that come within the bound, and none that may not collide. Returns how many are
// within.
int expect_complete(const Keys& found, const std::vector<FeaturePair>& pairs, const std::vector<double>& x0,
                    const std::vector<double>& x1, double bound) {
  int within = 0;
  std::size_t relevant = 0;
  for (const FeaturePair& pair : pairs) {
    const bool is_within = approach(pair.kind(), pair.at(x0), pair.at(x1), bound, 1e-4) == Approach::Within;
    within += is_within;
    relevant += found.contains(pair.key());
    EXPECT_TRUE(found.contains(pair.key()) || !is_within) << pair.ids[0] << ' ' << pair.ids[1];
  }
  EXPECT_EQ(relevant, found.size()) << "a pair that may not collide";
  return within;
}

TEST(IpcToolkit, CandidatesAreComplete) {
  int within = 0;
  ipc_toolkit::BroadPhase broad_phase;  // one for all scenes, as their meshes differ
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    IpcScene scene = random_scene(seed);
    for (const bool filtered : {false, true}) {
      if (filtered) scene.mesh.can_collide = some_may;
      const auto pairs = filtered ? all_pairs(scene.soup, scene.edges, some_may)
                                  : all_pairs(scene.soup, scene.edges, all_may);
      for (const double radius : {0.0, 0.1}) {
        ipc::Candidates found;
        found.build(scene.mesh, scene.x0, scene.x1, radius, &broad_phase);
        const Keys keys = keys_of(found);
        EXPECT_EQ(keys.size(), found.size()) << "a pair twice";
        within += expect_complete(keys, pairs, scene.soup.x0, scene.soup.x1, 2 * radius);
        for (const FeaturePair& pair : pairs) {  // and few others
          const Features features = pair.key().first;
          if (features != Features::VertexFace && features != Features::EdgeEdge) continue;
          if (!keys.contains(pair.key())) continue;
          EXPECT_NE(
              approach(pair.kind(), pair.at(scene.soup.x0), pair.at(scene.soup.x1), 2 * radius + 1e-6, 1e-4),
              Approach::Beyond);
        }

        found.build(scene.mesh, scene.x0, radius, &broad_phase);
        within += expect_complete(keys_of(found), pairs, scene.soup.x0, scene.soup.x0, 2 * radius);
      }
    }
  }
  EXPECT_GT(within, 200);
}

// What is found does not depend on what the same object was asked before, but for the order.
TEST(IpcToolkit, AnswersDoNotDependOnEarlierCalls) {
  ipc_toolkit::BroadPhase kept;
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    Rng rng(seed);
    IpcScene scene = random_scene(5);  // other positions of the same mesh
    for (double& v : scene.x1.reshaped()) v += std::uniform_real_distribution<double>(-0.3, 0.3)(rng);
    if (seed % 2 == 1) scene.mesh.can_collide = some_may;
    ipc_toolkit::BroadPhase fresh;
    ipc::Candidates a, b;
    a.build(scene.mesh, scene.x0, scene.x1, 0.02, &kept);
    b.build(scene.mesh, scene.x0, scene.x1, 0.02, &fresh);
    EXPECT_EQ(keys_of(a), keys_of(b));
    a.build(scene.mesh, scene.x1, 0.02, &kept);
    b.build(scene.mesh, scene.x1, 0.02, &fresh);
    EXPECT_EQ(keys_of(a), keys_of(b));
  }
}

// One pose: not what comes near on the way.
TEST(IpcToolkit, CandidatesOfAPoseAreThoseOfThePose) {
  Soup soup;
  soup.x0 = {0, 0, 0, 5, 0, 0};
  soup.x1 = {4, 0, 0, 5, 0, 0};
  const IpcScene scene(soup);
  ipc_toolkit::BroadPhase broad_phase;
  ipc::Candidates found;
  found.build(scene.mesh, scene.x0, scene.x1, 0.5, &broad_phase);
  EXPECT_EQ(found.size(), 1u);
  found.build(scene.mesh, scene.x0, 2.4, &broad_phase);
  EXPECT_EQ(found.size(), 0u);
  found.build(scene.mesh, scene.x0, 2.5, &broad_phase);
  EXPECT_EQ(found.size(), 1u);
}

std::vector<Vec3> points_of(const std::vector<double>& x, std::span<const Index> ids) {
  std::vector<Vec3> points;
  for (const Index i : ids) points.emplace_back(x[3 * i], x[3 * i + 1], x[3 * i + 2]);
  return points;
}

// Faces and edges as large as the scene, so that edges cross faces far from the edges of these.
IpcScene large_elements(std::uint64_t seed) {
  Rng rng(seed);
  Soup soup;
  for (Index v = 0; v < 30; ++v) {
    for (int axis = 0; axis < 3; ++axis) soup.x0.push_back(static_cast<double>(rng() % 64));
  }
  for (Index v = 0; v < 18; v += 3) soup.faces.push_back({v, v + 1, v + 2});
  for (Index v = 18; v < 30; v += 2) soup.edges.push_back({v, v + 1});
  soup.x1 = soup.x0;
  return IpcScene(soup);
}

TEST(IpcToolkit, EdgeFaceCandidatesHoldEveryCrossing) {
  int crossings = 0;
  ipc_toolkit::BroadPhase broad_phase;
  broad_phase.can_vertices_collide = some_may;
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    const IpcScene scene = large_elements(seed);
    broad_phase.build(scene.x0, scene.mesh.edges(), scene.mesh.faces(), 1e-6);
    std::vector<ipc::EdgeFaceCandidate> found;
    broad_phase.detect_edge_face_candidates(found);
    std::set<std::array<Index, 2>> keys;
    for (const auto& [edge, face] : found) keys.insert({static_cast<Index>(edge), static_cast<Index>(face)});
    for (Index e = 0; e < scene.edges.size(); ++e) {
      for (Index f = 0; f < scene.soup.faces.size(); ++f) {
        const Edge& edge = scene.edges[e];
        const Triangle& face = scene.soup.faces[f];
        const bool may = may_collide(edge, face, some_may);
        const bool cross = hulls_intersect(points_of(scene.soup.x0, edge), points_of(scene.soup.x0, face));
        EXPECT_TRUE(keys.contains({e, f}) ? may : !may || !cross) << e << ' ' << f;
        crossings += may && cross;
      }
    }
  }
  EXPECT_GT(crossings, 20);
}

// Asked of a whole mesh: every vertex is a point, also those of edges.
TEST(IpcToolkit, VertexCandidatesAreOfAllVertices) {
  const IpcScene scene = random_scene(1);
  const Index n = scene.soup.vertex_count();
  const double radius = 0.1;
  std::vector<FeaturePair> pairs;
  for (Index v = 0; v < n; ++v) {
    for (Index e = 0; e < scene.edges.size(); ++e) {
      const auto& [a, b] = scene.edges[e];
      if (v != a && v != b) pairs.push_back({Features::EdgeVertex, {e, v}, {v, a, b, b}});
    }
    for (Index w = v + 1; w < n; ++w) pairs.push_back({Features::VertexVertex, {v, w}, {v, w, w, w}});
  }
  ipc_toolkit::BroadPhase broad_phase;
  broad_phase.build(scene.x0, scene.x1, scene.mesh.edges(), scene.mesh.faces(), radius);
  ipc::Candidates found;
  broad_phase.detect_vertex_vertex_candidates(found.vv_candidates);
  broad_phase.detect_edge_vertex_candidates(found.ev_candidates);
  EXPECT_GT(expect_complete(keys_of(found), pairs, scene.soup.x0, scene.soup.x1, 2 * radius), 50);
}

TEST(IpcToolkit, StepSizesAreNeverTooLarge) {
  int cut = 0, free = 0;
  ipc_toolkit::BroadPhase broad_phase;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    IpcScene scene = random_scene(seed, 0.08);
    if (seed % 2 == 0) scene.mesh.can_collide = some_may;
    const auto pairs = seed % 2 == 0 ? all_pairs(scene.soup, scene.edges, some_may)
                                     : all_pairs(scene.soup, scene.edges, all_may);
    const double min_distance = seed % 4 < 2 ? 0 : 0.01;
    ipc_toolkit::NarrowPhaseCCD narrow_phase;
    narrow_phase.conservative_rescaling = seed % 5 == 0 ? 1 : 0.8;
    const double size = ipc::compute_collision_free_stepsize(scene.mesh, scene.x0, scene.x1, min_distance,
                                                             &broad_phase, narrow_phase);
    const bool is_free =
        ipc::is_step_collision_free(scene.mesh, scene.x0, scene.x1, min_distance, &broad_phase, narrow_phase);
    EXPECT_EQ(is_free, size == 1);
    bool beyond = true;  // all pairs, by more than tolerances
    for (const FeaturePair& pair : pairs) {
      const FourPoints x0 = pair.at(scene.soup.x0), x1 = pair.at(scene.soup.x1);
      const Span before{size, true};
      EXPECT_NE(approach(pair.kind(), x0, x1, min_distance, 1e-4, is_free ? Span{} : before),
                Approach::Within);
      EXPECT_FALSE(touches(pair.kind(), x0, x1, is_free ? Span{} : before));
      beyond = beyond && approach(pair.kind(), x0, x1, min_distance + 1e-6, 1e-4) == Approach::Beyond;
    }
    EXPECT_TRUE(is_free || !beyond) << seed;
    cut += size > 0 && size < 1;
    free += is_free;
  }
  EXPECT_GT(cut, 3);
  EXPECT_GT(free, 3);
}

TEST(IpcToolkit, TimesAreSharesOfTheTimeToContact) {
  ipc_toolkit::NarrowPhaseCCD ccd;
  const Eigen::Vector3d p0(0, 0, 1), p1(0, 0, -1), q(0, 0, 0);
  double toi = 7;
  EXPECT_TRUE(ccd.point_point_ccd(p0, q, p1, q, toi));
  EXPECT_NEAR(toi, 0.4, 1e-6);
  EXPECT_LE(toi, 0.4);
  EXPECT_TRUE(ccd.point_point_ccd(p0, q, p1, q, toi, 0.5));  // at 0.25
  EXPECT_NEAR(toi, 0.2, 1e-6);
  EXPECT_FALSE(ccd.point_point_ccd(p0, q, p1, q, toi, 0, 0.49));
  EXPECT_NEAR(toi, 0.2, 1e-6) << "is set with true only";
  EXPECT_TRUE(ccd.point_point_ccd(p0, q, p0, q, toi, 1));
  EXPECT_EQ(toi, 0) << "starts at the least distance";
  const Eigen::Vector3d a(-1, 0, 0), b(1, 0, 0), c(0, 1, 0);
  EXPECT_TRUE(ccd.point_edge_ccd(p0, a, b, p1, a, b, toi));
  EXPECT_TRUE(ccd.point_triangle_ccd(p0, a, b, c, p1, a, b, c, toi));
  EXPECT_FALSE(ccd.point_triangle_ccd(p0, a, b, c, p0, a, b, c, toi));
}

TEST(IpcToolkit, TheShareBelongsToTheBaseWhereItHasOne) {
  const ipc_toolkit::NarrowPhaseCCD ccd;  // compiles
  EXPECT_EQ(ccd.conservative_rescaling, 0.8);
#if IPC_STAND_IN >= 16
  EXPECT_EQ(static_cast<const ipc::NarrowPhaseCCD&>(ccd).conservative_rescaling, 0.8);
#endif
}

TEST(IpcToolkit, RescaledGaps) {
  ipc_toolkit::NarrowPhaseCCD ccd;
  ccd.rescale_distance = true;
  const Eigen::Vector3d start(0, 0, 1), far(0, 0, -4), q(0, 0, 0);
  double toi = 7;
  EXPECT_TRUE(ccd.point_point_ccd(start, q, far, q, toi));  // 0.2 of the gap is left
  EXPECT_NEAR(toi, 0.16, 1e-6);
  EXPECT_TRUE(ccd.point_point_ccd(start, q, far, q, toi, 0.5));  // 0.1 of 0.5
  EXPECT_NEAR(toi, 0.4 / 5, 1e-6);
  const Eigen::Vector3d near(0, 0, 0.25);
  EXPECT_FALSE(ccd.point_point_ccd(start, q, near, q, toi)) << "keeps its share";
  const Eigen::Vector3d nearer(0, 0, 0.15);
  EXPECT_TRUE(ccd.point_point_ccd(start, q, nearer, q, toi));
  const Eigen::Vector3d a(-1, 0, 0), b(1, -1, 0), c(0, 1, 0);
  EXPECT_TRUE(ccd.point_triangle_ccd(start, a, b, c, far, a, b, c, toi));
  EXPECT_NEAR(toi, 0.16, 1e-6);
  EXPECT_TRUE(ccd.point_point_ccd(q, q, far, q, toi));
  EXPECT_EQ(toi, 0) << "starts in contact";
}

template <class F>
void expect_error(F call, const char* message) {
  EXPECT_THAT(call, ThrowsMessage<std::logic_error>(HasSubstr(message)));
}

TEST(IpcToolkit, UnsupportedUseIsAnError) {
  ipc_toolkit::BroadPhase broad_phase;
  ipc::BroadPhase& base = broad_phase;
  std::vector<ipc::EdgeEdgeCandidate> ee;
  std::vector<ipc::EdgeFaceCandidate> ef;
  std::vector<ipc::FaceFaceCandidate> ff;
  const IpcScene scene = random_scene(0);
  const Eigen::MatrixXd flat = scene.x0.leftCols(2);
  const Eigen::MatrixXi edges = scene.mesh.edges(), faces = scene.mesh.faces();
  expect_error([&] { base.build(flat, edges, faces, 0); },
               "positions have 2 columns, not 3; keep a broad phase");
  expect_error([&] { base.build(scene.x0, flat, edges, faces, 0); }, "2 columns");
  expect_error([&] { base.detect_edge_edge_candidates(ee); }, "call build with vertices");
  base.build(scene.x0, scene.x1, edges, faces, 0);
  expect_error([&] { base.detect_edge_face_candidates(ef); }, "build with one pose");
  expect_error([&] { base.detect_face_face_candidates(ff); }, "ask another broad phase");
  base.clear();
  expect_error([&] { base.detect_edge_edge_candidates(ee); }, "call build with vertices");
#if IPC_STAND_IN >= 15
  base.build(scene.x0, scene.x1, edges, faces, 0);
  base.build(ipc::BroadPhase::AABBs(scene.x0.rows()), edges, faces, 3);
  expect_error([&] { base.detect_edge_edge_candidates(ee); }, "not boxes");
#endif
  Eigen::MatrixXd broken = scene.x0;
  broken(3, 1) = std::numeric_limits<double>::quiet_NaN();
  base.build(broken, edges, faces, 0);
  expect_error([&] { base.detect_edge_edge_candidates(ee); }, "foldproof: ");
  base.build(scene.x0, edges, faces, -1);
  expect_error([&] { base.detect_edge_edge_candidates(ee); }, "foldproof: ");
  base.build(scene.x0, edges, faces, 0);
  base.detect_edge_edge_candidates(ee);  // works again

  ipc_toolkit::NarrowPhaseCCD ccd;
  double toi = 1;
  const ipc::VectorMax3d p = Eigen::Vector2d(1, 2);
  expect_error([&] { ccd.point_point_ccd(p, p, p, p, toi); }, "a point has 2 coordinates, not 3");
  const Eigen::Vector3d q(1, 2, 3), nan(0, 0, std::nan(""));
  expect_error([&] { ccd.point_edge_ccd(q, q, q, q, q, nan, toi); }, "finite positions");
  expect_error([&] { ccd.point_edge_ccd(q, q, q, q, q, q, toi, -1); }, "min_distance");
  expect_error([&] { ccd.point_edge_ccd(q, q, q, q, q, q, toi, 0, 1.5); }, "tmax");
  ccd.conservative_rescaling = 0;
  expect_error([&] { ccd.point_edge_ccd(q, q, q, q, q, q, toi); }, "conservative_rescaling");
}

// Edges of faces that ipc-toolkit leaves out are not asked for; nothing to collide is no error.
TEST(IpcToolkit, FewElements) {
  const IpcScene scene = random_scene(2);
  ipc_toolkit::BroadPhase broad_phase;
  EXPECT_FALSE(broad_phase.name().empty());
  ipc::Candidates found;
  broad_phase.build(scene.x0, scene.x1, Eigen::MatrixXi(0, 2), scene.mesh.faces(), 0.2);
  broad_phase.detect_edge_edge_candidates(found.ee_candidates);
  EXPECT_TRUE(found.ee_candidates.empty());
  broad_phase.detect_face_vertex_candidates(found.fv_candidates);
  EXPECT_FALSE(found.fv_candidates.empty());
  std::vector<ipc::EdgeFaceCandidate> ef;
  broad_phase.build(scene.x0, Eigen::MatrixXi(0, 2), Eigen::MatrixXi(0, 3), 0.2);
  found = {};
  broad_phase.detect_edge_edge_candidates(found.ee_candidates);
  broad_phase.detect_face_vertex_candidates(found.fv_candidates);
  broad_phase.detect_edge_vertex_candidates(found.ev_candidates);
  broad_phase.detect_edge_face_candidates(ef);
  EXPECT_EQ(found.size() + ef.size(), 0u);
}

}  // namespace
}  // namespace foldproof::oracle
