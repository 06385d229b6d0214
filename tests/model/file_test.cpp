// Models as files: what is written reads back, and damaged files are refused or harmless.
#include <gmock/gmock.h>

#include <algorithm>
#include <numeric>

#include "certificate/library.h"
#include "foldproof/check.h"
#include "io/support.h"
#include "model/cylinder.h"

namespace foldproof::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

std::string golden_path(const std::string& version) {
  return std::string(FOLDPROOF_SOURCE_DIR) + "/tests/model/golden/version" + version + ".model";
}
std::string golden_path(int version) { return golden_path(std::to_string(version)); }

/// Byte offset of the format version, the root table's first field.
std::size_t version_at(const std::string& bytes) {
  const auto load = [&]<class T>(std::size_t at, T value) {
    std::memcpy(&value, bytes.data() + at, sizeof(T));
    return value;
  };
  const std::size_t root = 4 + load(4, std::uint32_t{});
  return root + load(root - load(root, std::int32_t{}) + 4, std::uint16_t{});
}

class ModelFileTest : public ::testing::Test {
 protected:
  std::string saved(const Model& model) {
    const auto done = save_model(model, files.path("a.model"));
    EXPECT_TRUE(done) << done.error().line();
    return read_bytes(files.path("a.model"));
  }
  Result<Model> loaded(std::string_view bytes) { return load_model(files.write("b.model", bytes)); }
  std::string load_error(std::string_view bytes) {
    const auto model = loaded(bytes);
    if (model) return "no error";
    EXPECT_EQ(model.error().line().find('\n'), std::string::npos);
    EXPECT_FALSE(model.error().remedy.empty());
    EXPECT_THAT(model.error().where, StartsWith(files.path("b.model")));
    return model.error().line().substr(files.path("").size());
  }
  ScratchDirectory files;
};

void expect_same(const Model& a, const Model& b) {
  EXPECT_EQ(a.program, b.program);
  EXPECT_EQ(a.settings.references, b.settings.references);
  EXPECT_EQ(a.settings.max_triangles, b.settings.max_triangles);
  ASSERT_EQ(a.poses.size(), b.poses.size());
  for (std::size_t k = 0; k < a.poses.size(); ++k) {
    EXPECT_EQ(a.poses[k].name, b.poses[k].name);
    EXPECT_EQ(a.poses[k].reference, b.poses[k].reference);
    EXPECT_EQ(a.poses[k].proven, b.poses[k].proven);
  }
  ASSERT_EQ(a.hard_leaves.size(), b.hard_leaves.size());
  for (std::size_t k = 0; k < a.hard_leaves.size(); ++k) {
    EXPECT_EQ(a.hard_leaves[k].leaf, b.hard_leaves[k].leaf);
    EXPECT_EQ(a.hard_leaves[k].references, b.hard_leaves[k].references);
    EXPECT_EQ(a.hard_leaves[k].obstacle, b.hard_leaves[k].obstacle);
  }
  EXPECT_EQ(a.hierarchy()->topology(), b.hierarchy()->topology());
  EXPECT_TRUE(std::ranges::equal(a.hierarchy()->triangle_ids(), b.hierarchy()->triangle_ids()));
  EXPECT_TRUE(std::ranges::equal(a.hierarchy()->vertex_ids(), b.hierarchy()->vertex_ids()));
  EXPECT_TRUE(std::ranges::equal(a.hierarchy()->edge_ids(), b.hierarchy()->edge_ids()));
  const ChartLibrary &ca = *a.charts, &cb = *b.charts;
  ASSERT_EQ(ca.charts().size(), cb.charts().size());
  for (std::size_t k = 0; k < ca.charts().size(); ++k) {
    const auto &x = ca.charts()[k], &y = cb.charts()[k];
    EXPECT_EQ(x.slot, y.slot);
    EXPECT_EQ(x.next, y.next);
    EXPECT_EQ(x.source, y.source);
    EXPECT_TRUE(std::ranges::equal(ca.vertices(x), cb.vertices(y)));
    EXPECT_TRUE(std::ranges::equal(ca.points(x), cb.points(y)));
    EXPECT_TRUE(std::ranges::equal(ca.triangles(x), cb.triangles(y)));
    EXPECT_TRUE(std::ranges::equal(ca.ring(x), cb.ring(y)));
  }
}

