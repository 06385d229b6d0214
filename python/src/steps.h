/// Conversion of step settings and answers, shared by all checkers.
#pragma once

#include <pybind11/numpy.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "arrays.h"
#include "foldproof/check.h"
#include "foldproof/model.h"

namespace foldproof::python {

struct Settings {
  StepSettings step;
  std::optional<double> paper_miss_rate;  ///< Mode 'paper'; none: 'proven'.
};
/// Converts keyword arguments. TypeError: an unknown one, with the name that was meant: of a setting, or of
/// another keyword of the function, in `others`.
Settings settings_of(const py::kwargs& settings, const std::vector<std::string>& others = {});

/// Raises TypeError for an unknown keyword. `of`: what it is no setting of; `names`: those that are known.
[[noreturn]] void refuse_keyword(const std::string& name, const char* of,
                                 const std::vector<std::string>& names);

/// An answer, and what it is about.
template <class Answer>
struct AnswerFor : Answer {
  std::vector<Object> objects;
  bool statistical = false;  ///< Mode 'paper'.
};

/// Refused: settings that are given though they have no effect. `with`: what they do not go with.
void refuse_given(const char* with, std::initializer_list<std::pair<const char*, bool>> settings);
/// Refused: settings about the ways between poses. `with`: what checks poses alone.
void require_static_fits(const char* with, const StepSettings& settings);

py::dict work_of(const Work& work);
py::dict milliseconds_of(const StageTimes& times);

/// A list or tuple unchanged, anything else as one item.
py::list items_of(const py::object& one_or_several);

/// A Hierarchy, a Model, a CollisionMesh, or a list of them. TypeError: anything else. Refused: none.
/// `models`: adds one per object, null where it is no Model.
std::vector<Object> objects_of(const py::object& objects,
                               std::vector<std::shared_ptr<const foldproof::Model>>* models = nullptr);

/// Positions of all objects at one time; keeps the arrays.
struct Pose {
  std::vector<Numbers> arrays;
  std::vector<std::span<const double>> spans;
};

/// One array V x 3 per object. Refused: other numbers and shapes of arrays.
Pose pose_of(const py::object& x, const char* what, const std::vector<Object>& objects);

/// Registers the NumPy types of collisions. Call it once.
void register_collision_types();

/// A line per setting.
std::string settings_documentation();
/// `doc`, followed by the documentation of the settings.
std::string with_settings(const char* doc);

}  // namespace foldproof::python
