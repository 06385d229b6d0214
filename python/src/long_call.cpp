#include "long_call.h"

#include <chrono>
#include <exception>
#include <thread>

#include "unlocked.h"

namespace foldproof::python {

namespace py = pybind11;

void run_long(const py::object& progress, const std::function<void(LongCall&)>& work) {
  LongCall call;
  std::exception_ptr failed, interrupted;
  std::thread worker([&] {
    try {
      work(call);
      call.commit();
    } catch (...) {
      failed = std::current_exception();
    }
    const std::lock_guard lock(call.mutex_);
    call.committed_ = call.done_ = true;
    call.changed_.notify_all();
  });
  double reported = 0;
  for (bool done = false; !done;) {
    {
      const Unlocked unlocked;
      std::unique_lock lock(call.mutex_);
      call.changed_.wait_for(lock, std::chrono::milliseconds(50),
                             [&] { return call.done_ || (call.ends_ && !call.committed_); });
      done = call.done_;
    }
    const std::lock_guard lock(call.mutex_);  // the work does not commit meanwhile
    const bool can_cancel = !interrupted && !call.committed_;
    const double part = call.part_;
    const py::float_ share(part);  // not within the try block, as unwinding without Python's lock frees it
    try {
      if (can_cancel && PyErr_CheckSignals() != 0) throw py::error_already_set();
      if (can_cancel && !progress.is_none() && part != reported) {
        reported = part;
        PyObject* answer = PyObject_CallFunctionObjArgs(progress.ptr(), share.ptr(), nullptr);
        if (answer == nullptr) throw py::error_already_set();
        Py_DECREF(answer);
      }
    } catch (const std::exception&) {
      interrupted = std::current_exception();
      call.cancel_ = true;
    } catch (...) {  // the unwinding at Python's end, as in Unlocked
      call.cancel_ = true;
      wait_for_ever();
    }
    if (!call.ends_) continue;
    call.committed_ = true;
    call.changed_.notify_all();
  }
  worker.join();
  if (interrupted) std::rethrow_exception(interrupted);
  if (failed) std::rethrow_exception(failed);
}

}  // namespace foldproof::python
