/// What the page and the mailed report are told alike.
#pragma once

#include "page/step_store.h"
#include "report/json_values.h"

namespace foldproof {

Json step_json(const StepRecord& step);
Json start_json(const StartRecord& start);
/// As contact_json, of kind "tt".
Json crossing_json(const StartCrossing& crossing);
Json contact_json(const Contact& contact);

/// How the mesh is told by a model; null without one.
Json model_json(const Model* model);

/// {"error": line}
std::string error_json(const std::string& line);

/// The file at the end of a path, and how many more there are.
std::string title_of(Motions motions);

}  // namespace foldproof
