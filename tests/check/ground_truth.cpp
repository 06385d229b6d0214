// Published steps and single queries with symbolic ground truth. No collision may be missed.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "foldproof/check.h"
#include "oracle/brute_force.h"
#include "oracle/data.h"
#include "oracle/judge.h"

namespace foldproof::oracle {
namespace {

Scene read_step(const std::filesystem::path& directory) {
  Scene scene;
  for (const char* frame : {"frame_0.ply", "frame_1.ply"}) {
    const auto motion = open_motion({(directory / frame).string()});
    if (scene.topologies.empty()) scene.topologies.push_back(motion->topology());
    std::vector<double> x(3 * motion->topology().vertex_count());
    const Result<void> read = motion->read_frame(0, x);
    if (!read) throw std::runtime_error(read.error().line());
    (scene.x0.empty() ? scene.x0 : scene.x1).push_back(std::move(x));
  }
  return scene;
}

// Keys have each edge's smaller vertex first, and the smaller edge first.
PairKey edge_key(const std::vector<Index>& ids) {
  std::array<Edge, 2> e = {Edge{ids[0], ids[1]}, Edge{ids[2], ids[3]}};
  for (Edge& edge : e) std::sort(edge.begin(), edge.end());
  if (e[1] < e[0]) std::swap(e[0], e[1]);
  return {0, e[0][0], e[0][1], 0, e[1][0], e[1][1]};
}

struct Count {
  int listed = 0, missed = 0, extra = 0, extra_true = 0, extra_false = 0;
};

template <class Collision>
Count compare(const std::vector<Collision>& reported, const std::set<PairKey>& truth, const Scene& scene,
              double tolerance) {
  constexpr Kind kind = std::is_same_v<Collision, VertexFaceCollision> ? Kind::VertexFace : Kind::EdgeEdge;
  Count count;
  count.listed = static_cast<int>(truth.size());
  std::set<PairKey> found;
  CcdSettings settings;
  settings.tolerance = tolerance;
  for (const Collision& pair : reported) {
    found.insert(key(pair));
    if (truth.count(key(pair))) continue;
    ++count.extra;
    const PairPoints p = points_of(pair, scene);
    const Verdict verdict = judge(kind, p.x0, p.x1, settings, {pair.answer, pair.toi});
    EXPECT_EQ(verdict.complaint, "") << describe(kind, p.x0, p.x1, settings);
    ++(verdict.touched ? count.extra_true : count.extra_false);
  }
  for (const PairKey& pair : truth) {
    if (found.count(pair)) continue;
    ++count.missed;
    ADD_FAILURE() << "missed " << pair[1] << " " << pair[2] << " " << pair[3] << " " << pair[4] << " "
                  << pair[5];
  }
  return count;
}

void print(const char* scene, const char* kind, const Count& c) {
  fmt::print(
      "{:13} {}: {:6} listed, {} missed; {} beyond the list: {} touch by the exact oracle, {} within "
      "tolerance only\n",
      scene, kind, c.listed, c.missed, c.extra, c.extra_true, c.extra_false);
}

class RealGroundTruth : public ::testing::TestWithParam<const char*> {};

TEST_P(RealGroundTruth, EveryListedCollisionIsReported) {
  const auto data = data_directory();
  if (!data) GTEST_SKIP() << kNoData;
  const auto directory = *data / "ccd-ground-truth" / GetParam();
  const Scene scene = read_step(directory);
  std::set<PairKey> vf, ee;
  for (const ListedPair& pair : read_truth(directory / "truth_vf.csv")) {
    if (pair.collides) vf.insert({0, pair.ids[0], 0, pair.ids[1], 0, 0});
  }
  for (const ListedPair& pair : read_truth(directory / "truth_ee.csv")) {
    if (pair.collides) ee.insert(edge_key(pair.ids));
  }
  ASSERT_FALSE(vf.empty());
  ASSERT_FALSE(ee.empty());

  StepChecker checker(scene.hierarchies(16));
  StepResult result;
  const auto x0 = scene.spans0(), x1 = scene.spans1();
  const Result<void> done = checker.check(x0, x1, {}, result);
  ASSERT_TRUE(done) << done.error().line();
  print(GetParam(), "vertex-face", compare(result.vertex_face, vf, scene, result.tolerance));
  print(GetParam(), "edge-edge  ", compare(result.edge_edge, ee, scene, result.tolerance));
}

// A sample of the lists compared with the exact oracle, to test the oracle.
TEST_P(RealGroundTruth, OracleAgreesWithTheLists) {
  const auto data = data_directory();
  if (!data) GTEST_SKIP() << kNoData;
  const auto directory = *data / "ccd-ground-truth" / GetParam();
  const Scene scene = read_step(directory);
  const auto faces = read_truth(directory / "truth_vf.csv"), edges = read_truth(directory / "truth_ee.csv");
  constexpr std::size_t kSample = 3000;
  for (std::size_t i = 0; i < faces.size(); i += 1 + faces.size() / kSample) {
    const PairPoints p = points_of(VertexFaceCollision{0, faces[i].ids[0], 0, faces[i].ids[1], 0, {}}, scene);
    EXPECT_EQ(touches(Kind::VertexFace, p.x0, p.x1), faces[i].collides)
        << faces[i].ids[0] << " " << faces[i].ids[1];
  }
  for (std::size_t i = 0; i < edges.size(); i += 1 + edges.size() / kSample) {
    const auto& ids = edges[i].ids;
    const PairPoints p = points_of(EdgeEdgeCollision{0, {ids[0], ids[1]}, 0, {ids[2], ids[3]}, 0, {}}, scene);
    EXPECT_EQ(touches(Kind::EdgeEdge, p.x0, p.x1), edges[i].collides)
        << ids[0] << " " << ids[1] << " " << ids[2] << " " << ids[3];
  }
}

INSTANTIATE_TEST_SUITE_P(Steps, RealGroundTruth, ::testing::Values("cloth-ball", "rod-twist", "cloth-funnel"),
                         [](const auto& instance) {
                           std::string name = instance.param;
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

TEST(RealGroundTruthQueries, EveryHitIsReported) {
  const auto data = data_directory();
  if (!data) GTEST_SKIP() << kNoData;
  int hits = 0, extra = 0, undecided = 0;
  const std::vector<Query> queries = read_queries(*data);
  for (const Query& q : queries) {
    for (const double tolerance : {0.0, 0x1p-30, 0x1p-20}) {
      CcdSettings settings;
      settings.tolerance = tolerance;
      const CcdResult result = narrow_phase(q.kind, q.x0, q.x1, settings);
      EXPECT_EQ(judge(q.kind, q.x0, q.x1, settings, result).complaint, "")
          << q.source << " " << describe(q.kind, q.x0, q.x1, settings);
      EXPECT_FALSE(q.collides && result.answer == Answer::Separated) << q.source;
      if (tolerance != 0x1p-30) continue;
      hits += q.collides;
      extra += !q.collides && result.answer == Answer::Hit;
      undecided += result.answer == Answer::Undecided;
    }
  }
  EXPECT_GT(hits, 0);
  fmt::print("{} queries, {} hits, none missed; {} further hits within 2^-30, {} undecided\n", queries.size(),
             hits, extra, undecided);
}

}  // namespace
}  // namespace foldproof::oracle
