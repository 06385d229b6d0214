/// NumPy arrays in and out, and our errors as Python exceptions.
#pragma once

#include <pybind11/numpy.h>

#include <initializer_list>
#include <string>
#include <vector>

#include "foldproof/mesh.h"

namespace foldproof::python {

namespace py = pybind11;

/// Becomes foldproof.Error.
struct Refused {
  Error error;
};

[[noreturn]] void refuse(std::string where, std::string problem, std::string mend);

template <class T>
T take(Result<T>&& result) {
  if (!result) throw Refused{std::move(result.error())};
  if constexpr (!std::is_void_v<T>) return std::move(*result);
}

/// Makes the class foldproof.Error.
void bind_errors(py::module_& module);

/// A caller's float64 numbers: in place where they are C-contiguous and aligned, else a copy. Keeps them
/// alive.
using Numbers =
    py::array_t<double, py::array::c_style | py::array::forcecast | py::detail::npy_api::NPY_ARRAY_ALIGNED_>;

/// `shape`: what is asked of each dimension, -1 for any. `layout` says it in words ("V x 3"). Refused: other
/// shapes, what holds no real numbers.
Numbers numbers_of(const py::handle& x, const char* what, std::initializer_list<py::ssize_t> shape,
                   const char* layout);

inline std::span<const double> span_of(const Numbers& x) {
  return {x.data(), static_cast<std::size_t>(x.size())};
}

/// Integers, one after the other; `thing`: "vertex" or "group", `columns` 1: of one dimension. None where the
/// array is empty. Refused: other shapes, numbers that are no ids.
std::vector<Index> ids_of(const py::handle& x, const char* what, const char* thing, py::ssize_t columns,
                          const char* layout);

template <std::size_t N>
std::vector<std::array<Index, N>> rows_of(const std::vector<Index>& ids) {
  std::vector<std::array<Index, N>> rows(ids.size() / N);
  for (std::size_t i = 0; i < N * rows.size(); ++i) rows[i / N][i % N] = ids[i];
  return rows;
}

/// T x 3 integers. Refused: other shapes, numbers that are no ids.
std::vector<Triangle> triangles_of(const py::handle& x);

/// str, bytes or os.PathLike.
std::string path_of(const py::handle& path);

/// Text for people; what came from a file need not be UTF-8.
py::str text_of(const std::string& text);

/// A read-only array over memory that belongs to `owner`, which it keeps alive.
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

/// An array that takes over the numbers.
py::array_t<double> owned(std::vector<double>&& values, std::vector<py::ssize_t> shape);

}  // namespace foldproof::python
