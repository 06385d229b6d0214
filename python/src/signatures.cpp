// Signatures for inspect.signature. CPython reads them from a documentation that begins with
// "name(arguments)\n--\n\n", without types; pybind11 writes "name(arguments: types) -> type\n\n".
#include <pybind11/pybind11.h>

#include <cstdlib>
#include <cstring>
#include <string>

#include "module.h"

namespace foldproof::python {

namespace py = pybind11;

namespace {

/// "f(x: Tuple[int, int], *, keep: bool = True) -> int" becomes "f(x, *, keep=True)".
std::string without_types(const std::string& line) {
  std::string out;
  int depth = 0;
  bool in_type = false;
  for (const char c : line) {
    if (c == '(' || c == '[' || c == '{') ++depth;
    if (c == ')' || c == ']' || c == '}') --depth;
    const bool ends_type = depth == 0 || (depth == 1 && (c == ',' || c == '='));
    if (depth == 1 && c == ':') in_type = true;
    if (ends_type) in_type = false;
    if (!in_type && c != ' ') out += c;
    if (depth == 0 && c == ')') break;
  }
  return out;
}

/// Rewrites the documentation of a function that pybind11 made.
void rewrite(const py::handle& function) {
  PyMethodDef* definition = reinterpret_cast<PyCFunctionObject*>(function.ptr())->m_ml;
  const std::string doc = definition->ml_doc == nullptr ? "" : definition->ml_doc;
  const std::size_t end = doc.find('\n');
  if (doc.rfind(std::string(definition->ml_name) + '(', 0) != 0 || end == std::string::npos) return;
  const std::size_t text = doc.find_first_not_of('\n', end);
  const std::string made = without_types(doc.substr(0, end)) + "\n--\n\n" +
                           (text == std::string::npos ? std::string() : doc.substr(text));
  // pybind11 allocates and frees it like this.
  std::free(const_cast<char*>(definition->ml_doc));  // NOLINT(cppcoreguidelines-no-malloc)
  definition->ml_doc = strdup(made.c_str());
}

void add_signature_of_class(const py::handle& made) {
  for (const auto& [name, member] : py::dict(made.attr("__dict__"))) {
    if (PyInstanceMethod_Check(member.ptr())) rewrite(PyInstanceMethod_GET_FUNCTION(member.ptr()));
  }
  if (!made.attr("__dict__").contains("__init__")) return;
  const py::object whole = py::module_::import("inspect").attr("signature")(made.attr("__init__"));
  py::list parameters(whole.attr("parameters").attr("values")());
  parameters.attr("pop")(0);  // self
  py::setattr(made, "__signature__", whole.attr("replace")(py::arg("parameters") = parameters));
}

}  // namespace

void add_signatures(const py::module_& module) {
  for (const auto& [name, thing] : py::dict(module.attr("__dict__"))) {
    if (PyCFunction_Check(thing.ptr())) rewrite(thing);
    if (PyType_Check(thing.ptr())) add_signature_of_class(thing);
  }
}

}  // namespace foldproof::python