TEST_F(ModelFileTest, ReadsBackAsItWas) {
  Model model = trained(*bending_tube(kTube, {0, 0.5, 1, 2, 4}, "tube \xff\n"), {.references = 3});
  ASSERT_GT(model.chart_count(), 50u);
  const std::string bytes = saved(model);
  const auto read = loaded(bytes);
  ASSERT_TRUE(read) << read.error().line();
  EXPECT_EQ(read->name, files.path("b.model"));
  expect_same(model, *read);
  EXPECT_EQ(saved(*read), bytes);
}

TEST_F(ModelFileTest, HardLeavesReadBack) {
  Model model = small_model();
  model.hard_leaves = {{0, 1, Obstacle::Overlapping}, {2, 2, Obstacle::TooThin}};
  const auto read = loaded(saved(model));
  ASSERT_TRUE(read) << read.error().line();
  expect_same(model, *read);
}

void expect_same(const Pca& a, const Pca& b) {
  EXPECT_EQ(a.mean, b.mean);
  EXPECT_EQ(a.basis, b.basis);
  EXPECT_EQ(a.deviations, b.deviations);
  EXPECT_EQ(a.energy, b.energy);
}

void expect_same(const Learned& a, const Learned& b) {
  EXPECT_EQ(a.settings.subspace, b.settings.subspace);
  EXPECT_EQ(a.settings.size.energy, b.settings.size.energy);
  EXPECT_EQ(a.settings.key_points.max_share, b.settings.key_points.max_share);
  EXPECT_EQ(a.settings.max_poses, b.settings.max_poses);
  EXPECT_EQ(a.size, b.size);
  expect_same(a.pca, b.pca);
  ASSERT_EQ(a.kernel.has_value(), b.kernel.has_value());
  if (a.kernel) {
    expect_same(a.kernel->pca, b.kernel->pca);
    EXPECT_EQ(a.kernel->samples, b.kernel->samples);
    EXPECT_EQ(a.kernel->width, b.kernel->width);
    EXPECT_EQ(a.kernel->weights, b.kernel->weights);
    EXPECT_EQ(a.kernel->row_means, b.kernel->row_means);
    EXPECT_EQ(a.kernel->deviations, b.kernel->deviations);
  }
  ASSERT_EQ(a.poses.size(), b.poses.size());
  for (std::size_t k = 0; k < a.poses.size(); ++k) {
    EXPECT_EQ(a.poses[k].pose, b.poses[k].pose);
    EXPECT_EQ(a.poses[k].trained.cueing.worst, b.poses[k].trained.cueing.worst);
    EXPECT_EQ(a.poses[k].leave_one_out.projection.mean, b.poses[k].leave_one_out.projection.mean);
    EXPECT_EQ(a.poses[k].leave_one_out.total.worst_vertex, b.poses[k].leave_one_out.total.worst_vertex);
  }
  EXPECT_EQ(a.coordinates, b.coordinates);
  EXPECT_EQ(a.key_points.vertices, b.key_points.vertices);
  EXPECT_EQ(a.key_points.round_ends, b.key_points.round_ends);
  EXPECT_EQ(a.key_points.errors, b.key_points.errors);
  EXPECT_EQ(a.clusters.cluster_of, b.clusters.cluster_of);
  EXPECT_EQ(a.clusters.centers, b.clusters.centers);
  EXPECT_EQ(a.clusters.medoids, b.clusters.medoids);
  ASSERT_TRUE(a.certificates && b.certificates);
  EXPECT_EQ(a.certificates->nodes, b.certificates->nodes);
  EXPECT_EQ(a.certificates->cca.weights, b.certificates->cca.weights);
  EXPECT_EQ(a.certificates->cca.loadings, b.certificates->cca.loadings);
  EXPECT_EQ(a.certificates->thresholds, b.certificates->thresholds);
  EXPECT_EQ(a.certificates->sources, b.certificates->sources);
  EXPECT_EQ(a.certificates->balanced_accuracy, b.certificates->balanced_accuracy);
  ASSERT_EQ(a.regions.size(), b.regions.size());
  for (std::size_t k = 0; k < a.regions.size(); ++k) {
    EXPECT_EQ(a.regions[k].node, b.regions[k].node);
    EXPECT_EQ(a.regions[k].worst, b.regions[k].worst);
    EXPECT_EQ(a.regions[k].worst_vertex, b.regions[k].worst_vertex);
  }
}

