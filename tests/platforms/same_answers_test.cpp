// Answers are the same bits on every machine: generated motions, whose answers are stored as hashes. The
// motions are made by operations that IEEE 754 defines, without the C library's functions, whose last digits
// differ between machines.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>

#include "foldproof/check.h"
#include "foldproof/solver.h"

namespace foldproof {
namespace {

/// FNV-1a over 64-bit words.
class Hash {
 public:
  void add(std::uint64_t word) {
    for (int byte = 0; byte < 8; ++byte) value_ = (value_ ^ (word >> (8 * byte) & 255)) * 0x100000001b3;
  }
  void add(double number) { add(std::bit_cast<std::uint64_t>(number)); }
  void add(const StepResult& step) {
    for (const std::uint64_t count : {step.vertex_face_count, step.edge_edge_count}) add(count);
    for (const VertexFaceCollision& c : step.vertex_face) {
      for (const Index id : {c.vertex_object, c.vertex, c.face_object, c.face}) add(std::uint64_t{id});
      add(c.toi);
      add(static_cast<std::uint64_t>(c.answer));
    }
    for (const EdgeEdgeCollision& c : step.edge_edge) {
      for (const Index id : {c.object_a, c.a[0], c.a[1], c.object_b, c.b[0], c.b[1]}) add(std::uint64_t{id});
      add(c.toi);
      add(static_cast<std::uint64_t>(c.answer));
    }
    add(step.tolerance);
    add(step.earliest_toi);
  }
  void add(const StaticResult& pose) {
    add(pose.crossing_count);
    for (const TriangleCrossing& c : pose.crossings)
      for (const Index id : {c.object_a, c.triangle_a, c.object_b, c.triangle_b}) add(std::uint64_t{id});
  }
  std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0xcbf29ce484222325;
};

/// Numbers in [-1, 1): a linear congruential generator (Knuth's MMIX).
class Numbers {
 public:
  double next() {
    state_ = state_ * 6364136223846793005 + 1442695040888963407;
    return static_cast<double>(static_cast<std::int64_t>(state_) >> 11) * 0x1p-52;
  }

