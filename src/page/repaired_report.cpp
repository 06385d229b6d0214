#include "page/repaired_report.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/grouped.h"
#include "base/try.h"
#include "page/report_file.h"
#include "report/contact_pictures.h"
#include "report/repair_report.h"

namespace foldproof {
namespace {

constexpr std::size_t kListedContacts = 200, kPairsOfPictures = 10;
constexpr ContactPictures::Format kSideBySide{640, 420, true};

// The worst contact of each group: those that are drawn.
std::vector<Contact> drawn_of(const RepairReport& report) {
  const auto contacts = contact_totals(report.before, report).contacts;
  std::vector<Contact> drawn;
  for (const ContactGroup& group : group_contacts(contacts)) {
    if (drawn.size() < kPairsOfPictures) drawn.push_back(contacts[group.contacts[0]]);
  }
  return drawn;
}

// Whether something of a contact is left: one of the same sides, at the same time and place.
bool remains(const Contact& contact, const RepairReport& report) {
  const auto sides = [](const Contact& c) {
    const auto name = [](const Contact::Side& side) { return std::pair(side.object, side.part); };
    return std::minmax({name(c.sides[0]), name(c.sides[1])});
  };
  return std::ranges::any_of(report.remaining, [&](const Contact& other) {
    return sides(other) == sides(contact) && contact.first_time <= other.last_time &&
           other.first_time <= contact.last_time && (contact.low - other.high).maxCoeff() <= 0 &&
           (other.low - contact.high).maxCoeff() <= 0;
  });
}

Result<void> add_pictures(TextFile& fields, Motions motions, const RepairRequest& request,
                          const RepairedMotions& done) {
  std::vector<std::unique_ptr<Motion>> after;
  std::vector<double> times;
  if (done.report.written && !done.report.unchanged) {
    for (Index i = 0; i < motions.size(); ++i) after.push_back(done.motion(i));
    for (const RepairedFrame& frame : done.report.frames) times.push_back(frame.time);
  }
  auto pictures = FOLDPROOF_TRY(ContactPictures::open(motions, request.check));
  const char* separator = "";
  for (const Contact& contact : drawn_of(done.report)) {
    const bool has_after =
        !times.empty() && times.front() <= contact.first_time && contact.last_time <= times.back();
    const Json json = {
        {"contact", contact.number},
        {"remains", remains(contact, done.report)},
        {"before", data_url(FOLDPROOF_TRY(pictures.draw(contact, kSideBySide)))},
        {"after", has_after
                      ? Json(data_url(FOLDPROOF_TRY(pictures.draw_in(after, times, contact, kSideBySide))))
                      : Json()}};
    fields.add("{}\n{}", std::exchange(separator, ","), embedded(json));
    FOLDPROOF_TRY(fields.flush_if_large());
  }
  return {};
}

}  // namespace

Result<void> write_repaired_report(const std::string& path, Motions motions, const RepairRequest& request,
                                   const RepairedMotions& done, const std::string& command,
                                   std::span<const PageFile> files) {
  auto file = FOLDPROOF_TRY(ReportFile::open(path, motions, request.check, command, files));
  Json repair = repair_json(motions, request, done.report);
  Json& counts = repair["counts"] = Json::object();
  for (const char* list : {"before", "remaining", "left", "among_fixed"}) {
    Json& contacts = repair[list];
    counts[list] = contacts.size();
    if (contacts.size() > kListedContacts) contacts.erase(contacts.begin() + kListedContacts, contacts.end());
  }
  Json& fixed = repair["fixed"] = request.fixed;
  for (Index i = 0; i < request.fixed_vertices.size(); ++i) {
    const auto& vertices = request.fixed_vertices[i];
    if (!vertices.empty())
      fixed.push_back(
          fmt::format("{} of the vertices of {}", grouped(vertices.size()), short_name(i, motions)));
  }
  repair["only"] = request.only;
  repair["between"] = request.between;
  repair["ignore"] = request.check.ignore;
  file.fields().add("\"repair\":{},\n\"pictures\":[", embedded(repair));
  FOLDPROOF_TRY(add_pictures(file.fields(), motions, request, done));
  file.fields().add("\n]");
  return file.commit();
}

}  // namespace foldproof
