/// Where a program that uses oneTBB itself may call the library from. Without oneTBB these only call.
#pragma once

#include "base/parallel.h"

namespace foldproof::inline internal {

/// body() in an arena for this many threads, whether or not the machine has them.
template <class Body>
void in_arena([[maybe_unused]] int threads, const Body& body) {
#if defined(FOLDPROOF_THREADS_TBB)
  tbb::task_arena(threads).execute(body);
#else
  body();
#endif
}

/// body() in an iteration of a loop that is cancelled already, as when another iteration has thrown.
template <class Body>
void in_cancelled_loop(const Body& body) {
#if defined(FOLDPROOF_THREADS_TBB)
  tbb::task_group_context context;
  const auto run = [&](int) {
    context.cancel_group_execution();
    body();
  };
  tbb::parallel_for(0, 1, run, context);
#else
  body();
#endif
}

}  // namespace foldproof::inline internal
