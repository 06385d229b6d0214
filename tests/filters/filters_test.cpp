// The answer with a filter is that of all pairs by brute force, without those that it ignores by its
// definition.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>

#include "foldproof/contacts.h"
#include "foldproof/filters.h"
#include "foldproof/solver.h"
#include "oracle/meshes.h"
#include "oracle/same_answers.h"

namespace foldproof::oracle {
namespace {

using Vertex = std::pair<Index, Index>;  // object, vertex
using Feature = std::vector<Vertex>;

// What a filter ignores, by its definition.
struct Definition {
  std::function<bool(const Feature&, const Feature&)> features;
  std::function<bool(const TriangleCrossing&)> crossing = {};  // else as of features with these vertices
};

template <class Ids>
Feature feature(Index object, const Ids& ids) {
  Feature out;
  for (const Index v : ids) out.emplace_back(object, v);
  return out;
}

Feature triangle(const Scene& scene, Index object, Index t) {
  return feature(object, scene.topologies[object].triangles()[t]);
}

StaticResult crossings_of(const Scene& scene, const std::vector<Object>& objects) {
  StaticResult pose;
  EXPECT_TRUE(StepChecker(objects).check_static(scene.spans0(), {.certificates = false}, pose));
  return pose;
}

struct Found {
  std::size_t kept = 0, ignored = 0;
};

void expect_filtered(const Scene& scene, const std::vector<Object>& objects,
                     std::shared_ptr<const PairFilter> filter, const Definition& ignores, Found& found) {
  StepChecker checker(objects, std::move(filter));
  StepResult step;
  StaticResult pose;
  ASSERT_TRUE(checker.check(scene.spans0(), scene.spans1(), {}, step));
  ASSERT_TRUE(checker.check_static(scene.spans0(), {}, pose));
  StepResult all;
  StaticResult all_pose = crossings_of(scene, objects);
  ASSERT_TRUE(StepChecker(objects).check(scene.spans0(), scene.spans1(), {.certificates = false}, all));
  const auto keep = [&](auto& pairs, auto is_ignored) {
    std::ranges::sort(pairs, {}, [](const auto& pair) { return key(pair); });
    found.ignored += std::erase_if(pairs, is_ignored);
    found.kept += pairs.size();
  };
  keep(all.vertex_face, [&](const VertexFaceCollision& c) {
    return ignores.features({{c.vertex_object, c.vertex}}, triangle(scene, c.face_object, c.face));
  });
  keep(all.edge_edge, [&](const EdgeEdgeCollision& c) {
    return ignores.features(feature(c.object_a, c.a), feature(c.object_b, c.b));
  });
  keep(all_pose.crossings, [&](const TriangleCrossing& c) {
    if (ignores.crossing) return ignores.crossing(c);
    return ignores.features(triangle(scene, c.object_a, c.triangle_a),
                            triangle(scene, c.object_b, c.triangle_b));
  });
  EXPECT_TRUE(same_collisions(step, all));
  EXPECT_TRUE(same_crossings(pose, all_pose));
}

// Ignores features of which any two vertices belong together.
Definition any_of(std::function<bool(Vertex, Vertex)> together) {
  return {[together](const Feature& a, const Feature& b) {
    for (const Vertex& i : a) {
      for (const Vertex& k : b) {
        if (together(i, k)) return true;
      }
    }
    return false;
  }};
}

// Lengths of all shortest paths along edges (Floyd and Warshall).
std::vector<std::vector<double>> path_lengths(const Topology& topology, std::span<const double> x,
                                              bool unit) {
  const Index n = topology.vertex_count();
  std::vector<std::vector<double>> length(n, std::vector<double>(n, std::numeric_limits<double>::infinity()));
  for (Index v = 0; v < n; ++v) length[v][v] = 0;
  for (const Triangle& t : topology.triangles()) {
    for (int k = 0; k < 3; ++k) {
      const Index a = t[k], b = t[(k + 1) % 3];
      if (a != b)
        length[a][b] = length[b][a] = unit ? 1 : (Vec3::load(&x[3 * a]) - Vec3::load(&x[3 * b])).norm();
    }
  }
  for (Index via = 0; via < n; ++via) {
    for (Index a = 0; a < n; ++a) {
      for (Index b = 0; b < n; ++b) length[a][b] = std::min(length[a][b], length[a][via] + length[via][b]);
    }
  }
  return length;
}

// Ignores features of one object with a path of at most this length between any two vertices.
Definition neighbors(const Scene& scene, bool unit, double most) {
  std::vector<std::vector<std::vector<double>>> lengths;
  for (std::size_t i = 0; i < scene.topologies.size(); ++i)
    lengths.push_back(path_lengths(scene.topologies[i], scene.x0[i], unit));
  return any_of([lengths, most](Vertex a, Vertex b) {
    return a.first == b.first && lengths[a.first][a.second][b.second] <= most;
  });
}

// Ignores features all of whose vertices are fixed.
Definition all_fixed(const std::vector<std::vector<std::uint8_t>>& fixed) {
  return {[fixed](const Feature& a, const Feature& b) {
    const auto is_fixed = [&](Vertex v) { return fixed[v.first][v.second] != 0; };
    return std::ranges::all_of(a, is_fixed) && std::ranges::all_of(b, is_fixed);
  }};
}

class Filters : public ::testing::TestWithParam<MeshFamily> {
 protected:
  // Of one or two objects.
  Scene scene(Index seed) {
    rng_.seed(seed);
    Scene scene;
    for (std::size_t i = 0; i < 1 + seed % 2; ++i) {
      const Mesh mesh = GetParam().make(rng_);
      scene.topologies.push_back(mesh.topology());
      scene.x0.push_back(deformed(mesh.positions, 0.2, seed % 2 == 0 ? 0 : 1.0 / 32, rng_));
      scene.x1.push_back(deformed(scene.x0.back(), 0.3, seed % 2 == 0 ? 0 : 1.0 / 32, rng_));
    }
    return scene;
  }
  Rng rng_;
  Found found_;
};

TEST_P(Filters, SewnVerticesCountAsOne) {
  for (Index seed = 0; seed < 2; ++seed) {
    const Scene scene = this->scene(seed);
    const auto objects = scene.hierarchies(4);
    std::vector<std::array<ObjectVertex, 2>> seams;
    std::set<std::pair<Vertex, Vertex>> sewn;
    const auto any = [&] {
      const auto object = static_cast<Index>(rng_() % objects.size());
      return ObjectVertex{object, static_cast<Index>(rng_() % scene.topologies[object].vertex_count())};
    };
    for (Index k = 0; k < 2 * scene.topologies[0].vertex_count(); ++k) {
      const ObjectVertex a = any(), b = any();
      seams.push_back({a, b});
      if (a.object == b.object && a.vertex == b.vertex) continue;  // it is not sewn
      sewn.insert({{a.object, a.vertex}, {b.object, b.vertex}});
      sewn.insert({{b.object, b.vertex}, {a.object, a.vertex}});
    }
    const auto together = [&](Vertex a, Vertex b) { return sewn.contains({a, b}); };
    ASSERT_NO_FATAL_FAILURE(
        expect_filtered(scene, objects, ignore_sewn(objects, seams).value(), any_of(together), found_));
  }
  EXPECT_GT(found_.kept, 5u);
  EXPECT_GT(found_.ignored, 5u);
}

TEST_P(Filters, NeighborsAreWithinRingsOrALength) {
  for (Index seed = 0; seed < 4; ++seed) {
    const Scene scene = this->scene(seed);
    const auto objects = scene.hierarchies(4);
    const bool unit = seed < 2;
    const double most = unit ? seed : 0.15 * (seed - 1);
    const auto filter = unit ? ignore_rings(objects, seed) : ignore_length(objects, scene.spans0(), most);
    ASSERT_NO_FATAL_FAILURE(
        expect_filtered(scene, objects, filter.value(), neighbors(scene, unit, most), found_));
  }
  EXPECT_GT(found_.kept, 5u);
  if (std::string_view(GetParam().name) != "soup") {  // whose triangles have no neighbors
    EXPECT_GT(found_.ignored, 5u);
  }
}

TEST_P(Filters, FixedVerticesDoNotMeet) {
  for (Index seed = 0; seed < 4; ++seed) {
    const Scene scene = this->scene(seed);
    const auto objects = scene.hierarchies(4);
    std::vector<std::vector<std::uint8_t>> fixed;
    for (std::size_t i = 0; i < objects.size(); ++i) {
      auto& of = fixed.emplace_back(scene.topologies[i].vertex_count());
      for (std::size_t v = 0; v < of.size(); ++v)
        of[v] = seed == 1 ? (i == 0 ? 7 : 0) : scene.x0[i][3 * v] > 0 || rng_() % 4 == 0;
    }
    ASSERT_NO_FATAL_FAILURE(
        expect_filtered(scene, objects, ignore_fixed(objects, fixed).value(), all_fixed(fixed), found_));
  }
  EXPECT_GT(found_.kept, 5u);
  EXPECT_GT(found_.ignored, 5u);
}

TEST_P(Filters, WhatTouchesInAPoseIsIgnored) {
  for (Index seed = 0; seed < 4; ++seed) {
    const Scene scene = this->scene(seed);
    const auto objects = scene.hierarchies(4);
    const double thickness = seed < 2 ? 0 : 0.02;
    StepResult touching;
    ASSERT_TRUE(
        StepChecker(objects).check(scene.spans0(), scene.spans0(), {.thickness = thickness}, touching));
    std::set<std::set<Feature>> pairs;
    for (const auto& c : touching.vertex_face)
      pairs.insert({{{c.vertex_object, c.vertex}}, triangle(scene, c.face_object, c.face)});
    for (const auto& c : touching.edge_edge)
      pairs.insert({feature(c.object_a, c.a), feature(c.object_b, c.b)});
    // Everything that crosses in this pose is ignored.
    const Definition ignores{[&](const Feature& a, const Feature& b) {
                               return pairs.contains({a, b});
                             },
                             [](const TriangleCrossing&) { return true; }};
    ASSERT_NO_FATAL_FAILURE(expect_filtered(
        scene, objects, ignore_touching(objects, scene.spans0(), thickness).value(), ignores, found_));
  }
  EXPECT_GT(found_.kept, 5u);
  EXPECT_GT(found_.ignored, 5u);
}

// In other poses: what crosses there and has no features that are ignored.
TEST_P(Filters, TrianglesAroundWhatTouchesAreIgnored) {
  for (Index seed = 0; seed < 4; ++seed) {
    Scene scene = this->scene(seed);
    const auto objects = scene.hierarchies(4);
    const auto filter = ignore_touching(objects, scene.spans0(), 0.01).value();
    std::set<PairKey> from_start;
    for (const auto& c : crossings_of(scene, objects).crossings) from_start.insert(key(c));
    scene.x0 = scene.x1;
    StaticResult pose;
    ASSERT_TRUE(StepChecker(objects, filter).check_static(scene.spans0(), {}, pose));
    std::set<PairKey> kept;
    for (const auto& c : pose.crossings) kept.insert(key(c));
    for (const auto& c : crossings_of(scene, objects).crossings) {
      const Triangle &a = scene.topologies[c.object_a].triangles()[c.triangle_a],
                     &b = scene.topologies[c.object_b].triangles()[c.triangle_b];
      bool tested = !from_start.contains(key(c));
      for (int i = 0; i < 3; ++i) {
        tested = tested && filter->vertex_face(c.object_a, a[i], c.object_b, c.triangle_b) &&
                 filter->vertex_face(c.object_b, b[i], c.object_a, c.triangle_a);
        for (int k = 0; k < 3; ++k)
          tested = tested &&
                   filter->edge_edge(c.object_b, {b[(k + 1) % 3], b[k]}, c.object_a, {a[i], a[(i + 1) % 3]});
      }
      ASSERT_EQ(kept.contains(key(c)), tested);
      ++(tested ? found_.kept : found_.ignored);
    }
  }
  EXPECT_GT(found_.kept, 5u);
  EXPECT_GT(found_.ignored, 5u);
}

TEST_P(Filters, SeveralIgnoreWhatAnyIgnores) {
  for (Index seed = 0; seed < 4; ++seed) {
    const Scene scene = this->scene(seed);
    const auto objects = scene.hierarchies(4);
    std::vector<std::vector<std::uint8_t>> fixed;
    for (std::size_t i = 0; i < objects.size(); ++i) {
      for (auto& of = fixed.emplace_back(); of.size() < scene.topologies[i].vertex_count();)
        of.push_back(of.size() % 3 != 0);
    }
    const auto filter = ignore_all({ignore_fixed(objects, fixed).value(), ignore_rings(objects, 1).value()});
    const Definition ignores{
        [fixed = all_fixed(fixed), near = neighbors(scene, true, 1)](const Feature& a, const Feature& b) {
          return fixed.features(a, b) || near.features(a, b);
        }};
    ASSERT_NO_FATAL_FAILURE(expect_filtered(scene, objects, filter, ignores, found_));
  }
  EXPECT_GT(found_.kept, 5u);
  EXPECT_GT(found_.ignored, 5u);
}

// ContactFinder follows what crosses from step to step, and must come to what a pose says.
TEST_P(Filters, ContactsCrossAsStaticQueriesSay) {
  for (Index seed = 0; seed < 6; ++seed) {
    Scene scene = this->scene(seed);
    const auto objects = scene.hierarchies(4);
    std::vector<const Topology*> topologies;
    for (const Topology& topology : scene.topologies) topologies.push_back(&topology);
    const auto filter = seed < 2   ? ignore_rings(objects, 1)
                        : seed < 4 ? ignore_touching(objects, scene.spans0(), 0.01)
                                   : ignore_length(objects, scene.spans0(), 0.2);
    StepChecker checker(objects, filter.value());
    auto finder = ContactFinder::make(topologies, {}, filter.value()).value();
    StaticResult start, crossings;
    StepResult step;
    ASSERT_TRUE(checker.check_static(scene.spans0(), {}, start));
    finder.start(0, scene.spans0(), start);
    for (int k = 0; k < 3; ++k) {
      ASSERT_TRUE(checker.check(scene.spans0(), scene.spans1(), {}, step));
      finder.step(k, k + 1, scene.spans0(), scene.spans1(), step);
      ASSERT_TRUE(checker.check_static(scene.spans1(), {}, crossings));
      StaticResult got;
      got.crossings.assign(finder.crossings().begin(), finder.crossings().end());
      ASSERT_TRUE(same_crossings(got, crossings)) << "seed " << seed << ", step " << k;
      found_.kept += crossings.crossings.size();
      scene.x0 = scene.x1;
      for (auto& x : scene.x1) x = deformed(x, 0.2, seed % 2 == 0 ? 0 : 1.0 / 32, rng_);
    }
  }
  EXPECT_GT(found_.kept, 5u);
}

INSTANTIATE_TEST_SUITE_P(Families, Filters, ::testing::ValuesIn(mesh_families()),
                         [](const auto& info) { return info.param.name; });

// Two sheets beside each other, sewn along an edge; the second folds over the first and meets it.
TEST(SolverFilter, AppliesToAllQueriesOfAChecker) {
  constexpr Index kCells = 6, kRow = kCells + 1;
  std::vector<double> flat, folded;
  std::vector<Triangle> faces;
  for (const Index panel : {0u, 1u}) {
    for (Index i = 0; i <= kCells; ++i) {
      for (Index k = 0; k <= kCells; ++k) {
        const double across = double(i) / kCells, along = double(k) / kCells;
        flat.insert(flat.end(), {panel + across, along, 0});
        folded.insert(folded.end(), {panel == 0 ? across : 1 - across * 0.9, along,
                                     panel == 0 ? 0 : 0.3 * across * (1.7 - 2 * across)});
        if (i == 0 || k == 0) continue;
        const Index d = panel * kRow * kRow + i * kRow + k;
        faces.push_back({d - kRow - 1, d - kRow, d});
        faces.push_back({d - kRow - 1, d, d - 1});
      }
    }
  }
  const auto mesh = std::make_shared<const CollisionMesh>(CollisionMesh::make(flat, {}, faces).value());
  std::vector<std::array<ObjectVertex, 2>> seams;
  for (Index k = 0; k < kRow; ++k) seams.push_back({{{0, kCells * kRow + k}, {0, kRow * kRow + k}}});
  const std::vector<Object> objects{mesh->hierarchy()};
  ContactChecker open(mesh), sewn(mesh, {}, ignore_sewn(objects, seams).value());
  // Unsewn, they touch from the start.
  EXPECT_EQ(open.collision_free_step_size(flat, folded).value().limit, StepSize::Limit::Start);
  EXPECT_TRUE(open.has_intersections(flat).is_yes());
  EXPECT_EQ(open.minimum_distance(flat, 1).value(), 0);
  const StepSize size = sewn.collision_free_step_size(flat, folded).value();
  EXPECT_EQ(size.limit, StepSize::Limit::Contact);
  EXPECT_GT(size.share, 0.3);
  EXPECT_TRUE(sewn.has_intersections(flat).is_no());
  EXPECT_TRUE(sewn.has_intersections(folded).is_yes());
  EXPECT_NEAR(sewn.minimum_distance(flat, 1).value(), 0.5 * std::sqrt(0.5) / kCells * 2, 1e-12);
  std::vector<ClosePair> at_seam, all;
  ASSERT_TRUE(sewn.close_pairs(flat, 0.01, at_seam));
  ASSERT_TRUE(open.close_pairs(flat, 0.01, all));
  EXPECT_EQ(at_seam.size(), 0u);
  EXPECT_GT(all.size(), kRow - 1);
}

// Nodes that are fixed are not even visited.
TEST(FilterWork, FixedAgainstFixedCostsNothing) {
  Rng rng(3);
  const Mesh mesh = mesh_families()[0].make(rng);
  const auto hierarchy =
      std::make_shared<const Hierarchy>(Hierarchy::build(mesh.topology(), mesh.positions).value());
  const std::vector<Object> objects{hierarchy, hierarchy};
  const auto work = [&](std::uint8_t first, std::uint8_t second) {
    const std::vector<std::vector<std::uint8_t>> fixed{std::vector<std::uint8_t>(mesh.vertex_count, first),
                                                       std::vector<std::uint8_t>(mesh.vertex_count, second)};
    StepChecker checker(objects, ignore_fixed(objects, fixed).value());
    const std::span<const double> x[] = {mesh.positions, mesh.positions};
    StepResult step;
    EXPECT_TRUE(checker.check(x, x, {}, step));
    return step.work;
  };
  EXPECT_EQ(work(1, 1).node_tests, 0u);
  EXPECT_GT(work(1, 0).candidates_vf, 0u);
  EXPECT_LT(work(1, 0).node_tests, work(0, 0).node_tests);
}

TEST(Filter, RefusesInvalidInput) {
  const std::vector<double> x = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  const std::vector<Object> objects{Hierarchy::build(Topology::make(3, {{0, 1, 2}}).value(), x).value()};
  const auto line = [](const auto& filter) { return filter ? std::string() : filter.error().line(); };
  const std::array<ObjectVertex, 2> beyond[] = {{{{0, 0}, {0, 3}}}}, no_object[] = {{{{1, 0}, {0, 1}}}};
  EXPECT_EQ(line(ignore_sewn(objects, beyond)),
            "seam 0: names vertex 3 of object 0, which is not there; count both from 0");
  EXPECT_EQ(line(ignore_sewn(objects, no_object)),
            "seam 0: names vertex 0 of object 1, which is not there; count both from 0");
  EXPECT_EQ(line(ignore_length(objects, x, -1)), "length: is not a length; give a number of at least 0");
  EXPECT_EQ(line(ignore_length(objects, std::span(x).first(3), 1)),
            "positions of object 0: are not finite, or of another number of vertices; give three numbers for "
            "each of 3 vertices");
  const std::vector<std::vector<std::uint8_t>> none, few{{1, 0}};
  EXPECT_EQ(line(ignore_fixed(objects, none)),
            "fixed: is for 0 objects instead of 1; give a list for each object");
  EXPECT_EQ(line(ignore_fixed(objects, few)),
            "fixed of object 0: has 2 numbers; give one for each of the 3 vertices");
  EXPECT_FALSE(ignore_touching(objects, std::span(x).first(6)));
  EXPECT_FALSE(ignore_touching(objects, x, -1));
}

}  // namespace
}  // namespace foldproof::oracle
