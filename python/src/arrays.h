/// Conversion of NumPy arrays, and of errors to Python exceptions.
#pragma once

#include <pybind11/numpy.h>

#include <initializer_list>
#include <memory>
#include <string>
#include <vector>

#include "foldproof/mesh.h"

namespace foldproof::python {

namespace py = pybind11;

/// A C++ exception that becomes foldproof.Error.
struct Refused {
  Error error;
};

[[noreturn]] void refuse(std::string where, std::string problem, std::string remedy);

template <class T>
T take(Result<T>&& result) {
  if (!result) throw Refused{std::move(result.error())};
  if constexpr (!std::is_void_v<T>) return std::move(*result);
}

/// Makes Refused an instance of a class in python/foldproof/_errors.py.
void translate_errors();

/// A caller's float64 array: in place if C-contiguous and aligned, else a copy. Keeps it alive.
using Numbers =
    py::array_t<double, py::array::c_style | py::array::forcecast | py::detail::npy_api::NPY_ARRAY_ALIGNED_>;

/// `shape`: the required size of each dimension, -1 for any. `layout`: the same in words ("V x 3"). Refused:
/// other shapes, objects without real numbers.
Numbers numbers_of(const py::handle& x, const char* what, std::initializer_list<py::ssize_t> shape,
                   const char* layout);

/// Refused: numbers that are not finite, at the first one's place, as "frames[3, 7, 1]".
void require_finite(const Numbers& x, const char* what);

inline std::span<const double> span_of(const Numbers& x) {
  return {x.data(), static_cast<std::size_t>(x.size())};
}

/// Ids in row-major order; may be empty. `thing`: "vertex" or "group"; `columns` 1: a one-dimensional array.
/// Refused: other shapes, numbers that are not ids.
std::vector<Index> ids_of(const py::handle& x, const char* what, const char* thing, py::ssize_t columns,
                          const char* layout);

template <std::size_t N>
std::vector<std::array<Index, N>> rows_of(const std::vector<Index>& ids) {
  std::vector<std::array<Index, N>> rows(ids.size() / N);
  for (std::size_t i = 0; i < N * rows.size(); ++i) rows[i / N][i % N] = ids[i];
  return rows;
}

/// T x 3 ids. Refused: other shapes, numbers that are not ids.
std::vector<Triangle> triangles_of(const py::handle& x);

/// str, bytes or os.PathLike. Refused: an empty one.
std::string path_of(const py::handle& path);

/// Text for messages, with escapes for invalid UTF-8, which file names may contain.
py::str text_of(const std::string& text);
/// A message of the library, with Python's arguments where it names options of the program.
py::object message_of(const std::string& text);

/// TypeError: no whole number. Refused: one out of range.
std::uint64_t whole_number(const py::handle& value, const char* what, std::uint64_t least = 0,
                           std::uint64_t most = kNoIndex);

/// A read-only array over memory of `owner`, which it keeps alive.
template <class T>
py::array view_of(const T* data, std::vector<py::ssize_t> shape, const py::object& owner) {
  py::array array(py::dtype::of<T>(), std::move(shape), data, owner);
  array.attr("setflags")(py::arg("write") = false);
  return array;
}
template <class T>
py::array view_of(const std::vector<T>& values, const py::object& owner) {
  return view_of(values.data(), {static_cast<py::ssize_t>(values.size())}, owner);
}

/// A read-only array that owns the rows.
template <class T>
py::array owned_rows(std::vector<T> rows) {
  auto storage = std::make_unique<std::vector<T>>(std::move(rows));
  const std::vector<T>& kept = *storage;
  return view_of(kept,
                 py::capsule(storage.release(), [](void* p) { delete static_cast<std::vector<T>*>(p); }));
}

/// An array that owns the numbers.
py::array_t<double> owned(std::vector<double>&& values, std::vector<py::ssize_t> shape);

}  // namespace foldproof::python
