/// The project's threading: parallel loops, a value per thread, the number of threads. FOLDPROOF_THREADS
/// chooses the implementation at build time: oneTBB (tbb), std::thread (std), none (serial), or one thread
/// that records what others could have taken over (record).
///
/// For all loops: iterations run in any order and concurrently; the calling thread takes part. Loops may be
/// nested. When an iteration throws, running iterations finish, the rest are skipped, and the caller gets one
/// of the exceptions. A task group of the caller that is cancelled skips nothing: proofs need every
/// iteration. Each iteration, and each combination of two values, holds a PlainArithmetic: oneTBB runs tasks
/// in the floating-point mode in which their arena was made, not in that of the caller.
#pragma once

#include <algorithm>
#include <cstddef>

#include "base/plain_arithmetic.h"

#if defined(FOLDPROOF_THREADS_TBB)
// NOLINTBEGIN(portability-restrict-system-includes)
#include <tbb/enumerable_thread_specific.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>
#include <tbb/task_arena.h>
// NOLINTEND(portability-restrict-system-includes)
#elif defined(FOLDPROOF_THREADS_STD) || defined(FOLDPROOF_THREADS_SERIAL) || defined(FOLDPROOF_THREADS_RECORD)
#include <deque>
#include <functional>
#include <utility>
#include <vector>
#if defined(FOLDPROOF_THREADS_STD)
#include <cstdint>
#include <map>
#include <mutex>
#include <thread>
#endif
#else
#error "link the target foldproof_threads, which chooses the threads' implementation"
#endif

namespace foldproof::inline internal {

/// The indices [begin, end).
struct IndexRange {
  std::size_t begin, end;
  std::size_t size() const { return end - begin; }
};

#if defined(FOLDPROOF_THREADS_TBB)

/// body(i) for each i of [begin, end).
template <class Integer, class Body>
void parallel_for(Integer begin, Integer end, const Body& body) {
  tbb::task_group_context own(tbb::task_group_context::isolated);
  const auto run = [&](Integer i) {
    const PlainArithmetic plain;
    body(i);
  };
  tbb::parallel_for(begin, end, run, own);
}

/// body(IndexRange) for blocks of about `grain` indices or more, which together are `range`.
template <class Body>
void parallel_for(IndexRange range, std::size_t grain, const Body& body) {
  using Block = tbb::blocked_range<std::size_t>;
  tbb::task_group_context own(tbb::task_group_context::isolated);
  const auto run = [&](const Block& block) {
    const PlainArithmetic plain;
    body(IndexRange{block.begin(), block.end()});
  };
  tbb::parallel_for(Block(range.begin, range.end, grain), run, own);
}

/// body(IndexRange, Value) adds a block to a value that starts as `identity`; combine(Value, Value) merges
/// the values of two adjacent blocks. The result is the same in every run only if `combine` is associative.
template <class Value, class Body, class Combine>
Value parallel_reduce(IndexRange range, std::size_t grain, const Value& identity, const Body& body,
                      const Combine& combine) {
  using Block = tbb::blocked_range<std::size_t>;
  tbb::task_group_context own(tbb::task_group_context::isolated);
  return tbb::parallel_reduce(
      Block(range.begin, range.end, grain), identity,
      [&](const Block& block, const Value& value) {
        const PlainArithmetic plain;
        return body(IndexRange{block.begin(), block.end()}, value);
      },
      [&](const Value& a, const Value& b) {
        const PlainArithmetic plain;
        return combine(a, b);
      },
      own);
}

/// body(). While it waits for loops that it starts, this thread runs nothing else. For the user's code,
/// which may start loops, and for calls that keep memory, which the user may make in the iterations of a
/// loop.
template <class Body>
auto isolated(const Body& body) {
  return tbb::this_task_arena::isolate(body);
}

/// A T per thread, made on the thread's first call of local(): PerThread<T>() or PerThread<T>(make), where
/// make() returns a T. begin() and end() visit all of them; no loop may be running. A body that starts a loop
/// of its own must not keep local() across it, unless isolated: this thread may run another iteration of the
/// outer loop meanwhile.
template <class T>
using PerThread = tbb::enumerable_thread_specific<T>;

/// Limits the whole process to this many threads (1 or more) during its lifetime. Of several limits the
/// smallest applies.
class ThreadLimit {
 public:
  explicit ThreadLimit(int threads)
      : control_(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads)) {}

