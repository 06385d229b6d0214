#include "base/parallel.h"

#if defined(FOLDPROOF_THREADS_STD)

#include <atomic>
#include <exception>
#include <set>
#include <system_error>

namespace foldproof {
namespace {

// The threads of the whole process. Loops take what is free of them, so that loops inside loops find none
// left and run on the thread that they were started from.
class Threads {
 public:
  static Threads& of_process() {
    static Threads threads;
    return threads;
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

  /// How many of `wanted` threads may be started beside the caller's.
  int take(std::size_t wanted) {
    const std::lock_guard lock(mutex_);
    const int free = std::max(0, allowed() - 1 - helping_);
    const int taken = static_cast<int>(std::min<std::size_t>(wanted, static_cast<std::size_t>(free)));
    helping_ += taken;
    return taken;
  }
  void give_back(int taken) {
    const std::lock_guard lock(mutex_);
    helping_ -= taken;
  }

 private:
  // Enough to meet each other on any machine: the thread sanitizer finds races only between threads that
  // there are.
  static constexpr unsigned kLeast = 4;

  int allowed() const { return limits_.empty() ? most_ : *limits_.begin(); }

  mutable std::mutex mutex_;
  const int most_ = static_cast<int>(std::max(kLeast, std::thread::hardware_concurrency()));
  std::multiset<int> limits_;
  int helping_ = 0;  // beside the threads that started loops
};

// One loop: its iterations in turn, and the first exception of one.
class Loop {
 public:
  Loop(std::size_t count, const std::function<void(std::size_t)>& body) : count_(count), body_(body) {}

  void take_part() noexcept {
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
  // An order between iterations would hide races from the sanitizer; starting and joining threads gives all
  // that is needed.
  static constexpr auto kNoOrder = std::memory_order_relaxed;
  const std::size_t count_;
  const std::function<void(std::size_t)>& body_;
  std::atomic<std::size_t> next_ = 0;
  std::mutex mutex_;
  std::exception_ptr thrown_;
};

}  // namespace

ThreadLimit::ThreadLimit(int threads) : threads_(threads) { Threads::of_process().add_limit(threads); }
ThreadLimit::~ThreadLimit() { Threads::of_process().remove_limit(threads_); }

LastLocal& last_local() {
  thread_local LastLocal last;
  return last;
}

std::uint64_t new_local_id() {
  static std::atomic<std::uint64_t> last = 0;
  return ++last;
}

int thread_count() { return Threads::of_process().count(); }

void run_in_parallel(std::size_t count, const std::function<void(std::size_t)>& body) {
  if (count == 0) return;
  Threads& threads = Threads::of_process();
  const int helpers = threads.take(count - 1);
  Loop loop(count, body);
  {
    std::vector<std::jthread> helping;  // joined at the end of the block
    try {
      for (int k = 0; k < helpers; ++k) helping.emplace_back([&] { loop.take_part(); });
    } catch (const std::exception&) {
      // The system gives no more threads: those that there are do the work.
    }
    loop.take_part();
  }
  threads.give_back(helpers);
  loop.rethrow();
}

}  // namespace foldproof

#elif defined(FOLDPROOF_THREADS_SERIAL)

namespace foldproof {

ThreadLimit::ThreadLimit(int threads) : threads_(threads) {}
ThreadLimit::~ThreadLimit() = default;

int thread_count() { return 1; }

void run_in_parallel(std::size_t count, const std::function<void(std::size_t)>& body) {
  for (std::size_t k = 0; k < count; ++k) body(k);
}

}  // namespace foldproof

#endif
