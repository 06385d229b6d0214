#include "base/nearest_name.h"
#include "steps.h"

namespace foldproof::python {
namespace {

struct Flag {
  const char* name;
  bool StepSettings::*member;
};
constexpr Flag kFlags[] = {{"within", &StepSettings::within},
                           {"between", &StepSettings::between},
                           {"certificates", &StepSettings::certificates},
                           {"look_ahead", &StepSettings::look_ahead},
                           {"earliest_only", &StepSettings::earliest_only},
                           {"explain", &StepSettings::explain}};
struct Number {
  const char* name;
  double StepSettings::*member;
};
constexpr Number kNumbers[] = {{"thickness", &StepSettings::thickness},
                               {"tolerance", &StepSettings::tolerance}};

bool truth_of(const py::handle& value) {
  const int truth = PyObject_IsTrue(value.ptr());
  if (truth < 0) throw py::error_already_set();
  return truth == 1;
}

double number_of(const py::handle& value) {
  const double x = PyFloat_AsDouble(value.ptr());
  if (x == -1 && PyErr_Occurred() != nullptr) throw py::error_already_set();
  return x;
}

bool is_paper(const py::handle& value) {
  const std::string name = py::str(value).cast<std::string>();
  if (name == "proven" || name == "paper") return name == "paper";
  refuse("mode", "'" + name + "' is not known", "give 'proven' or 'paper'");
}

std::vector<std::string> setting_names() {
  std::vector<std::string> names{"mode", "miss_rate", "max_listed"};
  for (const Flag& flag : kFlags) names.emplace_back(flag.name);
  for (const Number& number : kNumbers) names.emplace_back(number.name);
  return names;
}

}  // namespace

void refuse_keyword(const std::string& name, const char* of, const std::vector<std::string>& names) {
  const auto near = nearest_name(name, names);
  throw py::type_error("'" + name + "' is not a setting of " + of +
                       (near ? "; did you mean '" + *near + "'?" : ""));
}

Settings settings_of(const py::kwargs& settings, const std::vector<std::string>& others) {
  StepSettings s;
  bool paper = false;
  double miss_rate = 0.01;
  for (const auto& [key, value] : settings) {
    const auto name = key.cast<std::string>();
    bool known = name == "mode" || name == "miss_rate" || name == "max_listed";
    if (name == "mode") paper = is_paper(value);
    if (name == "miss_rate") miss_rate = number_of(value);
    if (name == "max_listed") s.max_listed = whole_number(value, "max_listed", 0, UINT64_MAX);
    for (const auto& [flag, member] : kFlags) {
      if (name == flag) known = true, s.*member = truth_of(value);
    }
    for (const auto& [number, member] : kNumbers) {
      if (name == number) known = true, s.*member = number_of(value);
    }
    if (!known) {
      std::vector<std::string> names = setting_names();
      names.insert(names.end(), others.begin(), others.end());
      refuse_keyword(name, "a check", names);
    }
  }
  if (!s.within && !s.between)
    refuse("within and between", "are both off, so nothing would be tested", "leave one of them on");
  return {s, paper ? std::optional(miss_rate) : std::nullopt};
}

void refuse_given(const char* with, std::initializer_list<std::pair<const char*, bool>> settings) {
  for (const auto& [name, is_given] : settings) {
    if (is_given) refuse(name, std::string("does not go with ") + with, "omit one of them");
  }
}

void require_static_fits(const char* with, const StepSettings& settings) {
  refuse_given(with, {{"thickness", settings.thickness != 0},
                      {"tolerance", settings.tolerance != 0},
                      {"earliest_only", settings.earliest_only}});
}

std::string settings_documentation() {
  return "settings, all by keyword:\n"
         "  within=True          collisions of each object with itself\n"
         "  between=True         collisions of every two objects\n"
         "  thickness=0.0        mesh units; closer than or equal to this is a collision\n"
         "  tolerance=0.0        mesh units; how far beyond it a reported pair may be. 0: 2^-30 of the "
         "scene\n"
         "  certificates=True    skip what certificates prove free; never changes the answer\n"
         "  look_ahead=True      let one search cover several steps while a motion continues in straight "
         "lines; never changes the answer\n"
         "  earliest_only=False  find only the pair with the earliest time of impact\n"
         "  max_listed=10000000  list at most so many pairs of each kind in a step, those with the smallest "
         "ids; all are counted\n"
         "  explain=False        steps of a checker: report what certificates proved "
         "(StepResult.explanation)\n"
         "  mode='proven'        or 'paper', which is STATISTICAL and can miss collisions\n"
         "  miss_rate=0.01       mode 'paper': at most this share of what is unproven in training is still "
         "predicted free; new motions miss more";
}

std::string with_settings(const char* doc) { return std::string(doc) + "\n\n" + settings_documentation(); }

py::dict work_of(const Work& work) {
  py::dict d;
  d["refits"] = work.refits;
  d["node_tests"] = work.node_tests;
  d["certificate_tests"] = work.certificate_tests;
  d["certificate_passes"] = work.certificate_passes;
  d["leaf_pairs"] = work.leaf_pairs;
  d["candidates_vf"] = work.candidates_vf;
  d["candidates_ee"] = work.candidates_ee;
  d["undecided"] = work.undecided;
  return d;
}

py::dict milliseconds_of(const StageTimes& times) {
  py::dict d;
  d["total"] = times.total;
  d["update"] = times.update;
  d["traverse"] = times.traverse;
  d["narrow"] = times.narrow;
  return d;
}

py::list items_of(const py::object& one_or_several) {
  if (py::isinstance<py::list>(one_or_several) || py::isinstance<py::tuple>(one_or_several))
    return py::list(one_or_several);
  py::list one;
  one.append(one_or_several);
  return one;
}

}  // namespace foldproof::python
