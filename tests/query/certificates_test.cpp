// Certificates only remove work: with and without them, every step of many gives the same answer, bit for
// bit. One checker sees all steps, as charts are drawn on the way.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <numbers>
#include <string>
#include <vector>

#include "foldproof/model.h"
#include "foldproof/query.h"
#include "oracle/brute_force.h"
#include "oracle/data.h"
#include "oracle/meshes.h"

namespace foldproof::oracle {
namespace {

using Pose = std::vector<double>;

// Some objects and their poses one after the other.
struct Film {
  std::vector<Topology> topologies;
  std::vector<std::vector<Pose>> poses;  ///< By time, then by object.
};

std::vector<std::span<const double>> spans(const std::vector<Pose>& pose) {
  return {pose.begin(), pose.end()};
}

void expect_same(const StepResult& with, const StepResult& without) {
  const auto same = [](const auto& p, const auto& q) {
    return key(p) == key(q) && p.answer == q.answer && std::memcmp(&p.toi, &q.toi, sizeof p.toi) == 0;
  };
  ASSERT_TRUE(std::equal(with.vertex_face.begin(), with.vertex_face.end(), without.vertex_face.begin(),
                         without.vertex_face.end(), same));
  ASSERT_TRUE(std::equal(with.edge_edge.begin(), with.edge_edge.end(), without.edge_edge.begin(),
                         without.edge_edge.end(), same));
  ASSERT_EQ(with.earliest_toi, without.earliest_toi);
  ASSERT_EQ(with.tolerance, without.tolerance);
  ASSERT_EQ(with.work.undecided, without.work.undecided);
}

void expect_same(const StaticResult& with, const StaticResult& without) {
  ASSERT_TRUE(std::equal(with.crossings.begin(), with.crossings.end(), without.crossings.begin(),
                         without.crossings.end(),
                         [](const auto& p, const auto& q) { return key(p) == key(q); }));
}

bool same_counts(const Work& a, const Work& b) {
  return a.node_tests == b.node_tests && a.certificate_tests == b.certificate_tests &&
         a.certificate_passes == b.certificate_passes && a.leaf_pairs == b.leaf_pairs &&
         a.candidates_vf == b.candidates_vf && a.candidates_ee == b.candidates_ee &&
         a.undecided == b.undecided;
}

struct Sums {
  std::uint64_t steps = 0, passes = 0, pairs_with = 0, pairs_without = 0, hits = 0;
  void add(const Work& with, const Work& without, std::size_t found) {
    ++steps;
    passes += with.certificate_passes;
    pairs_with += with.leaf_pairs;
    pairs_without += without.leaf_pairs;
    hits += found;
    EXPECT_LE(with.leaf_pairs, without.leaf_pairs);
    EXPECT_EQ(without.certificate_tests, 0u);
    EXPECT_EQ(without.certificate_passes, 0u);
  }
};

std::vector<std::shared_ptr<const Hierarchy>> hierarchies(const Film& film, Index leaf_triangles) {
  Scene scene;
  scene.topologies = film.topologies;
  scene.x0 = film.poses[0];
  return scene.hierarchies(leaf_triangles);
}

// The checkers of a comparison: one that uses certificates, and one that does not.
class Comparison {
 public:
  explicit Comparison(const std::vector<std::shared_ptr<const Hierarchy>>& objects,
                      const std::vector<std::shared_ptr<const ChartLibrary>>& trained = {})
      : with_(objects, trained), without_(objects) {}

  void step(const std::vector<Pose>& from, const std::vector<Pose>& to, StepSettings settings) {
    StepResult with, without;
    const auto x0 = spans(from), x1 = spans(to);
    settings.certificates = true;
    ASSERT_TRUE(with_.check(x0, x1, settings, with));
    settings.certificates = false;
    ASSERT_TRUE(without_.check(x0, x1, settings, without));
    ASSERT_NO_FATAL_FAILURE(expect_same(with, without));
    sums.add(with.work, without.work, with.vertex_face.size() + with.edge_edge.size());
  }

