/// Where a program may call the library from: threads, and loops of a program that uses oneTBB itself.
#pragma once

#include "base/parallel.h"

namespace foldproof::inline internal {

/// body() in an arena for this many threads. Without oneTBB this only calls it.
template <class Body>
void in_arena([[maybe_unused]] int threads, const Body& body) {
#if defined(FOLDPROOF_THREADS_TBB)
  tbb::task_arena(threads).execute(body);
#else
  body();
#endif
}

/// body() with this many threads, whether or not the machine has them. With one where the build has no others
/// (FOLDPROOF_THREADS=serial).
template <class Body>
void with_threads(int threads, const Body& body) {
  const ThreadLimit limit(threads);
  in_arena(threads, body);
}

/// Whether the build has threads. Where not, a test that compares numbers of threads could not fail.
inline bool has_threads() {
  bool several = false;
  with_threads(2, [&] { several = thread_count() > 1; });
  return several;
}

/// body() in an iteration of a loop that is cancelled already, as when another iteration has thrown. Without
/// oneTBB this only calls it.
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
