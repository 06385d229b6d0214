/// Everything that the project uses of threads: parallel loops, a value for each thread, how many threads
/// there are. FOLDPROOF_THREADS chooses at build time what runs them: oneTBB (tbb), std::thread (std) or
/// nothing (serial).
///
/// For all loops: iterations run in any order, some at the same time, and the caller takes part. Loops may
/// stand inside loops. When an iteration throws, those that run are finished, the others left out, and one of
/// the exceptions comes to the caller. Each iteration calculates plainly (base/plain_arithmetic.h): oneTBB
/// runs tasks in the mode that their arena was made in, whatever that of their caller is.
#pragma once

#include <algorithm>
#include <cstddef>

#include "base/plain_arithmetic.h"

#if defined(FOLDPROOF_THREADS_TBB)
#include <tbb/enumerable_thread_specific.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>
#include <tbb/task_arena.h>
#elif defined(FOLDPROOF_THREADS_STD) || defined(FOLDPROOF_THREADS_SERIAL)
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
#error "link the target foldproof_threads, which says what runs threads"
#endif

namespace foldproof {

/// The indices from `begin` up to, but without, `end`.
struct IndexRange {
  std::size_t begin, end;
  std::size_t size() const { return end - begin; }
};

#if defined(FOLDPROOF_THREADS_TBB)

/// body(i) for each i of [begin, end).
template <class Integer, class Body>
void parallel_for(Integer begin, Integer end, const Body& body) {
  tbb::parallel_for(begin, end, [&](Integer i) {
    const PlainArithmetic plain;
    body(i);
  });
}

/// body(IndexRange) for blocks that together are `range`, of about `grain` indices or more.
template <class Body>
void parallel_for(IndexRange range, std::size_t grain, const Body& body) {
  using Block = tbb::blocked_range<std::size_t>;
  tbb::parallel_for(Block(range.begin, range.end, grain), [&](const Block& block) {
    const PlainArithmetic plain;
    body(IndexRange{block.begin(), block.end()});
  });
}

/// body(IndexRange, Value) adds a block to a value, which begins with `identity`; combine(Value, Value) joins
/// the values of a block and of the one behind it. The same in every run only if `combine` is associative.
template <class Value, class Body, class Combine>
Value parallel_reduce(IndexRange range, std::size_t grain, const Value& identity, const Body& body,
                      const Combine& combine) {
  using Block = tbb::blocked_range<std::size_t>;
  return tbb::parallel_reduce(
      Block(range.begin, range.end, grain), identity,
      [&](const Block& block, const Value& value) {
        const PlainArithmetic plain;
        return body(IndexRange{block.begin(), block.end()}, value);
      },
      combine);
}

/// A T for each thread, made when the thread first asks: PerThread<T>() or PerThread<T>(make), where make()
/// gives a T. local() is the caller's own; begin() and end() visit all, when no loop runs. A body that starts
/// a loop of its own must not keep local() across it: meanwhile this thread may run another iteration of the
/// outer loop.
template <class T>
using PerThread = tbb::enumerable_thread_specific<T>;

/// At most so many threads (1 or more) in the whole process, for as long as it lives. Of several limits the
/// smallest counts.
class ThreadLimit {
 public:
  explicit ThreadLimit(int threads)
      : control_(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads)) {}

 private:
  tbb::global_control control_;
};

/// How many threads a loop started here may have.
inline int thread_count() {
  const auto limit = tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
  return std::min(tbb::this_task_arena::max_concurrency(), static_cast<int>(limit));
}

#else  // the same without oneTBB; what it means is said above

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

/// body(k) for each k below `count`, each taken by the next thread that is free.
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

template <class Value, class Body, class Combine>
Value parallel_reduce(IndexRange range, std::size_t grain, const Value& identity, const Body& body,
                      const Combine& combine) {
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
/// What a thread was given last, by which PerThread. Looked at without a lock, which would put the threads'
/// iterations in an order and so hide races from the sanitizer.
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
  std::deque<T> values_;  // which stay where they are when more come
#if defined(FOLDPROOF_THREADS_STD)
  const std::uint64_t id_ = new_local_id();
  std::mutex mutex_;
  std::map<std::thread::id, T*> of_thread_;
#endif
};

#endif

}  // namespace foldproof
