// Whole queries compared with brute force on generated meshes. Culling allows for thickness and tolerance, so
// the answers must be the same pairs with bit-equal times.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "base/callers.h"
#include "foldproof/check.h"
#include "oracle/brute_force.h"
#include "oracle/judge.h"
#include "oracle/meshes.h"

namespace foldproof::oracle {
namespace {

struct Movement {
  double motion;  ///< Size of the deformation during the step; the meshes' size is about 1.
  double grid;    ///< Positions are multiples of this; 0 for any position.
};
constexpr Movement kMovements[] = {{0.01, 0}, {0.4, 0}, {0.05, 1.0 / 64}, {0.3, 1.0 / 8}};

Scene make_scene(const std::vector<const MeshFamily*>& families, const Movement& movement, Rng& rng) {
  Scene scene;
  for (const MeshFamily* family : families) {
    const Mesh mesh = family->make(rng);
    scene.topologies.push_back(mesh.topology());
    scene.x0.push_back(deformed(mesh.positions, 0.1, movement.grid, rng));
    scene.x1.push_back(deformed(scene.x0.back(), movement.motion, movement.grid, rng));
  }
  return scene;
}

StepResult run(const Scene& scene, const StepSettings& settings, Index leaf_triangles) {
  StepChecker checker(scene.hierarchies(leaf_triangles));
  StepResult result;
  const auto x0 = scene.spans0(), x1 = scene.spans1();
  const Result<void> done = checker.check(x0, x1, settings, result);
  EXPECT_TRUE(done.has_value()) << (done ? "" : done.error().line());
  return result;
}

template <class Collision>
std::map<PairKey, Collision> by_key(const std::vector<Collision>& pairs) {
  std::map<PairKey, Collision> result;
  for (const Collision& pair : pairs)
    EXPECT_TRUE(result.emplace(key(pair), pair).second) << "a pair is listed twice";
  return result;
}

std::string name(const PairKey& k) {
  std::string text;
  for (const Index i : k) text += std::to_string(i) + " ";
  return text;
}

template <class Collision>
void expect_identical(const std::vector<Collision>& actual, const std::vector<Collision>& expected) {
  const auto a = by_key(actual), e = by_key(expected);
  for (const auto& [id, pair] : e) {
    const auto found = a.find(id);
    if (found == a.end()) {
      ADD_FAILURE() << "missing " << name(id) << "toi " << pair.toi;
      continue;
    }
    EXPECT_EQ(std::memcmp(&found->second.toi, &pair.toi, sizeof pair.toi), 0)
        << name(id) << "toi " << found->second.toi << " instead of " << pair.toi;
    EXPECT_EQ(found->second.answer, pair.answer) << name(id);
  }
  for (const auto& [id, pair] : a)
    EXPECT_TRUE(e.count(id)) << "beyond brute force: " << name(id) << "toi " << pair.toi;
  EXPECT_TRUE(std::is_sorted(actual.begin(), actual.end(),
                             [](const Collision& p, const Collision& q) { return key(p) < key(q); }));
}

void expect_identical(const StepResult& actual, const StepResult& expected) {
  expect_identical(actual.vertex_face, expected.vertex_face);
  expect_identical(actual.edge_edge, expected.edge_edge);
  EXPECT_EQ(actual.earliest_toi, expected.earliest_toi);
}

void expect_bits_equal(const StepResult& a, const StepResult& b, bool same_work) {
  EXPECT_TRUE(same_collisions(a, b));
  EXPECT_EQ(a.earliest_toi, b.earliest_toi);
  EXPECT_EQ(a.tolerance, b.tolerance);
  if (!same_work) return;
  EXPECT_EQ(a.work.refits, b.work.refits);
  EXPECT_EQ(a.work.node_tests, b.work.node_tests);
  EXPECT_EQ(a.work.leaf_pairs, b.work.leaf_pairs);
  EXPECT_EQ(a.work.candidates_vf, b.work.candidates_vf);
  EXPECT_EQ(a.work.candidates_ee, b.work.candidates_ee);
  EXPECT_EQ(a.work.undecided, b.work.undecided);
}

class QueryProperties : public ::testing::TestWithParam<MeshFamily> {
 protected:
  std::vector<Scene> scenes(Rng& rng, std::size_t objects) const {
    std::vector<Scene> result;
    for (const Movement& movement : kMovements) {
      std::vector<const MeshFamily*> families = {&GetParam()};
      while (families.size() < objects) families.push_back(&mesh_families()[rng() % mesh_families().size()]);
      result.push_back(make_scene(families, movement, rng));
    }
    return result;
  }
};

TEST_P(QueryProperties, WithinOneMeshEqualsBruteForce) {
  Rng rng(51);
  std::size_t hits = 0;
  for (const Scene& scene : scenes(rng, 1)) {
    for (const double thickness : {0.0, 0.01}) {
      StepSettings settings;
      settings.thickness = thickness;
      const StepResult expected = brute_force_step(scene, settings, run(scene, settings, 16).tolerance);
      hits += expected.vertex_face.size() + expected.edge_edge.size();
      for (const Index leaf : {1, 5, 16, 100000}) expect_identical(run(scene, settings, leaf), expected);
      if (HasFailure()) return;
    }
  }
  EXPECT_GT(hits, 50u);
}

TEST_P(QueryProperties, ReportsTheRequestedOrDefaultTolerance) {
  Rng rng(52);
  const Scene scene = scenes(rng, 2)[1];
  StepSettings settings;
  settings.tolerance = 0x1p-12;
  const StepResult requested = run(scene, settings, 16);
  EXPECT_EQ(requested.tolerance, 0x1p-12);
  expect_identical(requested, brute_force_step(scene, settings, 0x1p-12));
  settings.tolerance = 0;
  Vec3 lo = Vec3::Constant(1e300), hi = -lo;
  for (const auto* x : {&scene.x0, &scene.x1}) {
    for (const auto& object : *x) {
      for (std::size_t i = 0; i < object.size(); ++i) {
        lo[i % 3] = std::min(lo[i % 3], object[i]);
        hi[i % 3] = std::max(hi[i % 3], object[i]);
      }
    }
  }
  EXPECT_NEAR(run(scene, settings, 16).tolerance, (hi - lo).maxCoeff() * 0x1p-30, 0x1p-60);
}

TEST_P(QueryProperties, SeveralObjectsEqualBruteForce) {
  Rng rng(53);
  std::size_t hits = 0;
  for (const Scene& scene : scenes(rng, 3)) {
    for (const auto& [within, between] : {std::pair{true, true}, {true, false}, {false, true}}) {
      StepSettings settings;
      settings.within = within;
      settings.between = between;
      settings.thickness = between ? 0.0 : 0.003;
      const StepResult actual = run(scene, settings, 16);
      const StepResult expected = brute_force_step(scene, settings, actual.tolerance);
      expect_identical(actual, expected);
      if (between) hits += expected.vertex_face.size() + expected.edge_edge.size();
      if (HasFailure()) return;
    }
  }
  EXPECT_GT(hits, 50u);
}

// Boxes may be in single precision, whose range ends near 1e38 and whose ulps are large far from the origin.
TEST_P(QueryProperties, AnyScaleAndPositionEqualsBruteForce) {
  Rng rng(60);
  const Scene unit = scenes(rng, 2)[1];
  std::size_t hits = 0;
  for (const double scale : {0x1p-1000, 0x1p-500, 0x1p-140, 0x1p120, 0x1p140, 0x1p500, 0x1p1000}) {
    for (const double shift : {0.0, 0x1p40}) {
      Scene scene = unit;
      for (auto* x : {&scene.x0, &scene.x1}) {
        for (auto& object : *x) {
          for (double& coordinate : object) coordinate = (coordinate + shift) * scale;
        }
      }
      if (scale == 0x1p1000 && shift != 0) continue;  // Not finite.
      const StepResult actual = run(scene, {}, 16);
      const StepResult expected = brute_force_step(scene, {}, actual.tolerance);
      expect_identical(actual, expected);
      hits += expected.vertex_face.size() + expected.edge_edge.size();
      ASSERT_FALSE(HasFailure()) << "scale " << scale << ", shift " << shift;
    }
  }
  EXPECT_GT(hits, 50u);
}

TEST_P(QueryProperties, AnyNumberOfThreadsGivesTheSameBits) {
  if (!has_threads()) GTEST_SKIP() << "there is one thread";
  Rng rng(54);
  for (const Scene& scene : scenes(rng, 2)) {
    for (const bool earliest : {false, true}) {
      StepSettings settings;
      settings.earliest_only = earliest;
      settings.thickness = 0.004;
      std::vector<StepResult> results;
      for (const int threads : {1, 2, 3}) {
        with_threads(threads, [&] {
          for (int repeat = 0; repeat < 3; ++repeat) results.push_back(run(scene, settings, 4));
        });
      }
      for (const StepResult& r : results) expect_bits_equal(r, results.front(), !earliest);
    }
  }
}

template <class Collision>
const Collision* earliest_of(const std::vector<Collision>& pairs) {
  const auto before = [](const Collision& p, const Collision& q) {
    return p.toi != q.toi ? p.toi < q.toi : key(p) < key(q);
  };
  const auto it = std::min_element(pairs.begin(), pairs.end(), before);
  return it == pairs.end() ? nullptr : &*it;
}

Topology with_isolated_vertex(const Topology& t) {
  const auto faces = t.faces();
  return Topology::make(t.vertex_count() + 1, {faces.begin(), faces.end()}).value();
}

void expect_earliest(const StepResult& first, const StepResult& all) {
  ASSERT_EQ(first.vertex_face.size() + first.edge_edge.size(), all.clean() ? 0u : 1u);
  EXPECT_EQ(first.earliest_toi, all.earliest_toi);
  if (!first.vertex_face.empty()) {
    const auto* expected = earliest_of(all.vertex_face);
    EXPECT_EQ(first.vertex_face[0].toi, all.earliest_toi);
    EXPECT_EQ(key(first.vertex_face[0]), key(*expected));
  }
  if (!first.edge_edge.empty()) {
    const auto* expected = earliest_of(all.edge_edge);
    EXPECT_EQ(first.edge_edge[0].toi, all.earliest_toi);
    EXPECT_EQ(key(first.edge_edge[0]), key(*expected));
  }
}

TEST_P(QueryProperties, EarliestOnlyIsTheFirstOfAll) {
  Rng rng(55);
  std::size_t hits = 0;
  for (const std::size_t objects : {1, 2}) {
    for (const Scene& scene : scenes(rng, objects)) {
      StepSettings settings;
      const StepResult all = run(scene, settings, 16);
      hits += all.count();
      settings.earliest_only = true;
      ASSERT_NO_FATAL_FAILURE(expect_earliest(run(scene, settings, 16), all));
    }
  }
  EXPECT_GT(hits, 50u);
}

// A step in which leaves move by several of their sizes is searched in stretches of time, one of a large
// common motion without it. Objects fall onto each other from some way off.
TEST_P(QueryProperties, EarliestOnlyIsTheFirstOfAllInLongSteps) {
  Rng rng(65);
  std::size_t hits = 0, in_stretches = 0;
  std::uint64_t candidates = 0, candidates_of_all = 0;
  for (Scene& scene : scenes(rng, 2)) {
    for (const double drift : {0.0, 1000.0}) {
      for (const double way : {1.5, 40.0}) {
        Scene fall = scene;
        for (std::size_t i = 0; i < fall.x0.size(); ++i) {
          for (std::size_t k = 0; k < fall.x0[i].size(); ++k) {
            fall.x0[i][k] += i == 0 && k % 3 == 0 ? 2 : 0;
            fall.x1[i][k] += (i == 0 && k % 3 == 0 ? 2 - way : 0) + drift;
          }
        }
        // A vertex of no triangle, of a size of its own, changes nothing.
        const double far = rng() % 2 == 0 ? 1e300 : 1e20;
        fall.topologies[0] = with_isolated_vertex(fall.topologies[0]);
        for (int axis = 0; axis < 3; ++axis) {
          fall.x0[0].push_back(far);
          fall.x1[0].push_back(-far);
        }
        StepSettings settings;
        const StepResult all = run(fall, settings, 4);
        hits += all.count();
        settings.earliest_only = true;
        const StepResult first = run(fall, settings, 4);
        in_stretches += first.work.refits > 2;
        candidates += first.work.candidates_vf + first.work.candidates_ee;
        candidates_of_all += all.work.candidates_vf + all.work.candidates_ee;
        ASSERT_NO_FATAL_FAILURE(expect_earliest(first, all)) << way << ", " << drift;
      }
    }
  }
  EXPECT_GT(hits, 50u);
  EXPECT_GT(in_stretches, 4u);
  EXPECT_LT(2 * candidates, candidates_of_all);
}

// However far objects fly apart, there are few stretches.
TEST(LongSteps, ThatNeverMeetAreQuick) {
  for (const double way : {1e3, 1e6}) {
    Scene scene;
    Rng rng(3);
    const Mesh mesh = mesh_families()[0].make(rng);
    for (const double side : {-1.0, 1.0}) {
      scene.topologies.push_back(mesh.topology());
      scene.x0.push_back(mesh.positions);
      scene.x1.push_back(mesh.positions);
      for (std::size_t i = 0; i < mesh.positions.size(); i += 3) {
        scene.x0.back()[i] += 10 * side;
        scene.x1.back()[i] += way * side;
      }
    }
    StepSettings settings;
    settings.earliest_only = true;
    settings.tolerance = 1e-4;  // that of the extent is larger than the objects
    const StepResult found = run(scene, settings, 4);
    EXPECT_TRUE(found.clean()) << way;
    EXPECT_LT(found.work.refits, 2u * 40u) << way;
  }
}

// The certificates of a checker depend on earlier steps: that may change its work, never its answer.
TEST_P(QueryProperties, AReusedCheckerGivesTheSameAnswer) {
  Rng rng(56);
  const Scene scene = scenes(rng, 2)[1];
  const auto x0 = scene.spans0(), x1 = scene.spans1();
  for (const bool certificates : {false, true}) {
    StepChecker checker(scene.hierarchies(16));
    StepResult fresh, reused;
    StepSettings settings, other;
    settings.certificates = other.certificates = certificates;
    ASSERT_TRUE(checker.check(x0, x1, settings, fresh));
    EXPECT_FALSE(fresh.clean());
    other.thickness = 0.05;
    ASSERT_TRUE(checker.check(x1, x0, other, reused));
    ASSERT_TRUE(checker.check(x0, x1, settings, reused));
    expect_bits_equal(reused, fresh, !certificates);
  }
}

// ---- Symmetries. Times and near misses may round differently; contacts may not be lost.

template <class Collision>
void expect_same_contacts(const std::vector<Collision>& a, const std::set<PairKey>& b, const Scene& scene) {
  for (const Collision& pair : a) {
    if (b.count(key(pair))) continue;
    constexpr Kind kind = std::is_same_v<Collision, VertexFaceCollision> ? Kind::VertexFace : Kind::EdgeEdge;
    const PairPoints p = points_of(pair, scene);
    EXPECT_FALSE(touches(kind, p.x0, p.x1)) << "only one of two views reports " << name(key(pair));
  }
}

template <class Collision>
std::set<PairKey> keys(const std::vector<Collision>& pairs) {
  std::set<PairKey> result;
  for (const Collision& pair : pairs) result.insert(key(pair));
  return result;
}

void expect_same_contacts(const StepResult& a, const StepResult& b, const Scene& scene) {
  expect_same_contacts(a.vertex_face, keys(b.vertex_face), scene);
  expect_same_contacts(b.vertex_face, keys(a.vertex_face), scene);
  expect_same_contacts(a.edge_edge, keys(b.edge_edge), scene);
  expect_same_contacts(b.edge_edge, keys(a.edge_edge), scene);
  EXPECT_FALSE(a.clean() && b.clean());
}

TEST_P(QueryProperties, TimeReversal) {
  Rng rng(57);
  const Scene scene = scenes(rng, 1)[3];
  Scene reversed = scene;
  std::swap(reversed.x0, reversed.x1);
  expect_same_contacts(run(scene, {}, 16), run(reversed, {}, 16), scene);
}

TEST_P(QueryProperties, RigidMotionAndScaleThatAreExact) {
  Rng rng(58);
  const Scene scene = scenes(rng, 2)[3];
  Scene turned = scene;
  for (auto* x : {&turned.x0, &turned.x1}) {
    for (auto& object : *x) {
      for (std::size_t v = 0; v < object.size() / 3; ++v) {
        const Vec3 p(object[3 * v], object[3 * v + 1], object[3 * v + 2]);
        // On a grid of eighths, so the shift is exact.
        object[3 * v] = 0x1p10 * (-p.y() + 0x1p20);
        object[3 * v + 1] = 0x1p10 * (p.z() - 77);
        object[3 * v + 2] = 0x1p10 * (-p.x() + 3);
      }
    }
  }
  expect_same_contacts(run(scene, {}, 16), run(turned, {}, 16), scene);
}

TEST_P(QueryProperties, Renumbering) {
  Rng rng(59);
  const Scene scene = scenes(rng, 1)[3];
  const Topology& topology = scene.topologies[0];
  std::vector<Index> new_vertex(topology.vertex_count()), new_face(topology.triangles().size());
  for (Index i = 0; i < new_vertex.size(); ++i) new_vertex[i] = i;
  for (Index i = 0; i < new_face.size(); ++i) new_face[i] = i;
  std::shuffle(new_vertex.begin(), new_vertex.end(), rng);
  const auto lines = new_face.begin() + topology.face_count(), points = lines + topology.line_count();
  std::shuffle(new_face.begin(), lines, rng);
  std::shuffle(lines, points, rng);
  std::shuffle(points, new_face.end(), rng);

  Mesh mesh;
  mesh.vertex_count = topology.vertex_count();
  mesh.triangles.resize(topology.face_count());
  mesh.lines.resize(topology.line_count());
  mesh.points.resize(topology.point_count());
  for (Index f = 0; f < new_face.size(); ++f) {
    Triangle t = topology.triangles()[f];
    for (Index& v : t) v = new_vertex[v];
    const Index id = new_face[f];
    if (topology.element(f) == Element::Face) {
      std::rotate(t.begin(), t.begin() + rng() % 3, t.end());
      mesh.triangles[id] = t;
    } else if (topology.element(f) == Element::Line) {
      mesh.lines[id - topology.face_count()] = {t[0], t[1]};
    } else {
      mesh.points[id - topology.face_count() - topology.line_count()] = t[0];
    }
  }
  Scene renumbered = scene;
  renumbered.topologies[0] = mesh.topology();
  for (Index v = 0; v < new_vertex.size(); ++v) {
    for (int k = 0; k < 3; ++k) {
      renumbered.x0[0][3 * new_vertex[v] + k] = scene.x0[0][3 * v + k];
      renumbered.x1[0][3 * new_vertex[v] + k] = scene.x1[0][3 * v + k];
    }
  }
  StepResult expected = run(scene, {}, 16);
  for (VertexFaceCollision& c : expected.vertex_face) {
    c.vertex = new_vertex[c.vertex];
    c.face = new_face[c.face];
  }
  for (EdgeEdgeCollision& c : expected.edge_edge) {
    for (Edge* e : {&c.a, &c.b}) {
      *e = {new_vertex[(*e)[0]], new_vertex[(*e)[1]]};
      std::sort(e->begin(), e->end());
    }
    if (c.b < c.a) std::swap(c.a, c.b);
  }
  StepResult found = run(renumbered, {}, 16);
  // Which of two points is the vertex depends on their numbers.
  for (StepResult* result : {&expected, &found}) {
    std::erase_if(result->vertex_face, [&](const VertexFaceCollision& c) {
      return renumbered.topologies[0].element(c.face) == Element::Point;
    });
  }
  expect_same_contacts(expected, found, renumbered);
}

INSTANTIATE_TEST_SUITE_P(Meshes, QueryProperties,
                         ::testing::ValuesIn(mesh_families().begin(), mesh_families().end()),
                         [](const auto& instance) { return std::string(instance.param.name); });

}  // namespace
}  // namespace foldproof::oracle
