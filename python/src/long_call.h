/// Calls that take long: Python goes on meanwhile, and Ctrl-C ends them.
#pragma once

#include <pybind11/pybind11.h>

#include <atomic>
#include <condition_variable>
#include <functional>
#include <mutex>

namespace foldproof::python {

/// What the work sees of its caller.
class LongCall {
 public:
  /// Becomes true when the caller wants it to end.
  const std::atomic<bool>* cancel() const { return &cancel_; }
  std::function<void(double)> progress() {
    return [this](double part) { part_ = part; };
  }

 private:
  friend void run_long(const pybind11::object& progress, const std::function<void(LongCall&)>& work);
  std::atomic<bool> cancel_ = false;
  std::atomic<double> part_ = 0;
  std::mutex mutex_;
  std::condition_variable finished_;
  bool done_ = false;
};

/// Runs the work on a thread of its own, as Python handles signals only on the thread that called, and looks
/// after signals and `progress` (None, or called with the share that is done) meanwhile. The work touches no
/// Python object. Throws what it threw, or what a signal handler or `progress` raised.
void run_long(const pybind11::object& progress, const std::function<void(LongCall&)>& work);

}  // namespace foldproof::python
