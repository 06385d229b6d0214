/// Contacts as instances of the Python class foldproof.Contact.
#pragma once

#include <pybind11/pybind11.h>

#include <array>
#include <string>
#include <vector>

#include "report/report.h"

namespace foldproof::python {

/// `names`: of the two sides.
pybind11::object contact_of(const Contact& contact, const std::array<std::string, 2>& names);

/// The parts of one object: None, or a name per triangle. Refused: other lengths. `where`: for the message.
ObjectParts object_parts(const pybind11::handle& names, std::size_t triangles, const std::string& where);

/// The parts of objects, or of motions: None, or an entry for each, which is None or has a name per triangle.
/// `owners`: what the caller gave, whose only one takes the entry itself. Refused: other lengths.
/// `triangles`: the number of triangles of each.
std::vector<ObjectParts> parts_of(const pybind11::object& parts, const pybind11::object& owners,
                                  const std::vector<std::size_t>& triangles);

}  // namespace foldproof::python