 private:
  tbb::global_control control_;
};

/// How many threads a loop that is started here may use.
inline int thread_count() {
  const auto limit = tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
  return std::min(tbb::this_task_arena::max_concurrency(), static_cast<int>(limit));
}

#else  // the same without oneTBB; documented above

class ThreadLimit {
 public:
  explicit ThreadLimit(int threads);
  ~ThreadLimit();
  ThreadLimit(const ThreadLimit&) = delete;
  ThreadLimit& operator=(const ThreadLimit&) = delete;

 private:
  int threads_;
};

int thread_count();

#if defined(FOLDPROOF_THREADS_RECORD)
/// Milliseconds of each piece of each outermost loop that ran; null: nobody wants to know. A piece is one
/// iteration, or a block of `grain`.
extern std::vector<std::vector<double> >* recorded_loops;
#endif

/// body(k) for each k below `count`, each on the next free thread.
void run_in_parallel(std::size_t count, const std::function<void(std::size_t)>& body);

template <class Integer, class Body>
void parallel_for(Integer begin, Integer end, const Body& body) {
  if (begin >= end) return;
  const auto run = [&](std::size_t k) {
    const PlainArithmetic plain;
    body(static_cast<Integer>(begin + static_cast<Integer>(k)));
  };
  run_in_parallel(static_cast<std::size_t>(end - begin), std::ref(run));
}

template <class Body>
void parallel_for(IndexRange range, std::size_t grain, const Body& body) {
  const auto run = [&](std::size_t k) {
    const PlainArithmetic plain;
    const std::size_t begin = range.begin + k * grain;
    body(IndexRange{begin, std::min(range.end, begin + grain)});
  };
  run_in_parallel((range.size() + grain - 1) / grain, std::ref(run));
}

template <class Body>
auto isolated(const Body& body) {
  return body();  // a thread that waits runs nothing
}

template <class Value, class Body, class Combine>
Value parallel_reduce(IndexRange range, std::size_t grain, const Value& identity, const Body& body,
                      const Combine& combine) {
  const PlainArithmetic plain;
  if (range.size() <= grain || thread_count() == 1) return body(range, identity);
  std::vector<Value> values((range.size() + grain - 1) / grain, identity);
  parallel_for(range, grain, [&](IndexRange block) {
    Value& value = values[(block.begin - range.begin) / grain];
    value = body(block, value);
  });
  Value all = identity;
  for (const Value& value : values) all = combine(all, value);
  return all;
}

#if defined(FOLDPROOF_THREADS_STD)
/// The value that this thread used last, and the PerThread that owns it. Read without a lock: a lock would
/// order the threads' iterations and so hide races from the sanitizer.
struct LastLocal {
  std::uint64_t owner = 0;
  void* value = nullptr;
};
LastLocal& last_local();
std::uint64_t new_local_id();  ///< 1 or more, never twice
#endif

template <class T>
class PerThread {
 public:
  PerThread() : make_([] { return T(); }) {}
  explicit PerThread(std::function<T()> make) : make_(std::move(make)) {}

#if defined(FOLDPROOF_THREADS_STD)
  T& local() {
    LastLocal& last = last_local();
    if (last.owner == id_) return *static_cast<T*>(last.value);
    const std::lock_guard lock(mutex_);
    T*& value = of_thread_[std::this_thread::get_id()];
    if (value == nullptr) value = &values_.emplace_back(make_());
    last = {id_, value};
    return *value;
  }
#else
  T& local() { return values_.empty() ? values_.emplace_back(make_()) : values_.front(); }
#endif
  auto begin() { return values_.begin(); }
  auto end() { return values_.end(); }

 private:
  std::function<T()> make_;
  std::deque<T> values_;  // keeps addresses when it grows
#if defined(FOLDPROOF_THREADS_STD)
  const std::uint64_t id_ = new_local_id();
  std::mutex mutex_;
  std::map<std::thread::id, T*> of_thread_;
#endif
};

#endif

}  // namespace foldproof::inline internal
