/// Conversion of step settings and answers, shared by all checkers.
#pragma once

#include <pybind11/numpy.h>

#include <memory>
#include <string>
#include <vector>

#include "arrays.h"
#include "foldproof/check.h"
#include "foldproof/model.h"

namespace foldproof::python {

/// Converts keyword arguments. TypeError: an unknown one.
StepSettings step_settings(const py::kwargs& settings);

py::dict work_of(const Work& work);
py::dict milliseconds_of(const StageTimes& times);

/// A list or tuple unchanged, anything else as one item.
py::list items_of(const py::object& one_or_several);

/// Registers the NumPy types of collisions. Call it once.
void register_collision_types();

/// `doc`, followed by the documentation of the settings.
std::string with_settings(const char* doc);

}  // namespace foldproof::python
