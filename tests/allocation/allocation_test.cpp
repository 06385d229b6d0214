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

TEST(StepChecker, AllocatesNothingFromTheSecondStepOn) {
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const int length = 400;
  std::vector<Triangle> triangles;
  for (Index i = 0; i < length; ++i) {
    triangles.push_back({2 * i, 2 * i + 1, 2 * i + 2});
    triangles.push_back({2 * i + 1, 2 * i + 3, 2 * i + 2});
  }
  const auto x0 = strip(length, 5), x1 = strip(length, 8);
  auto tree = Hierarchy::build(Topology::make(2 * length + 2, triangles).value(), x0).value();
  StepChecker checker({std::make_shared<const Hierarchy>(std::move(tree))});
  StepResult step;
  const std::span<const double> from[] = {x0}, to[] = {x1};
  ASSERT_TRUE(checker.check(from, to, {}, step));
  ASSERT_FALSE(step.clean());
  const long before = allocations;
  ASSERT_TRUE(checker.check(from, to, {}, step));
  EXPECT_EQ(allocations - before, 0);
}

}  // namespace
}  // namespace foldproof
