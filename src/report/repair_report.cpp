#include "report/repair_report.h"

#include <fmt/format.h>

#include <algorithm>

#include "report/text_file.h"

namespace foldproof {
namespace {

void append(Sentence& out, const Sentence& more) {
  for (const auto& piece : more.pieces()) {
    if (const double* time = std::get_if<double>(&piece)) {
      out.frame(*time);
    } else {
      out << std::get<std::string>(piece);
    }
  }
}

// Without what was left.
Sentence sentence_of(const RepairRequest& request, const RepairReport& report) {
  const char* but = report.among_fixed.empty() ? "" : ", apart from what may not move, which touches itself";
  Sentence out;
  if (!report.left.empty() && report.before.empty())
    return out << "The motion is as it was: none of the contacts was chosen";
  if (!report.left.empty() && report.free)
    return out << "Proven: what was chosen is gone, in all frames and at all times between them";
  if (report.unchanged) return out << "The motion is as it was: nothing touches" << but;
  if (report.free) return out << "Proven: nothing touches, in no frame and at no time between frames" << but;
  const auto is_free = [](const RepairedFrame& f) { return f.limit == RepairLimit::None; };
  if (!report.written && std::ranges::none_of(report.frames, is_free)) {
    out << "No frame is free and none could be made so: nothing was written";
  } else {
    out << (report.written ? "Not all could be repaired"
                           : "Nothing could be repaired, and nothing was written")
        << ": something touches in ";
    append(out, frames_named(report.frames, [&](const RepairedFrame& f) { return !is_free(f); }));
    if (no_way(request, report)) out << "; what may not move may be in the way";
  }
  return out;
}

Json contacts_json(Motions motions, const CheckSettings& settings, const RepairReport& report,
                   const std::vector<Contact>& contacts) {
  const CheckTotals totals = contact_totals(contacts, report);
  const auto groups = groups_of(totals.contacts);
  Json json = Json::array();
  for (std::size_t k = 0; k < groups.size(); ++k) {
    const Contact& contact = totals.contacts[k];
    json.push_back(contact_json(contact, side_names(contact, motions, settings), groups[k], false));
  }
  return json;
}

}  // namespace

bool no_way(const RepairRequest& request, const RepairReport& report) {
  return request.fixes() &&
         std::ranges::any_of(report.frames, [](auto& f) { return f.limit == RepairLimit::GivenUp; });
}

CheckTotals contact_totals(std::vector<Contact> contacts, const RepairReport& report) {
  CheckTotals totals;
  totals.contacts_found = true;
  totals.first_frame = static_cast<Index>(report.frames.front().time);
  totals.last_frame = static_cast<Index>(report.frames.back().time);
  std::ranges::sort(contacts, is_worse);
  totals.contacts = std::move(contacts);
  return totals;
}

Sentence frames_named(const std::vector<RepairedFrame>& frames,
                      const std::function<bool(const RepairedFrame&)>& is_meant) {
  constexpr int kMostRuns = 8;
  const auto count = static_cast<std::size_t>(std::ranges::count_if(frames, is_meant));
  Sentence out;
  if (count == 0) return out;
  out << (count == 1 ? "frame " : "frames ");
  std::size_t named = 0;
  int runs = 0;
  for (std::size_t i = 0; i < frames.size() && runs < kMostRuns; ++i) {
    if (!is_meant(frames[i])) continue;
    const std::size_t first = i;
    while (i + 1 < frames.size() && is_meant(frames[i + 1])) ++i;
    named += i + 1 - first;
    if (++runs > 1) out << ", ";
    out.frame(frames[first].time);
    if (i > first) (out << "-").frame(frames[i].time);
  }
  if (count > named) out << fmt::format(" and {} more", count - named);
  return out;
}

CheckVerdict repair_verdict(Motions motions, const RepairRequest& request, const RepairReport& report) {
  auto not_tested = untested(motions, request.check, contact_totals({}, report));
  if (request.check.step.thickness > 0 && request.fixes())
    not_tested.emplace_back("what may not move was not tested with itself for the thickness");
  CheckVerdict out{.kind = !report.free          ? CheckVerdictKind::Found
                           : report.left.empty() ? CheckVerdictKind::Free
                                                 : CheckVerdictKind::Limited,
                   .sentence = sentence_of(request, report),
                   .numbers = {},
                   .whole = not_tested.empty() && report.among_fixed.empty() && report.left.empty()};
  if (!report.left.empty()) {
    out.sentence << "; left: ";
    append(out.sentence, contact_sentence(motions, request.check, contact_totals(report.left, report)));
  }
  out.sentence << with_untested(".", not_tested);
  return out;
}

Json repair_json(Motions motions, const RepairRequest& request, const RepairReport& report) {
  Json frames = Json::array();
  for (const RepairedFrame& f : report.frames) {
    frames.push_back({{"time", f.time},
                      {"correction", f.correction},
                      {"late", f.late},
                      {"limit", kRepairLimitNames[static_cast<std::size_t>(f.limit)]}});
  }
  Json json = {{"foldproof", version()},
               {"objects", objects_json(motions, request.check)},
               {"verdict", verdict_json(repair_verdict(motions, request, report))},
               {"free", report.free},
               {"unchanged", report.unchanged},
               {"written", report.written},
               {"interrupted", report.interrupted},
               {"open_loop", report.open_loop},
               {"thickness", request.check.step.thickness},
               {"falloff", report.falloff},
               {"clearance", report.clearance},
               {"frames", frames}};
  if (const std::string unit = unit_of(motions, request.check); !unit.empty()) json["unit"] = unit;
  const auto list = [&](const char* name, const std::vector<Contact>& contacts) {
    json[name] = contacts_json(motions, request.check, report, contacts);
  };
  list("before", report.before);
  list("remaining", report.remaining);
  list("left", report.left);
  list("among_fixed", report.among_fixed);
  return json;
}

Result<void> write_repair_json(const std::string& path, Motions motions, const RepairRequest& request,
                               const RepairReport& report) {
  TextFile file(FOLDPROOF_TRY(FileWriter::open(path)));
  file.add("{}\n", dump(repair_json(motions, request, report)));
  return file.commit();
}

}  // namespace foldproof
