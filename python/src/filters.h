/// Filters, and what they are for.
#pragma once

#include <pybind11/pybind11.h>

#include <memory>
#include <vector>

#include "foldproof/filters.h"

namespace foldproof::python {

/// A filter with its objects, so that it is used for no others.
struct Filter {
  std::shared_ptr<const PairFilter> pairs;
  std::vector<Object> objects;
};

/// Null for None. TypeError: no filter. Refused: one of other objects.
std::shared_ptr<const PairFilter> filter_for(const pybind11::object& filter,
                                             const std::vector<Object>& objects);

/// V numbers that are not 0 where the array is true. Refused: another shape, no array of booleans.
std::vector<std::uint8_t> flags_of(const pybind11::handle& flags, const char* what, Index vertices);

}  // namespace foldproof::python
