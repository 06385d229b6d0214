// A second step of the same size allocates nothing. This file replaces operator new, so it is a
// program of its own.

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <atomic>
#include <cmath>
#include <cstdlib>
#include <new>

#include "foldproof/query.h"

namespace {
std::atomic<long> allocations{0};

void* count_and_allocate(std::size_t size, std::size_t alignment) {
  ++allocations;
  void* p =
      std::aligned_alloc(alignment, (std::max<std::size_t>(size, 1) + alignment - 1) / alignment * alignment);
  if (p == nullptr) throw std::bad_alloc();
  return p;
}
}  // namespace

void* operator new(std::size_t size) { return count_and_allocate(size, alignof(std::max_align_t)); }
void* operator new(std::size_t size, std::align_val_t a) { return count_and_allocate(size, std::size_t(a)); }
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  return count_and_allocate(size, alignof(std::max_align_t));
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

StepChecker checker_of_strip() {
  std::vector<Triangle> triangles;
  for (Index i = 0; i < kLength; ++i) {
    triangles.push_back({2 * i, 2 * i + 1, 2 * i + 2});
    triangles.push_back({2 * i + 1, 2 * i + 3, 2 * i + 2});
  }
  auto tree = Hierarchy::build(Topology::make(2 * kLength + 2, triangles).value(), strip(kLength, 5)).value();
  return StepChecker({std::make_shared<const Hierarchy>(std::move(tree))});
}

TEST(StepChecker, AllocatesNothingFromTheSecondStepOn) {
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const auto x0 = strip(kLength, 5), x1 = strip(kLength, 8);
  StepChecker checker = checker_of_strip();
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

// Charts are drawn on the way, and drawn anew as the strip goes on turning; when everything has had its turn,
// all buffers have their size.
TEST(StepChecker, AllocatesNothingForChartsOnceTheyHaveSettled) {
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  StepChecker checker = checker_of_strip();
  StepResult step;
  std::uint64_t passes = 0, pairs = 0;
  const auto run = [&](int from_step, int to_step) {
    long allocated = 0;
    for (int k = from_step; k < to_step; ++k) {
      // To and fro, rolled up tightly enough to meet itself.
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
  EXPECT_GT(run(0, 800), 0);
  passes = pairs = 0;
  EXPECT_EQ(run(800, 1000), 0);
  EXPECT_GT(passes, 0u);
  EXPECT_GT(pairs, 0u);
}

}  // namespace
}  // namespace foldproof
