#include "base/parallel.h"

#if defined(FOLDPROOF_THREADS_STD)

#include <atomic>
#include <exception>
#include <set>
#include <system_error>

namespace foldproof::internal {
namespace {

// The threads that the process may run. A loop acquires those that are free, so a nested loop finds none and
// runs on the thread that starts it.
class ThreadBudget {
 public:
  /// Never destroyed: a limit may live until the program ends.
  static ThreadBudget& instance() {
    static auto& budget = *new ThreadBudget;
    return budget;
  }

  void add_limit(int limit) {
    const std::lock_guard lock(mutex_);
    limits_.insert(limit);
  }
  void remove_limit(int limit) {
    const std::lock_guard lock(mutex_);
    limits_.erase(limits_.find(limit));
  }
  int count() const {
    const std::lock_guard lock(mutex_);
    return allowed();
  }

  /// Returns how many threads, at most `wanted`, may be started beside the caller's.
  int acquire(std::size_t wanted) {
    const std::lock_guard lock(mutex_);
    const int free = std::max(0, allowed() - 1 - helpers_);
    const int acquired = static_cast<int>(std::min<std::size_t>(wanted, static_cast<std::size_t>(free)));
    helpers_ += acquired;
    return acquired;
  }
  void release(int acquired) {
    const std::lock_guard lock(mutex_);
    helpers_ -= acquired;
  }

 private:
  // The thread sanitizer needs several threads to find races, whatever the machine has.
#if defined(__SANITIZE_THREAD__)
  static constexpr unsigned kMinThreads = 4;
#elif defined(__has_feature)
  static constexpr unsigned kMinThreads = __has_feature(thread_sanitizer) ? 4 : 1;
#else
  static constexpr unsigned kMinThreads = 1;
#endif

  int allowed() const { return limits_.empty() ? max_threads_ : *limits_.begin(); }

  mutable std::mutex mutex_;
  const int max_threads_ = static_cast<int>(std::max(kMinThreads, std::thread::hardware_concurrency()));
  std::multiset<int> limits_;
  int helpers_ = 0;  // threads in use beside those that started loops
};

// One loop: hands out its iterations and keeps the first exception.
class Loop {
 public:
  Loop(std::size_t count, const std::function<void(std::size_t)>& body) : count_(count), body_(body) {}

  void run_iterations() noexcept {
    try {
      for (std::size_t k; (k = next_.fetch_add(1, kNoOrder)) < count_;) body_(k);
    } catch (...) {
      next_.store(count_, kNoOrder);
      const std::lock_guard lock(mutex_);
      if (!thrown_) thrown_ = std::current_exception();
    }
  }
  void rethrow() const {
    if (thrown_) std::rethrow_exception(thrown_);
  }

 private:
  // Stronger ordering between iterations would hide races from the sanitizer; starting and joining threads
  // synchronizes enough.
  static constexpr auto kNoOrder = std::memory_order_relaxed;
  const std::size_t count_;
  const std::function<void(std::size_t)>& body_;
  std::atomic<std::size_t> next_ = 0;
  std::mutex mutex_;
  std::exception_ptr thrown_;
};

}  // namespace

ThreadLimit::ThreadLimit(int threads) : threads_(threads) { ThreadBudget::instance().add_limit(threads); }
ThreadLimit::~ThreadLimit() { ThreadBudget::instance().remove_limit(threads_); }

LastLocal& last_local() {
  thread_local LastLocal last;
  return last;
}

std::uint64_t new_local_id() {
  static std::atomic<std::uint64_t> last = 0;
  return ++last;
}

int thread_count() { return ThreadBudget::instance().count(); }

void run_in_parallel(std::size_t count, const std::function<void(std::size_t)>& body) {
  if (count == 0) return;
  ThreadBudget& budget = ThreadBudget::instance();
  const int helpers = budget.acquire(count - 1);
  Loop loop(count, body);
  std::vector<std::thread> threads;
  try {
    for (int k = 0; k < helpers; ++k) threads.emplace_back([&] { loop.run_iterations(); });
  } catch (const std::exception&) {
    // The system starts no more threads: those that run do the work.
  }
  loop.run_iterations();
  for (std::thread& thread : threads) thread.join();
  budget.release(helpers);
  loop.rethrow();
}

}  // namespace foldproof::internal

#elif defined(FOLDPROOF_THREADS_SERIAL) || defined(FOLDPROOF_THREADS_RECORD)

#include "base/stopwatch.h"

namespace foldproof::internal {

ThreadLimit::ThreadLimit(int threads) : threads_(threads) {}
ThreadLimit::~ThreadLimit() = default;

#if defined(FOLDPROOF_THREADS_SERIAL)

int thread_count() { return 1; }

void run_in_parallel(std::size_t count, const std::function<void(std::size_t)>& body) {
  for (std::size_t k = 0; k < count; ++k) body(k);
}

#else

std::vector<std::vector<double> >* recorded_loops = nullptr;

int thread_count() { return 16; }  // for whoever cuts work by it

void run_in_parallel(std::size_t count, const std::function<void(std::size_t)>& body) {
  auto* const loops = std::exchange(recorded_loops, nullptr);  // what a piece starts is a part of it
  std::vector<double> pieces;
  Stopwatch watch;
  for (std::size_t k = 0; k < count; ++k) {
    body(k);
    if (loops != nullptr) pieces.push_back(watch.lap());
  }
  if (loops != nullptr) loops->push_back(std::move(pieces));
  recorded_loops = loops;
}

#endif

}  // namespace foldproof::internal

#endif
