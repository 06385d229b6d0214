/// The parts of the module. A class must be bound before functions whose signatures use it.
#pragma once

#include <pybind11/pybind11.h>

namespace foldproof::python {

void bind_motions(pybind11::module_& module);
void bind_hierarchy(pybind11::module_& module);
void bind_models(pybind11::module_& module);
void bind_steps(pybind11::module_& module);
void bind_filters(pybind11::module_& module);
void bind_contacts(pybind11::module_& module);
void bind_checks(pybind11::module_& module);
void bind_repair(pybind11::module_& module);
void bind_reduced(pybind11::module_& module);
void bind_solver(pybind11::module_& module);

/// Makes inspect.signature work for all functions, methods and classes that are bound. Call it last.
void add_signatures(const pybind11::module_& module);

}  // namespace foldproof::python
