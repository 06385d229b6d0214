#include "check/pipeline.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "base/callers.h"

namespace foldproof {
namespace {

// A thread that waits in a call must not take up another iteration of the user's loop, which may call the
// same checker. Iterations sleep, so that however busy the machine is, others take them and the thread waits.
TEST(RunOn, TakesUpNoOtherTaskOfTheCaller) {
  PerThread<std::unique_ptr<int>> memories([] { return std::make_unique<int>(0); });
  std::atomic<int> nested = 0;
  const auto call = [&](int) {
    std::unique_ptr<int>& memory = memories.local();
    nested += memory == nullptr;  // it is out during a call
    run_on(
        memory, [] { return std::make_unique<int>(0); },
        [](int& calls) {
          parallel_for(0, 8, [](int) { std::this_thread::sleep_for(std::chrono::microseconds(200)); });
          return ++calls;
        });
  };
  with_threads(8, [&] { parallel_for(0, 200, call); });
  EXPECT_EQ(nested, 0);
}

}  // namespace
}  // namespace foldproof