TEST_F(ModelFileTest, WhatWasLearnedReadsBack) {
  for (const SubspaceKind kind : {SubspaceKind::Pca, SubspaceKind::KernelPca}) {
    const Model model = small_learned_model(kind);
    ASSERT_TRUE(model.learned) << model.not_learned;
    const std::string bytes = saved(model);
    const auto read = loaded(bytes);
    ASSERT_TRUE(read) << read.error().line();
    ASSERT_TRUE(read->learned);
    expect_same(*model.learned, *read->learned);
    EXPECT_EQ(saved(*read), bytes);
  }
}

TEST_F(ModelFileTest, WhatWasLearnedIsCheckedNumberByNumber) {
  const Model good = small_learned_model(SubspaceKind::KernelPca);
  ASSERT_TRUE(good.learned && good.learned->certificates);
  const auto error_of = [&](auto change) {
    Model model = good;
    const auto learned = std::make_shared<Learned>(*good.learned);
    auto map = std::make_shared<CertificateMap>(*learned->certificates);
    change(*learned, *map);
    learned->certificates = map;
    model.learned = learned;
    return load_error(saved(model));
  };
  using L = Learned&;
  using C = CertificateMap&;
  EXPECT_EQ(error_of([](L l, C) { l.pca.deviations[0] = 0; }),
            "b.model, learned subspace: is damaged; copy the model again, or train it anew");
  EXPECT_THAT(error_of([](L l, C) { l.pca.mean[3] = NAN; }), HasSubstr("learned subspace"));
  EXPECT_THAT(error_of([](L l, C) { l.pca.basis *= 2; }), HasSubstr("learned subspace"));
  EXPECT_THAT(error_of([](L l, C) { l.pca.mean.conservativeResize(6); }), HasSubstr("learned subspace"));
  EXPECT_THAT(error_of([](L l, C) { l.kernel->width = -1; }), HasSubstr("learned kernel"));
  EXPECT_THAT(error_of([](L l, C) { l.kernel.reset(); }), HasSubstr("learned kernel"));
  EXPECT_THAT(error_of([](L l, C) { l.coordinates(0, 1) = INFINITY; }), HasSubstr("learned coordinates"));
  EXPECT_THAT(error_of([](L l, C) { l.key_points.vertices[0] = 108; }), HasSubstr("learned key points"));
  EXPECT_THAT(error_of([](L l, C) { l.key_points.vertices[0] = l.key_points.vertices[1]; }),
              HasSubstr("learned key points"));
  EXPECT_THAT(error_of([](L l, C) { l.key_points.round_ends.back() = 99; }), HasSubstr("learned key points"));
  EXPECT_THAT(error_of([](L l, C) { l.clusters.cluster_of[0] = 9; }), HasSubstr("learned clusters"));
  EXPECT_THAT(error_of([](L l, C) { l.poses[1].pose = 0; }), HasSubstr("learned poses"));
  EXPECT_THAT(error_of([](L l, C) { l.poses[1].trained.total.mean = -1; }), HasSubstr("learned poses"));
  EXPECT_THAT(error_of([](L l, C) { l.poses.pop_back(); }), HasSubstr("learned "));
  EXPECT_THAT(error_of([](L l, C) { l.size = NAN; }), HasSubstr("learned size"));
  EXPECT_THAT(error_of([](L l, C) { l.settings.size.energy = 2; }), HasSubstr("learned settings"));
  EXPECT_THAT(error_of([](L l, C) { l.regions[0].node = 9999; }), HasSubstr("learned regions"));
  EXPECT_THAT(error_of([](L, C c) { c.nodes[0] = 9999; }), HasSubstr("learned certificates"));
  EXPECT_THAT(error_of([](L, C c) { std::swap(c.nodes[0], c.nodes[1]); }), HasSubstr("learned certificates"));
  EXPECT_THAT(error_of([](L, C c) { c.thresholds[0] = NAN; }), HasSubstr("learned certificates"));
  EXPECT_THAT(error_of([](L, C c) { c.cca.loadings(0, 0) = NAN; }), HasSubstr("learned certificates"));
  EXPECT_THAT(error_of([](L, C c) { c.balanced_accuracy = 1.5; }), HasSubstr("learned certificates"));
}