  void pose(const std::vector<Pose>& pose) {
    StaticResult with, without;
    const auto x = spans(pose);
    StepSettings settings;
    ASSERT_TRUE(with_.check_static(x, settings, with));
    settings.certificates = false;
    ASSERT_TRUE(without_.check_static(x, settings, without));
    ASSERT_NO_FATAL_FAILURE(expect_same(with, without));
    statics.add(with.work, without.work, with.crossings.size());
  }

  Sums sums, statics;

 private:
  StepChecker with_, without_;
};

// ---- Generated films.

struct FilmFamily {
  const char* name;
  Film (*make)(Rng& rng);
};
void PrintTo(const FilmFamily& family, std::ostream* out) { *out << family.name; }

// A sheet of columns x rows cells.
Topology sheet(Index columns, Index rows) {
  std::vector<Triangle> triangles;
  for (Index j = 0; j < rows; ++j) {
    for (Index i = 0; i < columns; ++i) {
      const Index a = j * (columns + 1) + i, c = a + columns + 1;
      triangles.push_back({a, a + 1, c + 1});
      triangles.push_back({a, c + 1, c});
    }
  }
  return Topology::make((columns + 1) * (rows + 1), std::move(triangles)).value();
}

template <class Place>
Pose sheet_pose(Index columns, Index rows, Place place) {
  Pose x;
  for (Index j = 0; j <= rows; ++j) {
    for (Index i = 0; i <= columns; ++i) {
      const Vec3 p = place(double(i) / columns, double(j) / rows);
      x.insert(x.end(), {p.x(), p.y(), p.z()});
    }
  }
  return x;
}

// There and back again: 0 .. 1 .. 0.
double to_and_fro(int step, int steps) { return 0.5 - 0.5 * std::cos(2 * std::numbers::pi * step / steps); }

constexpr int kSteps = 40;

// Rolled up along its length by an ever larger angle until it meets itself, and unrolled.
Film bending(Rng&) {
  Film film;
  film.topologies.push_back(sheet(60, 12));
  for (int k = 0; k <= kSteps; ++k) {
    const double angle = 0.05 + 7.2 * to_and_fro(k, kSteps);
    film.poses.push_back({sheet_pose(60, 12, [&](double u, double v) {
      const double a = angle * (u - 0.5);
      return Vec3(std::sin(a) / angle, (1 - std::cos(a)) / angle + 0.002 * std::sin(20 * v), 0.3 * v);
    })});
  }
  return film;
}

// Folded flat onto itself along a line, and opened.
Film folding(Rng& rng) {
  Film film;
  film.topologies.push_back(sheet(40, 16));
  std::vector<double> noise(41 * 17);
  for (double& n : noise) n = 0.004 * std::uniform_real_distribution<double>(-1, 1)(rng);
  for (int k = 0; k <= kSteps; ++k) {
    const double angle = 3.3 * to_and_fro(k, kSteps);
    std::size_t vertex = 0;
    film.poses.push_back({sheet_pose(40, 16, [&](double u, double v) {
      const double s = std::max(0.0, u - 0.5), height = noise[vertex++];
      return Vec3(std::min(u, 0.5) + s * std::cos(angle) - height * std::sin(angle) * (s > 0),
                  s * std::sin(angle) + height * (s > 0 ? std::cos(angle) : 1), 0.4 * v);
    })});
  }
  return film;
}

// A long strip twisted about its own line, by several turns.
Film twisting(Rng&) {
  Film film;
  film.topologies.push_back(sheet(60, 8));
  for (int k = 0; k <= kSteps; ++k) {
    const double turns = 22 * to_and_fro(k, kSteps);
    film.poses.push_back({sheet_pose(60, 8, [&](double u, double v) {
      const double a = turns * u, y = 0.25 * (v - 0.5), squeeze = 1 - 0.0445 * turns;
      return Vec3(u * squeeze, y * std::cos(a), y * std::sin(a) + 0.03 * std::sin(turns) * std::sin(9 * u));
    })});
  }
  return film;
}

// Bodies that drift through each other while they breathe.
Film several_bodies(Rng& rng) {
  Film film;
  std::vector<Mesh> meshes;
  for (const int family : {0, 1, 2}) meshes.push_back(mesh_families()[family].make(rng));
  for (const Mesh& mesh : meshes) film.topologies.push_back(mesh.topology());
  for (int k = 0; k <= kSteps; ++k) {
    std::vector<Pose> pose;
    for (std::size_t b = 0; b < meshes.size(); ++b) {
      const double phase = 0.16 * k + 2 * double(b);
      const double scale = 1 + 0.1 * std::sin(3 * phase);
      Pose x = meshes[b].positions;
      for (std::size_t i = 0; i < x.size(); ++i)
        x[i] =
            scale * x[i] + 0.5 * std::sin(phase + 1.3 * double(i % 3)) + 0.02 * std::sin(20 * x[i] + phase);
      pose.push_back(std::move(x));
    }
    film.poses.push_back(std::move(pose));
  }
  return film;
}

// Poses that have nothing to do with each other, in between short quiet stretches.
Film jumping(Rng& rng) {
  Film film;
  const Mesh mesh = mesh_families()[rng() % 2].make(rng);
  film.topologies = {mesh.topology(), sheet(20, 20)};
  const Pose flat =
      sheet_pose(20, 20, [](double u, double v) { return Vec3(u - 0.5, v - 0.5, 0.3 * u * v); });
  Pose first = mesh.positions, second = flat;
  for (int k = 0; k <= kSteps; ++k) {
    if (k % 7 == 6) {
      first = deformed(mesh.positions, 0.3, k % 2 ? 0 : 1.0 / 16, rng);
      second = deformed(flat, 0.2, 0, rng);
    } else {
      first = deformed(first, 0.003, 0, rng);
      second = deformed(second, 0.003, 0, rng);
    }
    film.poses.push_back({first, second});
  }
  return film;
}

// Triangle soups, non-manifold edges, degenerate and double triangles.
Film damaged(Rng& rng) {
  Film film;
  std::vector<Pose> pose;
  for (const int family : {3, 4, 6}) {
    const Mesh mesh = mesh_families()[family].make(rng);
    film.topologies.push_back(mesh.topology());
    pose.push_back(mesh.positions);
  }
  for (int k = 0; k <= kSteps; ++k) {
    film.poses.push_back(pose);
    for (Pose& x : pose) x = deformed(x, 0.002, k % 10 == 9 ? 1.0 / 256 : 0, rng);
  }
  return film;
}

constexpr FilmFamily kFilms[] = {{"bending", bending},   {"folding", folding},
                                 {"twisting", twisting}, {"several_bodies", several_bodies},
                                 {"jumping", jumping},   {"damaged", damaged}};

class Films : public ::testing::TestWithParam<FilmFamily> {
 protected:
  Rng rng_{81};
  Film film_ = GetParam().make(rng_);
};

TEST_P(Films, CertificatesNeverChangeAnAnswer) {
  std::uint64_t passes = 0, with = 0, without = 0, hits = 0;
  for (const Index leaf : {4, 16}) {
    for (const double thickness : {0.0, 0.004}) {
      Comparison both(hierarchies(film_, leaf));
      StepSettings settings;
      settings.thickness = thickness;
      for (std::size_t k = 0; k + 1 < film_.poses.size(); ++k) {
        ASSERT_NO_FATAL_FAILURE(both.step(film_.poses[k], film_.poses[k + 1], settings)) << "step " << k;
        if (k % 3 == 0) {
          ASSERT_NO_FATAL_FAILURE(both.pose(film_.poses[k])) << "pose " << k;
        }
      }
      passes += both.sums.passes + both.statics.passes;
      with += both.sums.pairs_with;
      without += both.sums.pairs_without;
      hits += both.sums.hits;
    }
  }
  // Otherwise nothing was tested.
  EXPECT_GT(passes, 100u);
  EXPECT_LT(with, without);
  EXPECT_GT(hits, 50u);
}

// The larger the tolerance and the thickness, the wider the gap that certificates must leave; and only some
// pairs may be asked for.
TEST_P(Films, SettingsChangeFromStepToStep) {
  Comparison both(hierarchies(film_, 8));
  for (std::size_t k = 0; k + 1 < film_.poses.size(); ++k) {
    StepSettings settings;
    settings.thickness = std::array{0.0, 0.02, 0.0, 0.001}[k % 4];
    settings.tolerance = std::array{0.0, 0.0, 0.01}[k % 3];
    settings.within = k % 5 != 4;
    settings.between = k % 7 != 3;
    ASSERT_NO_FATAL_FAILURE(both.step(film_.poses[k], film_.poses[k + 1], settings)) << "step " << k;
    // Backwards: the pose at the begin is another one than where charts were drawn.
    ASSERT_NO_FATAL_FAILURE(both.step(film_.poses[k + 1], film_.poses[k], settings)) << "step " << k;
  }
  EXPECT_GT(both.sums.passes, 50u);
}

// Models of a few poses, of all, and of one only.
TEST_P(Films, TrainedChartsNeverChangeAnAnswer) {
  for (const std::size_t stride : {4, 13, 1000}) {
    std::vector<std::shared_ptr<const Hierarchy>> objects;
    std::vector<std::shared_ptr<const ChartLibrary>> charts;
    for (std::size_t object = 0; object < film_.topologies.size(); ++object) {
      std::vector<Pose> poses;
      for (std::size_t k = 0; k < film_.poses.size(); k += stride) poses.push_back(film_.poses[k][object]);
      const auto motion = memory_motion("film", film_.topologies[object], poses);
      std::vector<TrainPose> chosen;
      for (Index k = 0; k < motion->frame_count(); ++k) chosen.push_back({motion.get(), k});
      const Result<Model> model = train_model(chosen, {});
      ASSERT_TRUE(model) << model.error().line();
      objects.push_back(model->hierarchy());
      charts.push_back(model->charts);
    }
    Comparison both(objects, charts);
    for (std::size_t k = 0; k + 1 < film_.poses.size(); ++k) {
      ASSERT_NO_FATAL_FAILURE(both.step(film_.poses[k], film_.poses[k + 1], {})) << "step " << k;
      ASSERT_NO_FATAL_FAILURE(both.pose(film_.poses[k])) << "pose " << k;
    }
    EXPECT_GT(both.sums.passes, 50u);
    EXPECT_LT(both.sums.pairs_with, both.sums.pairs_without);
  }
}

TEST_P(Films, EarliestOnlyIsTheSameWithCertificates) {
  const auto objects = hierarchies(film_, 8);
  StepChecker with(objects), without(objects);
  for (std::size_t k = 0; k + 1 < film_.poses.size(); ++k) {
    StepSettings settings;
    settings.earliest_only = true;
    StepResult a, b;
    const auto x0 = spans(film_.poses[k]), x1 = spans(film_.poses[k + 1]);
    ASSERT_TRUE(with.check(x0, x1, settings, a));
    settings.certificates = false;
    ASSERT_TRUE(without.check(x0, x1, settings, b));
    a.work.undecided = b.work.undecided = 0;  // depends on luck with threads
    ASSERT_NO_FATAL_FAILURE(expect_same(a, b)) << "step " << k;
  }
}

TEST_P(Films, ThreadsChangeNeitherAnswersNorWork) {
  std::vector<std::vector<StepResult>> runs;
  for (const std::size_t threads : {1, 2, 2}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    StepChecker checker(hierarchies(film_, 4));
    auto& run = runs.emplace_back(film_.poses.size() - 1);
    for (std::size_t k = 0; k < run.size(); ++k) {
      const auto x0 = spans(film_.poses[k]), x1 = spans(film_.poses[k + 1]);
      ASSERT_TRUE(checker.check(x0, x1, {}, run[k]));
    }
  }
  for (const auto& run : runs) {
    for (std::size_t k = 0; k < run.size(); ++k) {
      ASSERT_NO_FATAL_FAILURE(expect_same(run[k], runs[0][k]));
      EXPECT_TRUE(same_counts(run[k].work, runs[0][k].work)) << "step " << k;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Generated, Films, ::testing::ValuesIn(kFilms),
                         [](const auto& instance) { return std::string(instance.param.name); });

// ---- Real motions.

struct RealFilm {
  const char* name;
  Index first;  ///< Where the short run begins; something touches there where it ever does.
};
void PrintTo(const RealFilm& film, std::ostream* out) { *out << film.name; }

const RealFilm kRealFilms[] = {
    {"lion_poses", 0},  {"lion_anim", 20},   {"hand_poses", 4},     {"hand_train", 7},       {"hand_anim", 8},
    {"horse_poses", 2}, {"horse_gallop", 3}, {"elephant_poses", 0}, {"elephant_gallop", 10}, {"samba", 40},
    {"rumba", 30},      {"cloth_ball", 0},   {"rod_twist", 0},      {"cloth_funnel", 0},
};

class RealFilms : public ::testing::TestWithParam<RealFilm> {
 protected:
  void SetUp() override {
    const auto data = data_directory();
    if (!data) GTEST_SKIP() << kNoData;
    motion_ = open_real_motion(*data, GetParam().name);
    all_ = all_frames();
    first_ = all_ ? 0 : std::min(GetParam().first, motion_->frame_count() - 2);
    last_ = all_ ? motion_->frame_count() - 1 : std::min(first_ + 3, motion_->frame_count() - 1);
  }

  std::vector<Pose> frame(Index k) const {
    std::vector<Pose> pose{Pose(3 * std::size_t{motion_->topology().vertex_count()})};
    EXPECT_TRUE(motion_->read_frame(k, pose[0]));
    return pose;
  }

  Comparison comparison() const {
    auto built = Hierarchy::build(motion_->topology(), frame(0)[0]);
    return Comparison({std::make_shared<const Hierarchy>(std::move(built.value()))});
  }

  void report(const Comparison& both) const {
    const auto print = [&](const char* what, const Sums& s) {
      fmt::print("{:16} {:3} {:12} {:8} collisions, leaf pairs {:9} instead of {:9}\n", GetParam().name,
                 s.steps, what, s.hits, s.pairs_with, s.pairs_without);
    };
    print("steps", both.sums);
    if (both.statics.steps > 0) print("poses", both.statics);
    if (both.sums.steps > 2) {
      EXPECT_GT(both.sums.passes, 0u);
      EXPECT_LT(both.sums.pairs_with, both.sums.pairs_without);
    }
  }

  std::unique_ptr<Motion> motion_;
  bool all_ = false;
  Index first_ = 0, last_ = 0;
};

TEST_P(RealFilms, FullSteps) {
  Comparison both = comparison();
  for (Index k = first_; k < last_; ++k)
    ASSERT_NO_FATAL_FAILURE(both.step(frame(k), frame(k + 1), {})) << "frame " << k;
  report(both);
}

TEST_P(RealFilms, TenthsOfSteps) {
  Comparison both = comparison();
  // The short run: some tenths of one step.
  const Index last = all_ ? last_ : first_ + 1;
  const int tenths = all_ ? 10 : 5;
  for (Index k = first_; k < last; ++k) {
    const auto from = frame(k), to = frame(k + 1);
    auto now = from, next = from;
    for (int part = 1; part <= tenths; ++part) {
      for (std::size_t i = 0; i < from[0].size(); ++i)
        next[0][i] = from[0][i] + (to[0][i] - from[0][i]) * part / 10;
      ASSERT_NO_FATAL_FAILURE(both.step(now, next, {})) << "frame " << k << ", tenth " << part;
      std::swap(now, next);
    }
    ASSERT_NO_FATAL_FAILURE(both.pose(now)) << "frame " << k;
  }
  report(both);
}

TEST_P(RealFilms, FullStepsWithModels) {
  if (!all_) GTEST_SKIP() << "Training takes long. Set FOLDPROOF_ALL_FRAMES=1 to run this test.";
  // Every tenth frame is offered; all of them become references, or one.
  for (const Index references : {0, 1}) {
    std::vector<TrainPose> chosen;
    for (Index k = 0; k < motion_->frame_count(); k += 10) chosen.push_back({motion_.get(), k});
    TrainSettings training;
    training.references = references;
    const Result<Model> model = train_model(chosen, training);
    ASSERT_TRUE(model) << model.error().line();
    Comparison both({model->hierarchy()}, {model->charts});
    for (Index k = first_; k < last_; ++k)
      ASSERT_NO_FATAL_FAILURE(both.step(frame(k), frame(k + 1), {})) << "frame " << k;
    report(both);
  }
}

INSTANTIATE_TEST_SUITE_P(Motions, RealFilms, ::testing::ValuesIn(kRealFilms),
                         [](const auto& instance) { return std::string(instance.param.name); });

}  // namespace
}  // namespace foldproof::oracle
