/// The release of Python's lock, so that other threads go on.
#pragma once

#include <pybind11/pybind11.h>

#include <chrono>
#include <thread>

namespace foldproof::python {

[[noreturn]] inline void wait_for_ever() {
  while (true) std::this_thread::sleep_for(std::chrono::hours(1));
}

/// Releases the lock and takes it again at the end of the scope. Once Python is finalizing, CPython ends a
/// thread that takes the lock by unwinding its stack. That would end the process at this destructor, so such
/// a thread waits until the process exits.
class Unlocked {
 public:
  Unlocked() : state_(PyEval_SaveThread()) {}
  Unlocked(const Unlocked&) = delete;
  Unlocked& operator=(const Unlocked&) = delete;
  ~Unlocked() {
    try {
      PyEval_RestoreThread(state_);
    } catch (...) {  // the unwinding, which nothing may stop
      wait_for_ever();
    }
  }

 private:
  PyThreadState* state_;
};

}  // namespace foldproof::python