Model with_balls(Model model) {
  const auto shape = prove_balls(model);
  EXPECT_TRUE(shape) << shape.error().line();
  model.balls = std::make_shared<const ReducedBalls>((*shape)->balls());
  return model;
}

TEST_F(ModelFileTest, BallsReadBack) {
  const Model model = with_balls(small_learned_model());
  const std::string bytes = saved(model);
  const auto read = loaded(bytes);
  ASSERT_TRUE(read) << read.error().line();
  ASSERT_TRUE(read->balls);
  EXPECT_EQ(read->balls->clearance, model.balls->clearance);
  EXPECT_EQ(read->balls->radii, model.balls->radii);
  EXPECT_EQ(saved(*read), bytes);
  const auto proven = prove_balls(model).value(), kept = kept_balls(*read).value();
  ASSERT_GT(proven->radius(0), 0);
  EXPECT_EQ(kept->radius(0), proven->radius(0));
  EXPECT_EQ(kept->uncertified(0).size(), proven->uncertified(0).size());
}

/// Balls are proofs that nobody repeats when they are read.
TEST_F(ModelFileTest, BallsOfAnotherModelAreRefused) {
  const Model model = with_balls(small_learned_model());
  const std::string bytes = saved(model);
  Eigen::VectorXd mean = model.learned->pca.mean;
  const auto bytes_of_mean = [&] {
    return std::string_view(reinterpret_cast<const char*>(mean.data()),
                            8 * static_cast<std::size_t>(mean.size()));
  };
  const std::size_t at = bytes.find(bytes_of_mean());
  ASSERT_NE(at, std::string::npos);
  mean[5] += 1e-9;  // a model that is as good as this one
  std::string other = bytes;
  other.replace(at, bytes_of_mean().size(), bytes_of_mean());
  EXPECT_EQ(load_error(other),
            "b.model, balls: are damaged, or of another model; copy the model again, or train it anew");
}

TEST_F(ModelFileTest, DamagedBallsAreRefused) {
  const Model model = with_balls(small_learned_model());
  const std::string bytes = saved(model);
  std::size_t refused = 0, tries = 0;
  const auto& numbers = model.balls->radii;
  const std::string_view content(reinterpret_cast<const char*>(numbers.data()), 4 * numbers.size());
  const std::size_t radii = bytes.find(content);
  ASSERT_NE(radii, std::string::npos);
  for (std::size_t at = 0; at < content.size(); at += 7) {
    std::string damaged = bytes;
    damaged[radii + at] = static_cast<char>(damaged[radii + at] ^ (1 << at % 8));
    ++tries;
    refused += load_error(damaged) ==
               "b.model, balls: are damaged, or of another model; copy the model again, or train it anew";
  }
  EXPECT_EQ(refused, tries);
}

TEST_F(ModelFileTest, BallsOfOtherProofsAreProvenAnew) {
  const Model model = with_balls(small_learned_model());
  std::string bytes = saved(model);
  // The version is the number before the clearance's row of the table: found by what loading then says.
  std::size_t found = 0;
  for (std::size_t at = 0; at + 4 <= bytes.size(); at += 4) {
    if (bytes.compare(at, 4, std::string_view("\1\0\0\0", 4)) != 0) continue;
    std::string other = bytes;
    other[at] = 2;
    const auto read = loaded(other);
    found += read && !read->balls && read->learned;
  }
  EXPECT_GE(found, 1u);
}

TEST_F(ModelFileTest, DISABLED_WriteGolden) {
  ASSERT_TRUE(save_model(small_learned_model(SubspaceKind::KernelPca), golden_path(2)));
  ASSERT_TRUE(save_model(with_balls(small_learned_model()), golden_path("2-balls")));
}

