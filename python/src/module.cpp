// The module foldproof._core, which python/foldproof/__init__.py re-exports.
#include "module.h"

#include <optional>

#include "arrays.h"
#include "base/parallel.h"

namespace foldproof::python {
namespace {

// Protected by the interpreter's lock, which callers hold.
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
  module.attr("__name__") = "foldproof";  // the module name that classes show
  module.attr("__version__") = foldproof::version();
  translate_errors();
  module.def("build_info", &foldproof::build_info,
             "How the module was built and what it uses here: compiler, threads and how many, instruction "
             "set of its vector code.");
  module.def("set_threads", &set_threads, py::arg("count"),
             "Limits the number of threads of all later calls; 0: all cores. Answers do not depend on it.");
  bind_motions(module);
  bind_hierarchy(module);
  bind_models(module);
  bind_steps(module);
  bind_filters(module);
  bind_contacts(module);
  bind_checks(module);
  bind_repair(module);
  bind_reduced(module);
  bind_solver(module);
  add_signatures(module);
  module.attr("__name__") = name;
}
