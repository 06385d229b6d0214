// A second step of the same size allocates nothing, and calls after one that ran out of memory answer as
// ever. This file replaces operator new, so it is a program of its own.

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <new>
#include <stdexcept>

#include "base/parallel.h"
#include "foldproof/reduced.h"
#include "foldproof/solver.h"
#include "oracle/same_answers.h"

namespace {
std::atomic<long> allocations{0}, failing{-1};  // the latter: so many calls from now

void* count_and_allocate(std::size_t size, std::size_t alignment) {
  ++allocations;
  if (failing > 0 && --failing == 0) throw std::bad_alloc();
  void* p =
      std::aligned_alloc(alignment, (std::max<std::size_t>(size, 1) + alignment - 1) / alignment * alignment);
  if (p == nullptr) throw std::bad_alloc();
  return p;
}
}  // namespace

void* operator new(std::size_t size) { return count_and_allocate(size, alignof(std::max_align_t)); }
void* operator new(std::size_t size, std::align_val_t a) { return count_and_allocate(size, std::size_t(a)); }
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  ++allocations;
  return std::malloc(size);
}
void operator delete(void* p) noexcept { std::free(p); }
void operator delete(void* p, std::size_t) noexcept { std::free(p); }
void operator delete(void* p, std::align_val_t) noexcept { std::free(p); }
void operator delete(void* p, std::size_t, std::align_val_t) noexcept { std::free(p); }

