/// The learned part of a model as text and as JSON, for train and info.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "foldproof/model.h"

namespace foldproof {

/// "0.0123  (0.45 %)": a distance in mesh units and as a share of the size.
std::string distance_text(double distance, double size);

/// What was learned, its errors, and the poses and regions that it represents badly. Never empty.
std::string learned_summary(const Model& model);

/// The errors of every pose, and the regions of largest error.
std::string learned_tables(const Model& model);

/// null when nothing was learned.
nlohmann::ordered_json learned_json(const Model& model);

}  // namespace foldproof
