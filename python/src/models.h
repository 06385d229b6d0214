/// What other parts of the module ask of models.
#pragma once

#include <pybind11/pybind11.h>

#include "foldproof/model.h"

namespace foldproof::python {

/// Refused: a model that has learned no shapes.
const Learned& learned_of(const Model& model);

/// One per motion, null for none; none at all for None. Refused: anything else.
std::vector<std::shared_ptr<const Model>> models_of(const pybind11::object& models, std::size_t motions);

}  // namespace foldproof::python
