#include "arrays.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

namespace foldproof::python {
namespace {

/// The Python class for an error.
const char* class_of(const Error& error) {
  if (error.code != ErrorCode::FileAccess) return "Error";
  std::error_code failure;
  const bool missing =
      std::filesystem::status(error.where, failure).type() == std::filesystem::file_type::not_found;
  return missing ? "FileMissingError" : "FileError";
}

std::string shape_text(const py::array& x) { return py::str(py::tuple(x.attr("shape"))).cast<std::string>(); }

/// Converts anything that NumPy can make an array of.
py::array any_array(const py::handle& x, const char* what, const char* layout) {
  auto array = py::array::ensure(x);
  if (!array) refuse(what, "is no array", std::string("give ") + layout + " numbers");
  if (py::hasattr(x, "mask") && py::module_::import("numpy.ma").attr("is_masked")(x).cast<bool>())
    refuse(what, "has masked entries", "fill them, for example with filled()");
  return array;
}

}  // namespace

void refuse(std::string where, std::string problem, std::string remedy) {
  throw Refused{{std::move(where), std::move(problem), std::move(remedy)}};
}

void translate_errors() {
  // By value, as pybind11 calls it. NOLINTNEXTLINE(performance-unnecessary-value-param)
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const Refused& refused) {
      const Error& error = refused.error;
      const bool is_option = error.where.starts_with("--");  // else perhaps the name of a file
      const py::object made =
          py::module_::import("foldproof._errors")
              .attr(class_of(error))(is_option ? message_of(error.where) : text_of(error.where),
                                     message_of(error.problem), message_of(error.remedy));
      PyErr_SetObject(py::type::of(made).ptr(), made.ptr());
    }
  });
}

Numbers numbers_of(const py::handle& x, const char* what, std::initializer_list<py::ssize_t> shape,
                   const char* layout) {
  const py::array array = any_array(x, what, layout);
  const char kind = array.dtype().kind();
  if (kind != 'f' && kind != 'i' && kind != 'u') {
    refuse(what, "holds " + py::str(array.dtype()).cast<std::string>() + ", not real numbers",
           "give an array of float64");
  }
  bool fits = array.ndim() == static_cast<py::ssize_t>(shape.size());
  for (std::size_t k = 0; fits && k < shape.size(); ++k) {
    const py::ssize_t required = shape.begin()[k];
    fits = required < 0 || array.shape(static_cast<py::ssize_t>(k)) == required;
  }
  if (!fits) refuse(what, "has shape " + shape_text(array), std::string("give ") + layout);
  auto numbers = Numbers::ensure(array);
  if (!numbers) throw py::error_already_set();
  return numbers;
}

void require_finite(const Numbers& x, const char* what) {
  const auto numbers = span_of(x);
  const auto bad = std::find_if(numbers.begin(), numbers.end(), [](double v) { return !std::isfinite(v); });
  if (bad == numbers.end()) return;
  auto rest = static_cast<py::ssize_t>(bad - numbers.begin());
  std::string place;
  for (py::ssize_t k = x.ndim(); k-- > 0; rest /= x.shape(k)) {
    if (!place.empty()) place.insert(0, ", ");
    place.insert(0, std::to_string(rest % x.shape(k)));
  }
  refuse(what + ("[" + place + "]"), "is not finite", "give finite numbers");
}

std::vector<Index> ids_of(const py::handle& x, const char* what, const char* thing, py::ssize_t columns,
                          const char* layout) {
  const py::array array = any_array(x, what, layout);
  if (array.size() == 0) return {};
  const char kind = array.dtype().kind();
  if (kind != 'i' && kind != 'u') {
    refuse(what, "hold " + py::str(array.dtype()).cast<std::string>() + ", not integers",
           "give ids, for example as uint32");
  }
  const bool fits = columns == 1 ? array.ndim() == 1 : array.ndim() == 2 && array.shape(1) == columns;
  if (!fits) refuse(what, "have shape " + shape_text(array), std::string("give ") + layout);
  const auto wide = py::array_t<std::int64_t, py::array::c_style | py::array::forcecast>::ensure(array);
  if (!wide) throw py::error_already_set();
  std::vector<Index> ids;
  ids.reserve(static_cast<std::size_t>(wide.size()));
  for (py::ssize_t i = 0; i < wide.size(); ++i) {
    const std::int64_t id = wide.data()[i];
    if (id < 0 || id >= kNoIndex) {
      const std::string given =
          kind == 'u' ? std::to_string(static_cast<std::uint64_t>(id)) : std::to_string(id);
      refuse(what, "row " + std::to_string(i / columns) + " names " + thing + ' ' + given,
             std::string("count ") + (thing == std::string("vertex") ? "vertices" : "groups") + " from 0");
    }
    ids.push_back(static_cast<Index>(id));
  }
  return ids;
}

std::vector<Triangle> triangles_of(const py::handle& x) {
  return rows_of<3>(ids_of(x, "triangles", "vertex", 3, "T x 3 vertex ids"));
}

std::string path_of(const py::handle& path) {
  PyObject* bytes = nullptr;
  if (PyUnicode_FSConverter(path.ptr(), &bytes) == 0) throw py::error_already_set();
  auto name = py::reinterpret_steal<py::bytes>(bytes).cast<std::string>();
  if (name.empty()) refuse("path", "is empty", "name a file");
  return name;
}

py::str text_of(const std::string& text) {
  PyObject* decoded =
      PyUnicode_DecodeUTF8(text.data(), static_cast<py::ssize_t>(text.size()), "backslashreplace");
  if (decoded == nullptr) throw py::error_already_set();
  return py::reinterpret_steal<py::str>(decoded);
}

py::object message_of(const std::string& text) {
  return py::module_::import("foldproof._errors").attr("with_arguments")(text_of(text));
}

std::uint64_t whole_number(const py::handle& value, const char* what, std::uint64_t least,
                           std::uint64_t most) {
  if (PyIndex_Check(value.ptr()) == 0) throw py::type_error(std::string(what) + ": expected an int");
  const auto number = py::reinterpret_steal<py::object>(PyNumber_Index(value.ptr()));
  if (!number) throw py::error_already_set();
  const std::uint64_t whole = PyLong_AsUnsignedLongLong(number.ptr());
  const bool fits = PyErr_Occurred() == nullptr;
  PyErr_Clear();
  if (!fits || whole < least || whole > most) {
    refuse(what, "is " + py::str(number).cast<std::string>(),
           "give a whole number from " + std::to_string(least) + " to " + std::to_string(most));
  }
  return whole;
}

py::array_t<double> owned(std::vector<double>&& values, std::vector<py::ssize_t> shape) {
  auto storage = std::make_unique<std::vector<double>>(std::move(values));
  const double* data = storage->data();
  const py::capsule owner(storage.release(), [](void* p) { delete static_cast<std::vector<double>*>(p); });
  return py::array_t<double>(std::move(shape), data, owner);
}

}  // namespace foldproof::python