namespace foldproof {
namespace {

// A strip that rolls up: it passes through itself, so that all stages have work. (Static queries allocate
// where exact integers decide.)
std::vector<double> strip(int length, double turn) {
  std::vector<double> x;
  for (int i = 0; i <= length; ++i) {
    const double angle = turn * i / length, radius = 1 + 0.05 * std::sin(3 * angle);
    for (int k = 0; k < 2; ++k)
      x.insert(x.end(), {radius * std::cos(angle), radius * std::sin(angle), 0.05 * k});
  }
  return x;
}

constexpr int kLength = 400;

Topology strip_topology(Index length = kLength) {
  std::vector<Triangle> triangles;
  for (Index i = 0; i < length; ++i) {
    triangles.push_back({2 * i, 2 * i + 1, 2 * i + 2});
    triangles.push_back({2 * i + 1, 2 * i + 3, 2 * i + 2});
  }
  return Topology::make(2 * length + 2, triangles).value();
}

StepChecker checker_of_strip_of(int length) {
  auto tree = Hierarchy::build(strip_topology(static_cast<Index>(length)), strip(length, 5)).value();
  return StepChecker({std::make_shared<const Hierarchy>(std::move(tree))});
}

StepChecker checker_of_strip() { return checker_of_strip_of(kLength); }

TEST(StepChecker, AllocatesNothingFromTheSecondStepOn) {
  const ThreadLimit one(1);
  for (const int length : {kLength / 2, kLength}) {  // hierarchies with an even and an odd number of levels
    const auto x0 = strip(length, 5), x1 = strip(length, 8);
    StepChecker checker = checker_of_strip_of(length);
    StepResult step;
    StepSettings settings;
    settings.certificates = false;
    const std::span<const double> from[] = {x0}, to[] = {x1};
    ASSERT_TRUE(checker.check(from, to, settings, step));
    ASSERT_FALSE(step.clean());
    const long before = allocations;
    ASSERT_TRUE(checker.check(from, to, settings, step));
    EXPECT_EQ(allocations - before, 0);
  }
}

// Each descends from the roots of both; how many levels depends on the sizes.
TEST(StepChecker, AllocatesNothingForTwoObjectsFromTheSecondStepOn) {
  const ThreadLimit one(1);
  for (int length = 1; length <= kLength; length *= 2) {
    const auto tree = std::make_shared<const Hierarchy>(
        Hierarchy::build(strip_topology(static_cast<Index>(length)), strip(length, 5)).value());
    StepChecker checker({tree, tree});
    StepResult step;
    StepSettings settings;
    settings.certificates = settings.within = false;
    const auto x0 = strip(length, 5), x1 = strip(length, 5.1);
    const std::span<const double> from[] = {x0, x1}, to[] = {x1, x0};
    ASSERT_TRUE(checker.check(from, to, settings, step));
    ASSERT_FALSE(step.clean());
    const long before = allocations;
    ASSERT_TRUE(checker.check(from, to, settings, step));
    EXPECT_EQ(allocations - before, 0) << length;
  }
}

// In the first 1600 steps, in which the strip rolls up and unrolls, charts are built and replaced. By then
// every buffer has reached its final size.
TEST(StepChecker, AllocatesNothingForChartsOnceTheyHaveSettled) {
  const ThreadLimit one(1);
  StepChecker checker = checker_of_strip();
  StepResult step;
  std::uint64_t passes = 0, pairs = 0;
  const auto run = [&](int from_step, int to_step) {
    long allocated = 0;
    for (int k = from_step; k < to_step; ++k) {
      // Always rolled up tightly enough to collide with itself.
      const auto turn = [](int s) { return 6.5 + 0.5 * std::sin(0.05 * s); };
      const auto x0 = strip(kLength, turn(k)), x1 = strip(kLength, turn(k + 1));
      const std::span<const double> from[] = {x0}, to[] = {x1};
      const long before = allocations;
      EXPECT_TRUE(checker.check(from, to, {}, step));
      allocated += allocations - before;
      passes += step.work.certificate_passes;
      pairs += step.vertex_face.size() + step.edge_edge.size();
    }
    return allocated;
  };
  EXPECT_GT(run(0, 1600), 0);
  passes = pairs = 0;
  EXPECT_EQ(run(1600, 1800), 0);
  EXPECT_GT(passes, 0u);
  EXPECT_GT(pairs, 0u);
}

// The same strip with two coordinates: how far it is rolled up, and how large its circles are.
std::shared_ptr<const ReducedShape> reduced_strip() {
  auto hierarchy =
      std::make_shared<const Hierarchy>(Hierarchy::build(strip_topology(), strip(kLength, 5)).value());
  const auto rest = strip(kLength, 5), rolled = strip(kLength, 8);
  Pca subspace;
  const auto count = static_cast<Eigen::Index>(rest.size());
  subspace.mean = Eigen::Map<const Eigen::VectorXd>(rest.data(), count);
  subspace.basis.resize(count, 2);
  subspace.basis.col(0) = Eigen::Map<const Eigen::VectorXd>(rolled.data(), count) - subspace.mean;
  for (Eigen::Index i = 0; i < count; ++i) subspace.basis(i, 1) = i % 3 == 2 ? 0.0 : subspace.mean[i];
  subspace.deviations = subspace.basis.colwise().norm().transpose();
  subspace.basis.colwise().normalize();
  auto motion =
      std::make_shared<const ReducedMotion>(ReducedMotion::make(std::move(hierarchy), subspace).value());
  return std::make_shared<const ReducedShape>(ReducedShape::build(std::move(motion), {{{0.0, 0.0}}}).value());
}

// Steps within a ball, out of it, and into a collision. The last one needs all vertices, and builds charts
// in its first calls.
TEST(ReducedChecker, AllocatesNothingFromTheSecondStepOn) {
  const ThreadLimit one(1);
  const auto shape = reduced_strip();
  ASSERT_GT(shape->radius(0), 0);
  ReducedChecker checker({shape});
  StepResult step;
  std::uint64_t pairs = 0, free = 0;
  const auto run = [&](double distance, int settle) {
    const std::vector<double> p0{0, 0}, p1{distance * shape->motion()->deviations()[0], 0};
    const ReducedPose from{p0}, to{p1};
    for (int k = 0; k < settle; ++k) ASSERT_TRUE(checker.check({&from, 1}, {&to, 1}, {}, step));
    const long before = allocations;
    ASSERT_TRUE(checker.check({&from, 1}, {&to, 1}, {}, step));
    EXPECT_EQ(allocations - before, 0) << distance;
    pairs += step.vertex_face.size() + step.edge_edge.size();
    free += step.work.leaf_pairs == 0;
  };
  ASSERT_LT(1.05 * shape->radius(0), 1);
  for (const double distance : {0.5 * shape->radius(0), 1.05 * shape->radius(0)}) run(distance, 1);
  run(1, 100);  // long enough for certificates to back off and be tried again
  EXPECT_GT(pairs, 0u);
  EXPECT_GT(free, 0u);
}

TEST(ReducedShape, ProvesWithoutAllocating) {
  const auto shape = reduced_strip();
  ReducedShape::Scratch scratch;
  const std::vector<double> p0{0, 0}, near{0.5 * shape->radius(0) * shape->motion()->deviations()[0], 0},
      far{40 * near[0], 0};
  EXPECT_EQ(shape->proven_free(p0, near, scratch), ReducedProof::Free);
  EXPECT_EQ(shape->find_unproven(p0, far, scratch), ReducedProof::Unproven);
  const long before = allocations;
  shape->proven_free(p0, near, scratch);
  shape->find_unproven(p0, far, scratch);
  EXPECT_EQ(allocations - before, 0);
}

// A line search: from one pose towards others, some of which are reached and some not.
TEST(ContactChecker, AllocatesNothingFromTheSecondLineSearchOn) {
  const ThreadLimit one(1);
  const auto x0 = strip(kLength, 5);
  const std::vector<double> targets[] = {strip(kLength, 8), strip(kLength, 5.2)};
  const auto triangles = strip_topology();
  const auto faces = triangles.triangles();
  const auto mesh = CollisionMesh::make(x0, {}, {faces.begin(), faces.end()}).value();
  ContactChecker checker(std::make_shared<const CollisionMesh>(mesh), {.certificates = false});
  Candidates found;
  std::vector<ClosePair> close;
  double shares = 0;
  const auto search = [&] {
    for (const auto& x1 : targets) {
      shares += checker.collision_free_step_size(x0, x1).value().share;
      EXPECT_TRUE(checker.is_step_collision_free(x0, x0).is_yes());
      EXPECT_TRUE(checker.candidates(x0, x1, 0.01, found));
      EXPECT_TRUE(checker.close_pairs(x0, 0.3, close));
      EXPECT_FALSE(close.empty());
      EXPECT_GT(checker.minimum_distance(x0, 0.1).value(), 0);
    }
  };
  search();
  EXPECT_GT(shares, 1);
  EXPECT_LT(shares, 2);
  const long before = allocations;
  search();
  EXPECT_EQ(allocations - before, 0);
}

// Lets the first allocation of `call` fail, then a later one, and so on until none fails. Each time on a new
// checker, between the calls of `before` and those of `after`, which must answer as ever.
template <class Make, class Call, class After>
int for_each_failure(Make make, Call before, Call call, After after) {
  const ThreadLimit one(1);
  for (int count = 1;; count += 1 + count / 16) {
    auto checker = make();
    before(checker);
    failing = count;
    bool failed = false;
    try {
      call(checker);
    } catch (const std::bad_alloc&) {
      failed = true;
    }
    failing = -1;
    if (!failed) return count;
    after(checker, count);
    if (::testing::Test::HasFailure()) return count;
  }
}

struct Turns {
  double from, to;
};

StepResult answer_of(StepChecker& checker, Turns turns, const StepSettings& settings) {
  const auto x0 = strip(kLength, turns.from), x1 = strip(kLength, turns.to);
  const std::span<const double> from[] = {x0}, to[] = {x1};
  StepResult step;
  EXPECT_TRUE(checker.check(from, to, settings, step));
  return step;
}

TEST(StepChecker, AnswersAsEverAfterACallWithoutMemory) {
  for (const bool certificates : {false, true}) {
    StepSettings settings;
    settings.certificates = certificates;
    const Turns later[] = {{5.2, 8}, {5.2, 8.4}, {8.4, 8.5}, {8.5, 8.6}};
    std::vector<StepResult> expected;
    for (const Turns turns : later) {
      StepChecker fresh = checker_of_strip();
      expected.push_back(answer_of(fresh, turns, settings));
      EXPECT_FALSE(expected.back().clean());
    }
    using Call = std::function<void(StepChecker&)>;
    const auto x0 = strip(kLength, later[0].from), x1 = strip(kLength, later[0].to);
    const std::span<const double> from[] = {x0}, to[] = {x1};
    StepResult kept = expected[0];  // of an earlier call that did not fail
    const int failures = for_each_failure(
        checker_of_strip, Call([&](StepChecker& checker) {
          for (int k = 0; k < 4; ++k) answer_of(checker, {5 + 0.05 * k, 5.05 + 0.05 * k}, settings);
        }),
        Call([&](StepChecker& checker) {
          kept.complete = true;
          EXPECT_TRUE(checker.check(from, to, settings, kept));
        }),
        [&](StepChecker& checker, int count) {
          EXPECT_FALSE(kept.complete) << "allocation " << count;
          for (std::size_t k = 0; k < expected.size(); ++k) {
            EXPECT_TRUE(oracle::same_collisions(answer_of(checker, later[k], settings), expected[k]))
                << "allocation " << count << ", call " << k << " after it";
          }
        });
    EXPECT_GT(failures, 20);
  }
}

TEST(ReducedChecker, AnswersAsEverAfterACallWithoutMemory) {
  const auto shape = reduced_strip();
  const auto answer = [&](ReducedChecker& checker, double begin, double end) {
    const double deviation = shape->motion()->deviations()[0];
    const std::vector<double> p0{begin * deviation, 0}, p1{end * deviation, 0};
    const ReducedPose from{p0}, to{p1};
    StepResult step;
    EXPECT_TRUE(checker.check({&from, 1}, {&to, 1}, {}, step));
    return step;
  };
  const auto make = [&] { return ReducedChecker({shape}); };
  ReducedChecker fresh = make();
  const StepResult expected[] = {answer(fresh, 0, 1), answer(fresh, 0.1, 1.05)};
  EXPECT_FALSE(expected[0].clean());
  using Call = std::function<void(ReducedChecker&)>;
  const int failures = for_each_failure(
      make, Call([&](ReducedChecker& checker) { answer(checker, 0, 0.5 * shape->radius(0)); }),
      Call([&](ReducedChecker& checker) { answer(checker, 0, 1); }), [&](ReducedChecker& checker, int count) {
        EXPECT_TRUE(oracle::same_collisions(answer(checker, 0, 1), expected[0])) << "allocation " << count;
        EXPECT_TRUE(oracle::same_collisions(answer(checker, 0.1, 1.05), expected[1]))
            << "allocation " << count;
      });
  EXPECT_GT(failures, 20);
}

// The caller gets what a filter throws.
TEST(ContactChecker, AnswersAsEverAfterAFilterThatThrows) {
  const auto x0 = strip(kLength, 5), x1 = strip(kLength, 8);
  const auto triangles = strip_topology();
  const auto faces = triangles.triangles();
  long left = -1;
  CollisionMeshSettings settings;
  settings.filter = CollisionFilter([&](Index, Index) {
    if (left > 0 && --left == 0) throw std::runtime_error("the filter's");
    return true;
  });
  const auto mesh = std::make_shared<const CollisionMesh>(
      CollisionMesh::make(x0, {}, {faces.begin(), faces.end()}, settings).value());
  const ThreadLimit one(1);
  const double expected = ContactChecker(mesh).collision_free_step_size(x0, x1).value().share;
  ASSERT_LT(expected, 1);
  for (const long count : {1, 10, 100, 1000}) {
    ContactChecker checker(mesh);
    EXPECT_TRUE(checker.is_step_collision_free(x0, x0).is_yes());
    left = count;
    EXPECT_THROW(static_cast<void>(checker.collision_free_step_size(x0, x1)), std::runtime_error);
    left = -1;
    EXPECT_EQ(checker.collision_free_step_size(x0, x1).value().share, expected) << count;
  }
}

}  // namespace
}  // namespace foldproof
