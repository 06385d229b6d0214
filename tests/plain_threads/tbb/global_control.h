/// See parallel_for.h.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>

namespace tbb {

class global_control {
 public:
  enum parameter { max_allowed_parallelism };
  global_control(parameter, std::size_t threads)
      : before_(limit().exchange(std::min(threads, limit().load()))) {}
  ~global_control() { limit() = before_; }
  global_control(const global_control&) = delete;
  global_control& operator=(const global_control&) = delete;

  static std::size_t threads() { return limit(); }

 private:
  static constexpr std::size_t kThreads = 4;  // enough to meet each other, on any machine
  static std::atomic<std::size_t>& limit() {
    static std::atomic<std::size_t> limit = kThreads;
    return limit;
  }
  std::size_t before_;
};

}  // namespace tbb