TEST_F(ModelFileTest, GoldenBallsAreStillRead) {
  const auto model = load_model(golden_path("2-balls"));
  ASSERT_TRUE(model) << model.error().line();
  ASSERT_TRUE(model->balls);
  EXPECT_EQ(saved(*model), read_bytes(golden_path("2-balls")));
  const auto kept = kept_balls(*model), proven = prove_balls(*model);
  ASSERT_TRUE(kept && proven);
  EXPECT_GT((*kept)->radius(0), 0);
  EXPECT_NEAR((*kept)->radius(0), (*proven)->radius(0), 1e-5 * (*proven)->radius(0));
}

TEST_F(ModelFileTest, GoldenVersion2IsStillRead) {
  const auto model = load_model(golden_path(2));
  ASSERT_TRUE(model) << model.error().line();
  EXPECT_EQ(model->poses.size(), 4u);
  ASSERT_TRUE(model->learned && model->learned->kernel && model->learned->certificates);
  EXPECT_EQ(model->learned->pca.mean.size(), 324);
  EXPECT_EQ(model->learned->coordinates.cols(), 4);
  EXPECT_EQ(saved(*model), read_bytes(golden_path(2)));
}

TEST_F(ModelFileTest, GoldenVersion1IsStillRead) {
  const auto model = load_model(golden_path(1));
  ASSERT_TRUE(model) << model.error().line();
  EXPECT_EQ(model->program, "0.1.0");
  EXPECT_EQ(model->hierarchy()->topology(), tube(kSmallTube.around, kSmallTube.along));
  EXPECT_EQ(model->hierarchy()->leaf_count(), 12u);
  ASSERT_EQ(model->poses.size(), 2u);
  EXPECT_EQ(model->poses[1].name, "tube, frame 1");
  EXPECT_TRUE(model->poses[1].reference);
  EXPECT_EQ(model->chart_count(), 34u);
  EXPECT_EQ(model->learned, nullptr);
  // What is written today differs by the version only.
  std::string today = saved(*model);
  EXPECT_EQ(today[version_at(today)], 2);
  today[version_at(today)] = 1;
  EXPECT_EQ(today, read_bytes(golden_path(1)));
}

TEST_F(ModelFileTest, CutAtEveryLengthIsAnError) {
  const std::string bytes = saved(small_model());
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    EXPECT_NE(load_error(bytes.substr(0, length)), "no error") << length;
  }
  EXPECT_NE(load_error(bytes + '\0'), "no error");
}

TEST_F(ModelFileTest, CutWithALearnedPartIsAnError) {
  const std::string bytes = saved(small_learned_model(SubspaceKind::KernelPca));
  for (std::size_t length = 0; length < bytes.size(); length += 13) {
    EXPECT_NE(load_error(bytes.substr(0, length)), "no error") << length;
  }
}

/// A damaged learned part is refused or usable: nothing is read beyond its end.
TEST_F(ModelFileTest, DamagedNumbersAreRefusedOrHarmless) {
  const std::string bytes = saved(small_learned_model(SubspaceKind::KernelPca));
  std::size_t refused = 0, used = 0;
  for (std::size_t at = 0; at < bytes.size(); at += 11) {
    std::string damaged = bytes;
    damaged[at] = static_cast<char>(damaged[at] ^ (0x80 >> at % 8));
    const auto read = loaded(damaged);
    if (!read || !read->learned) {
      ++refused;
      continue;
    }
    ++used;
    const Predictor predictor(read->learned);
    const Eigen::VectorXd keys = predictor.key_point_map().gather(read->learned->pca.mean);
    EXPECT_EQ(predictor.from_key_points(keys).size(), 324);
    if (read->learned->certificates) read->learned->certificates->margins(keys);
  }
  EXPECT_GT(refused, used / 10);
  EXPECT_GT(used, 10u);
}

