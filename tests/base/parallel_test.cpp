#include "base/callers.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <mutex>
#include <numeric>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace foldproof {
namespace {

TEST(ParallelFor, VisitsEachIndexOnce) {
  for (const std::uint32_t count : {0u, 1u, 7u, 5000u}) {
    std::vector<std::atomic<int>> visits(count + 3);
    parallel_for(std::uint32_t{3}, count + 3, [&](std::uint32_t i) { ++visits[i]; });
    for (std::uint32_t i = 0; i < count + 3; ++i) ASSERT_EQ(visits[i], i < 3 ? 0 : 1) << i << " of " << count;
  }
}

TEST(ParallelFor, BlocksTogetherAreTheRange) {
  for (const std::size_t count : {0, 1, 63, 64, 65, 5000}) {
    std::vector<std::atomic<int>> visits(count + 5);
    parallel_for(IndexRange{5, count + 5}, 64, [&](IndexRange block) {
      EXPECT_GT(block.size(), 0u);
      for (std::size_t i = block.begin; i < block.end; ++i) ++visits[i];
    });
    for (std::size_t i = 0; i < count + 5; ++i) ASSERT_EQ(visits[i], i < 5 ? 0 : 1) << i << " of " << count;
  }
}

TEST(ParallelFor, MayBeNested) {
  std::vector<std::atomic<int>> visits(200 * 50);
  parallel_for(0, 200, [&](int outer) {
    parallel_for(0, 50, [&](int inner) {
      ++visits[static_cast<std::size_t>(outer) * 50 + static_cast<std::size_t>(inner)];
    });
  });
  EXPECT_TRUE(std::all_of(visits.begin(), visits.end(), [](const auto& n) { return n == 1; }));
}

TEST(ParallelFor, PassesExceptionsToTheCaller) {
  for (int repetition = 0; repetition < 20; ++repetition) {
    std::atomic<int> visits = 0;
    try {
      parallel_for(0, 100'000, [&](int i) {
        ++visits;
        if (i % 10 == 7) throw std::runtime_error("seven");
      });
      FAIL() << "nothing was thrown";
    } catch (const std::runtime_error& error) {
      EXPECT_STREQ(error.what(), "seven");
    }
    EXPECT_LT(visits, 100'000);
    const auto nested = [] {
      parallel_for(0, 10, [](int) { parallel_for(0, 10, [](int k) { k == 5 ? throw k : void(); }); });
    };
    EXPECT_THROW(nested(), int);
  }
}

TEST(ParallelFor, ACancelledLoopOfTheCallerSkipsNothing) {
  const auto count_all = [] {
    std::atomic<int> single = 0, blocks = 0;
    parallel_for(0, 500, [&](int) { ++single; });
    parallel_for(IndexRange{0, 500}, 10, [&](IndexRange block) { blocks += static_cast<int>(block.size()); });
    const auto add = [](IndexRange block, std::size_t sum) { return sum + block.size(); };
    EXPECT_EQ(single, 500);
    EXPECT_EQ(blocks, 500);
    EXPECT_EQ(parallel_reduce(IndexRange{0, 500}, 10, std::size_t{0}, add, std::plus<>()), 500u);
  };
  in_cancelled_loop(count_all);
  const auto throws = [&] {
    parallel_for(0, 100, [&](int i) { i == 50 ? throw i : parallel_for(0, 3, [&](int) { count_all(); }); });
  };
  EXPECT_THROW(throws(), int);
}

TEST(ParallelFor, MayBeCalledByConcurrentThreads) {
  std::vector<int> sums(6);
  std::vector<std::thread> callers;
  for (int& sum : sums) {
    callers.emplace_back([&sum] {
      std::vector<int> values(1000);
      for (int repetition = 0; repetition < 20; ++repetition)
        parallel_for(std::size_t{0}, values.size(), [&](std::size_t k) { values[k] += static_cast<int>(k); });
      sum = std::accumulate(values.begin(), values.end(), 0);
    });
  }
  for (std::thread& caller : callers) caller.join();
  for (const int sum : sums) EXPECT_EQ(sum, 20 * 1000 * 999 / 2);
}

// Concatenation is associative but not commutative.
TEST(ParallelReduce, CombinesBlocksInOrderForAnyNumberOfThreads) {
  std::string expected;
  for (int i = 2; i < 900; ++i) expected += std::to_string(i) + ' ';
  for (const int threads : {1, 2, 5}) {
    const ThreadLimit limit(threads);
    const auto text = parallel_reduce(
        IndexRange{2, 900}, 10, std::string(),
        [](IndexRange block, std::string so_far) {
          for (std::size_t i = block.begin; i < block.end; ++i) so_far += std::to_string(i) + ' ';
          return so_far;
        },
        [](const std::string& a, const std::string& b) { return a + b; });
    EXPECT_EQ(text, expected) << threads << " threads";
  }
}

TEST(ParallelReduce, OfNothingIsTheIdentity) {
  const auto more = [](IndexRange, int value) { return value + 1; };
  EXPECT_EQ(parallel_reduce(
                IndexRange{4, 4}, 10, 42,
                [&](IndexRange range, int value) { return range.size() == 0 ? value : more(range, value); },
                std::plus<>()),
            42);
}

TEST(PerThread, EachThreadHasItsOwn) {
  PerThread<std::vector<int>> values([] { return std::vector<int>{-1}; });
  std::atomic<int> made_wrong = 0;
  for (int repetition = 0; repetition < 3; ++repetition) {
    parallel_for(0, 3000, [&](int i) {
      std::vector<int>& local = values.local();
      if (local.front() != -1 || &local != &values.local()) ++made_wrong;
      local.push_back(i);
    });
  }
  EXPECT_EQ(made_wrong, 0);
  std::size_t all = 0;
  for (const std::vector<int>& local : values) all += local.size() - 1;
  EXPECT_EQ(all, 9000u);
}

TEST(PerThread, SeveralDoNotMix) {
  for (int repetition = 0; repetition < 10; ++repetition) {
    // Later ones may get the addresses of earlier ones.
    PerThread<int> ones([] { return 1; }), twos([] { return 2; });
    std::atomic<int> mixed = 0;
    parallel_for(0, 300, [&](int) {
      if (ones.local() != 1 || twos.local() != 2 || ones.local() != 1) ++mixed;
    });
    EXPECT_EQ(mixed, 0);
  }
}

TEST(ThreadLimit, HoldsWhileItLives) {
  const auto threads_seen = [] {
    std::mutex mutex;
    std::set<std::thread::id> seen;
    parallel_for(0, 2000, [&](int) {
      parallel_for(0, 3, [&](int) {
        const std::lock_guard lock(mutex);
        seen.insert(std::this_thread::get_id());
      });
    });
    return seen;
  };
  EXPECT_GE(thread_count(), 1);
  const ThreadLimit two(2);
  std::optional<ThreadLimit> one(1);
  EXPECT_EQ(thread_count(), 1);
  EXPECT_EQ(threads_seen(), std::set{std::this_thread::get_id()});
  one.reset();
  EXPECT_LE(threads_seen().size(), 2u);
}

TEST(ThreadLimit, MayLiveAsLongAsTheProgram) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const auto end = [] {
    static std::optional<ThreadLimit> limit;
    limit.emplace(1);
    std::exit(0);
  };
  EXPECT_EXIT(end(), ::testing::ExitedWithCode(0), "");
}

}  // namespace
}  // namespace foldproof
