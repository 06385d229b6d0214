#include "long_call.h"

#include <chrono>
#include <exception>
#include <thread>

namespace foldproof::python {

namespace py = pybind11;

void run_long(const py::object& progress, const std::function<void(LongCall&)>& work) {
  LongCall call;
  std::exception_ptr failed, interrupted;
  std::thread worker([&] {
    try {
      work(call);
    } catch (...) {
      failed = std::current_exception();
    }
    const std::lock_guard lock(call.mutex_);
    call.done_ = true;
    call.finished_.notify_one();
  });
  double reported = 0;
  for (bool done = false; !done;) {
    {
      const py::gil_scoped_release unlocked;
      std::unique_lock lock(call.mutex_);
      done = call.finished_.wait_for(lock, std::chrono::milliseconds(50), [&] { return call.done_; });
    }
    if (interrupted) continue;
    try {
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
      const double part = call.part_;
      if (!progress.is_none() && part != reported) progress(reported = part);
    } catch (...) {
      interrupted = std::current_exception();
      call.cancel_ = true;
    }
  }
  worker.join();
  if (interrupted) std::rethrow_exception(interrupted);
  if (failed) std::rethrow_exception(failed);
}

}  // namespace foldproof::python