/// The collisions of a tube that bends until it touches itself.
StepResult answer(const std::shared_ptr<const Hierarchy>& hierarchy,
                  std::shared_ptr<const ChartLibrary> charts) {
  const auto x0 = bent(kSmallTube.around, kSmallTube.along, 5.9),
             x1 = bent(kSmallTube.around, kSmallTube.along, 6.5);
  const std::span<const double> from[] = {x0}, to[] = {x1};
  StepResult result;
  StepChecker checker({charts ? Object(std::move(charts)) : hierarchy});
  EXPECT_TRUE(checker.check(from, to, {}, result));
  return result;
}

TEST_F(ModelFileTest, EveryByteMayBeDamaged) {
  const Model model = small_model();
  const std::string bytes = saved(model);
  const StepResult truth = answer(model.hierarchy(), nullptr);
  ASSERT_GT(truth.edge_edge.size(), 10u);
  std::size_t refused = 0, tries = 0;
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    std::string damaged = bytes;
    damaged[at] = static_cast<char>(damaged[at] ^ (1 << at * 5 % 8));
    ++tries;
    const auto read = loaded(damaged);
    if (!read) {
      ++refused;
      EXPECT_EQ(read.error().line().find('\n'), std::string::npos);
      continue;
    }
    const StepResult found = answer(read->hierarchy(), read->charts);
    ASSERT_EQ(found.vertex_face.size(), truth.vertex_face.size()) << at;
    ASSERT_EQ(found.edge_edge.size(), truth.edge_edge.size()) << at;
  }
  EXPECT_GT(refused, tries / 4);
  EXPECT_LT(refused, tries);
}

TEST_F(ModelFileTest, ForeignFilesAreRefused) {
  EXPECT_THAT(load_error(""), HasSubstr("is empty"));
  EXPECT_THAT(load_error("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"), HasSubstr("is not a Foldproof model"));
  EXPECT_THAT(load_error(std::string(5000, '\0')), HasSubstr("is not a Foldproof model"));
  EXPECT_THAT(load_error(std::string("\4\0\0\0\4\0\0\0FPMD", 12)), HasSubstr("is damaged or cut off"));
  EXPECT_FALSE(load_model(files.path("missing.model")));
  EXPECT_FALSE(load_model(files.path("")));
}

TEST_F(ModelFileTest, OtherVersionsAreNamed) {
  std::string bytes = saved(small_model());
  ASSERT_EQ(bytes[version_at(bytes)], 2);
  for (const char version : {0, 3, 9}) {
    bytes[version_at(bytes)] = version;
    EXPECT_THAT(load_error(bytes), HasSubstr("has format version " + std::to_string(version) +
                                             ", and this program reads 1 to 2; use the version"));
  }
}

TEST_F(ModelFileTest, AnOverlappingChartIsRefused) {
  Model model = small_model();
  const auto& slots = model.charts->slots();
  Patch patch;
  PatchReader(*slots).read(0, patch);
  UvMap uv_map;
  uv_map.uvs.resize(patch.vertices.size());
  uv_map.heights.resize(patch.vertices.size());
  uv_map.scaffold.resize(2 * patch.vertices.size() + 2 - patch.triangles.size());
  const auto charts = std::make_shared<ChartLibrary>(slots);
  charts->add(0, 0, patch, {}, uv_map);
  model.charts = charts;
  EXPECT_THAT(load_error(saved(model)), HasSubstr("chart 0: is not a valid chart of its patch"));
}

TEST_F(ModelFileTest, ContentsThatMakeNoSenseAreRefused) {
  const Model good = small_model();
  const auto error_of = [&](auto change) {
    Model model = good;
    change(model);
    return load_error(saved(model));
  };
  EXPECT_THAT(error_of([](Model& m) { m.poses[0].reference = m.poses[1].reference = false; }),
              HasSubstr("chart 0: comes from no reference pose"));
  EXPECT_THAT(error_of([](Model& m) { m.poses[1].proven = NAN; }), HasSubstr("pose 1: has a share"));
  EXPECT_THAT(error_of([](Model& m) {
                m.hard_leaves = {{99, 1, Obstacle::Overlapping}};
              }),
              HasSubstr("hard leaf 0: makes no sense"));
  EXPECT_THAT(error_of([](Model& m) {
                m.hard_leaves = {{1, 1, Obstacle::Overlapping}, {1, 1, Obstacle::Overlapping}};
              }),
              HasSubstr("hard leaf 1: makes no sense"));
  EXPECT_THAT(error_of([](Model& m) {
                m.hard_leaves = {{1, 3, Obstacle::Overlapping}};
              }),
              HasSubstr("makes no sense"));
}

