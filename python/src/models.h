/// What other parts of the module ask of a model.
#pragma once

#include "foldproof/model.h"

namespace foldproof::python {

/// Refused: a model that has learned no shapes.
const Learned& learned_of(const Model& model);

}  // namespace foldproof::python
