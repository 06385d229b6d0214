/// Settings and answers of a step, shared by all that check.
#pragma once

#include <pybind11/numpy.h>

#include <memory>
#include <string>
#include <vector>

#include "arrays.h"
#include "foldproof/check.h"
#include "foldproof/model.h"

namespace foldproof::python {

/// The keyword arguments of a check. TypeError: one that is not known.
StepSettings step_settings(const py::kwargs& settings);

py::dict work_of(const Work& work);
py::dict milliseconds_of(const StageTimes& times);

/// A list or tuple as it is, anything else as one item.
py::list items_of(const py::object& one_or_several);

/// Layouts that NumPy shows as fields. Registers them once.
void register_collision_types();

/// The function `name` of a checker, with the documentation of the settings behind its own.
std::string with_settings(const char* doc);

}  // namespace foldproof::python