TEST_F(ModelFileTest, LeavesNoFileBehindWhenWritingFails) {
  EXPECT_FALSE(save_model(small_model(), files.path("no/where.model")));
  EXPECT_FALSE(save_model(small_model(), "/dev/full"));
  EXPECT_TRUE(std::filesystem::is_empty(files.path("")));
}

TEST_F(ModelFileTest, AModelOfUnmergedTrianglesSaysSo) {
  Model model = small_model();
  model.name = "tube.model";
  const Topology& own = model.hierarchy()->topology();
  std::vector<Index> merged(own.vertex_count());
  std::iota(merged.begin(), merged.end(), Index{0});
  merged[7] = 3;
  std::vector<Triangle> triangles(own.triangles().begin(), own.triangles().end());
  for (Triangle& t : triangles) std::ranges::replace(t, Index{7}, Index{3});
  const auto other = require_model_of(model, *Topology::make(own.vertex_count(), triangles), "a.npz", merged);
  ASSERT_FALSE(other);
  EXPECT_EQ(
      other.error().line(),
      "tube.model: was trained on triangles whose seams were not merged, and those of a.npz are; check with "
      "--no-weld, or train it again");
  std::swap(triangles[5][0], triangles[5][1]);
  const auto another =
      require_model_of(model, *Topology::make(own.vertex_count(), triangles), "a.npz", merged);
  ASSERT_FALSE(another);
  EXPECT_THAT(another.error().line(), HasSubstr("is a model of another mesh"));
}

TEST_F(ModelFileTest, AModelOfAnotherMeshSaysSo) {
  Model model = small_model();
  model.name = "tube.model";
  EXPECT_TRUE(require_model_of(model, tube(12, 8), "same.obj"));
  const auto other = require_model_of(model, tube(12, 9), "long.obj");
  ASSERT_FALSE(other);
  EXPECT_EQ(other.error().line(),
            "tube.model: is a model of another mesh: 192 triangles over 108 vertices, but long.obj has 216 "
            "triangles over 120 vertices; train a model on this one");
  std::vector<Triangle> turned(model.hierarchy()->topology().triangles().begin(),
                               model.hierarchy()->topology().triangles().end());
  std::swap(turned[5][0], turned[5][1]);
  const auto near = require_model_of(model, *Topology::make(108, turned), "near.obj");
  ASSERT_FALSE(near);
  EXPECT_THAT(near.error().line(), HasSubstr("triangle 5 of near.obj has other vertices"));
  EXPECT_NE(topology_hash(tube(12, 8)), topology_hash(*Topology::make(108, turned)));
}

TEST_F(ModelFileTest, KeepsLinesAndPoints) {
  const Topology skin = tube(6, 8);
  const Index n = skin.vertex_count();
  const auto faces = skin.faces();
  const auto hairy = *Topology::make(n + 2, {faces.begin(), faces.end()}, std::vector<Edge>{{0, n}},
                                     std::vector<Index>{n + 1});
  std::vector<double> pose = bent(6, 8, 0.5);
  pose.insert(pose.end(), {0, 2, 0, 0, -2, 0});
  const auto motion = memory_motion("hairy", hairy, {pose});
  const TrainPose poses[] = {{motion.get(), 0}};
  const auto model = train_model(poses, {});
  ASSERT_TRUE(model) << model.error().line();
  const auto read = loaded(saved(*model));
  ASSERT_TRUE(read) << read.error().line();
  EXPECT_TRUE(read->hierarchy()->topology() == hairy);
  EXPECT_TRUE(require_model_of(*read, hairy, "hairy"));
  const auto triangles = hairy.triangles();
  const auto as_faces = *Topology::make(n + 2, {triangles.begin(), triangles.end()});
  EXPECT_FALSE(require_model_of(*read, as_faces, "other"));
}

}  // namespace
}  // namespace foldproof::testing
