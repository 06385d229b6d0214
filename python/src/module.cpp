// The module foldproof._core; python/foldproof/__init__.py hands on what is in it.
#include "module.h"

#include <optional>

#include "arrays.h"
#include "base/parallel.h"

namespace foldproof::python {
namespace {

// Only the interpreter's lock is needed: the module's functions hold it when they come here.
void set_threads(int count) {
  static std::optional<ThreadLimit> limit;
  if (count < 0 || count > 4096)
    refuse("count", std::to_string(count) + " is not between 0 and 4096", "give 0 for all cores");
  limit.reset();
  if (count > 0) limit.emplace(count);
}

}  // namespace
}  // namespace foldproof::python

PYBIND11_MODULE(_core, module) {
  using namespace foldproof::python;
  const py::object name = module.attr("__name__");
  module.attr("__name__") = "foldproof";  // where people find the classes
  module.attr("__version__") = foldproof::version();
  bind_errors(module);
  module.def("set_threads", &set_threads, py::arg("count"),
             "At most so many threads in all calls that follow; 0: all cores. No answer depends on it.");
  bind_motions(module);
  bind_hierarchy(module);
  bind_models(module);
  bind_steps(module);
  bind_checks(module);
  bind_reduced(module);
  bind_solver(module);
  module.attr("__name__") = name;
}
