/// A limit on memory, for files that a careless reader would need much of it for.
#pragma once

#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <fstream>

namespace foldproof::testing {

/// Limits the process to this many bytes of address space more than it has now, during its lifetime. What
/// exceeds the limit is an std::bad_alloc, which readers turn into an error.
class MemoryLimit {
 public:
  explicit MemoryLimit(std::size_t more) : more_(more) {
    ::getrlimit(RLIMIT_AS, &before_);
    std::size_t pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    rlimit limit = before_;
    limit.rlim_cur = pages * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE)) + more;
    ::setrlimit(RLIMIT_AS, &limit);
  }
  MemoryLimit(const MemoryLimit&) = delete;
  MemoryLimit& operator=(const MemoryLimit&) = delete;
  ~MemoryLimit() { ::setrlimit(RLIMIT_AS, &before_); }

  /// False where the system takes no notice of it, as QEMU does.
  bool holds() const {
    void* const p = ::mmap(nullptr, more_ + more_ / 2, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (p == MAP_FAILED) return true;
    ::munmap(p, more_ + more_ / 2);
    return false;
  }

 private:
  std::size_t more_;
  rlimit before_;
};

}  // namespace foldproof::testing
