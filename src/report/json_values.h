/// JSON values common to all reports (docs/reports.md).
#pragma once

#include <nlohmann/json.hpp>

#include "report/verdict.h"

namespace foldproof {

using Json = nlohmann::ordered_json;

/// One line of JSON. Invalid UTF-8, which file names may contain, becomes U+FFFD.
std::string dump(const Json& json);

Json to_json(const CollisionCounts& counts, bool poses);
Json to_json(const StageTimes& times);
Json to_json(const Work& work);
/// "by_format", "always" or "never".
const char* name_of(Weld weld);
Json objects_json(Motions motions, const CheckSettings& settings);
Json settings_json(const ReportInfo& info, Motions motions);
/// Adds the fields of statistical answers.
void add_misses(Json& json, std::uint64_t missed, double proven_milliseconds);
/// `lists`: with the triangles of both sides and the curves, in the worst frame.
Json contact_json(const Contact& contact, const std::array<std::string, 2>& names,
                  const GroupOfContact& group, bool lists);

/// The sentence as a text, and in parts: texts and, in turn, frames.
Json verdict_json(const CheckVerdict& verdict);
Json totals_json(const CheckTotals& totals, bool poses, bool statistical);

}  // namespace foldproof
