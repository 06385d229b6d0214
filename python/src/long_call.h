/// Long calls: other Python threads continue meanwhile, and Ctrl-C cancels them.
#pragma once

#include <pybind11/pybind11.h>

#include <atomic>
#include <condition_variable>
#include <functional>
#include <mutex>

namespace foldproof::python {

/// Connects the work to its caller.
class LongCall {
 public:
  /// Becomes true when the caller cancels.
  const std::atomic<bool>* cancel() const { return &cancel_; }
  /// After a last report of progress, ends the time in which the caller can cancel, before files appear.
  /// False: it has cancelled.
  bool commit() {
    std::unique_lock lock(mutex_);
    part_ = 1;
    ends_ = true;
    changed_.notify_all();
    changed_.wait(lock, [&] { return committed_; });
    return !cancel_;
  }
  std::function<void(double)> progress() {
    return [this](double part) { part_ = part; };
  }

 private:
  friend void run_long(const pybind11::object& progress, const std::function<void(LongCall&)>& work);
  std::atomic<bool> cancel_ = false;
  std::atomic<double> part_ = 0;
  std::mutex mutex_;
  std::condition_variable changed_;
  bool ends_ = false, committed_ = false, done_ = false;
};

/// Runs the work on another thread. Meanwhile the calling thread, the only one on which Python handles
/// signals, handles signals and calls `progress` (unless None) with the share that is done, at last 1, until
/// the work commits or ends. The work must not touch Python objects. Rethrows exceptions of the work, of
/// signal handlers and of `progress`.
void run_long(const pybind11::object& progress, const std::function<void(LongCall&)>& work);

}  // namespace foldproof::python
