/// JSON values common to the page and the HTML report.
#pragma once

#include <exception>

#include "page/step_store.h"
#include "report/json_values.h"

namespace foldproof {

Json step_json(const StepRecord& step);
Json start_json(const StartRecord& start);
Json contact_json(const ContactPoint& contact);

/// What a model has learned of a mesh; null without one.
Json model_json(const Model* model);

/// {"error": line}
std::string error_json(const std::string& line);

/// One line for what a handler or the check threw.
std::string line_of(const std::exception& thrown);

/// The file name of the first motion, and the number of others.
std::string title_of(Motions motions);

}  // namespace foldproof