 private:
  std::uint64_t state_ = 1;
};

struct Mesh {
  Topology topology;
  std::vector<double> x;
};

/// n x n squares of side 1/n, each cut into two triangles.
Mesh sheet(Index n) {
  std::vector<Triangle> triangles;
  std::vector<double> x;
  for (Index i = 0; i <= n; ++i)
    for (Index j = 0; j <= n; ++j) x.insert(x.end(), {double(i) / n, double(j) / n, 0});
  for (Index i = 0; i < n; ++i) {
    for (Index j = 0; j < n; ++j) {
      const Index a = i * (n + 1) + j, b = a + n + 1;
      triangles.push_back({a, b, b + 1});
      triangles.push_back({a, b + 1, a + 1});
    }
  }
  return {*Topology::make((n + 1) * (n + 1), triangles), x};
}

/// A sheet that is rolled up to two thirds of a turn of its middle line, by the rational parametrization of
/// the circle.
std::vector<double> rolled(const Mesh& sheet, double share) {
  std::vector<double> x = sheet.x;
  for (std::size_t v = 0; v < x.size(); v += 3) {
    const double u = 4 * share * (x[v] - 0.5), w = 1 + u * u;
    const double radius = 1 - 0.3 * x[v] * share;
    x[v] = radius * 2 * u / w;
    x[v + 2] = radius * (1 - u * u) / w + 0.2 * share * x[v + 1] * (1 - x[v + 1]) * x[v];
  }
  return x;
}

/// A sphere: an octahedron whose sides are divided into n parts.
Mesh sphere(Index n) {
  const Mesh flat = sheet(2 * n);
  std::vector<double> x;
  for (std::size_t v = 0; v < flat.x.size(); v += 3) {
    // The square's corners are one pole, its middle is the other.
    const double a = 2 * flat.x[v] - 1, b = 2 * flat.x[v + 1] - 1;
    double p = a, q = b;
    if (std::abs(a) + std::abs(b) > 1) {
      p = (1 - std::abs(b)) * (a < 0 ? -1 : 1);
      q = (1 - std::abs(a)) * (b < 0 ? -1 : 1);
    }
    const double r = 1 - std::abs(a) - std::abs(b);
    const double length = std::sqrt(p * p + q * q + r * r);
    x.insert(x.end(), {p / length, q / length, r / length});
  }
  return {flat.topology, x};
}

std::vector<double> moved(std::vector<double> x, double scale, Vec3 by, double jitter, Numbers& numbers) {
  for (std::size_t k = 0; k < x.size(); ++k) x[k] = scale * (x[k] + by[k % 3]) + jitter * numbers.next();
  return x;
}

/// Steps and poses of one motion, with certificates and without.
std::uint64_t hash_of(const std::vector<const Topology*>& topologies,
                      const std::vector<std::vector<std::vector<double>>>& frames, double thickness) {
  const auto spans = [](const std::vector<std::vector<double>>& frame) {
    return std::vector<std::span<const double>>(frame.begin(), frame.end());
  };
  Hash hash;
  std::uint64_t pairs = 0;
  for (const bool certificates : {true, false}) {
    std::vector<Object> objects;
    for (std::size_t i = 0; i < topologies.size(); ++i)
      objects.emplace_back(*Hierarchy::build(*topologies[i], frames.front()[i]));
    StepChecker checker(objects);
    const StepSettings settings{.thickness = thickness, .certificates = certificates};
    StepResult step;
    StaticResult pose;
    for (std::size_t k = 0; k + 1 < frames.size(); ++k) {
      EXPECT_TRUE(checker.check(spans(frames[k]), spans(frames[k + 1]), settings, step));
      EXPECT_TRUE(checker.check_static(spans(frames[k + 1]), settings, pose));
      pairs += step.count() + pose.crossing_count;
      hash.add(step);
      hash.add(pose);
    }
  }
  EXPECT_GT(pairs, 1000);
  return hash.value();
}

TEST(SameAnswers, RolledSheet) {
  const Mesh mesh = sheet(40);
  std::vector<std::vector<std::vector<double>>> frames;
  for (int k = 0; k <= 8; ++k) frames.push_back({rolled(mesh, k / 4.0)});
  EXPECT_EQ(hash_of({&mesh.topology}, frames, 0), 0xbccbb6f5e732013d);
}

TEST(SameAnswers, ThickRolledSheet) {
  const Mesh mesh = sheet(24);
  std::vector<std::vector<std::vector<double>>> frames;
  for (int k = 0; k <= 4; ++k) frames.push_back({rolled(mesh, k / 2.0)});
  EXPECT_EQ(hash_of({&mesh.topology}, frames, 0.02), 0xbe905f2cf55d096d);
}

class Spheres : public testing::TestWithParam<std::tuple<double, double, std::uint64_t>> {};

TEST_P(Spheres, PassThroughEachOther) {
  const auto [scale, far, expected] = GetParam();
  const Mesh mesh = sphere(10);
  std::vector<std::vector<std::vector<double>>> frames;
  Numbers numbers;
  for (int k = 0; k <= 6; ++k) {
    const double apart = 2.5 - k * 0.75;
    frames.push_back({moved(mesh.x, scale, {far, 0, 0}, 0.01 * scale, numbers),
                      moved(mesh.x, scale, {far + apart, 0.1, 0.2}, 0.01 * scale, numbers)});
  }
  EXPECT_EQ(hash_of({&mesh.topology, &mesh.topology}, frames, 0), expected);
}

INSTANTIATE_TEST_SUITE_P(SameAnswers, Spheres,
                         testing::Values(std::tuple(1, 0, 0xcb2ce9dcf94b72d5),
                                         std::tuple(0x1p-80, 0, 0x001f5d977a163c45),
                                         std::tuple(1e6, 0, 0x0aafdd15f97bb575),
                                         std::tuple(1, 1e6, 0xf2302e29df3bbcc5),
                                         std::tuple(0x1p500, 0, 0x087b0156d5f863d5)));

TEST(SameAnswers, Soup) {
  Numbers numbers;
  std::vector<Triangle> triangles;
  for (Index t = 0; t < 300; ++t) triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
  const Topology topology = *Topology::make(900, triangles);
  std::vector<std::vector<std::vector<double>>> frames(4, {std::vector<double>(2700)});
  for (auto& frame : frames)
    for (double& x : frame[0]) x = numbers.next();
  EXPECT_EQ(hash_of({&topology}, frames, 0), 0xacb63a4386036d85);
}

TEST(SameAnswers, QueriesOfSolvers) {
  const Mesh mesh = sphere(10);
  Numbers numbers;
  std::vector<Triangle> faces(mesh.topology.triangles().begin(), mesh.topology.triangles().end());
  for (Triangle t : mesh.topology.triangles()) {
    for (Index& vertex : t) vertex += mesh.topology.vertex_count();
    faces.push_back(t);
  }
  std::vector<double> x0 = mesh.x;
  const std::vector<double> other = moved(mesh.x, 1, {2.1, 0.1, 0.2}, 0.01, numbers);
  x0.insert(x0.end(), other.begin(), other.end());
  ContactChecker checker(std::make_shared<const CollisionMesh>(*CollisionMesh::make(x0, {}, faces)));
  Hash hash;
  Candidates candidates;
  for (int k = 1; k <= 6; ++k) {
    std::vector<double> x1 = x0;
    for (std::size_t v = x1.size() / 2; v < x1.size(); v += 3) x1[v] -= 0.3 * k;
    hash.add(checker.collision_free_step_size(x0, x1, 0.001 * k)->share);
    ASSERT_TRUE(checker.candidates(x0, 0.05 * k, candidates));
    hash.add(std::uint64_t{candidates.size()});
    for (const auto& [vertex, face] : candidates.vertex_face) hash.add(std::uint64_t{vertex} << 32 | face);
    for (const auto& [a, b] : candidates.edge_edge) hash.add(std::uint64_t{a} << 32 | b);
  }
  EXPECT_EQ(hash.value(), 0xf1883b0f4f900ad0);
}

}  // namespace
}  // namespace foldproof
