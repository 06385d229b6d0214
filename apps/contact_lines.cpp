#include "contact_lines.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "report/verdict.h"
#include "terminal.h"

namespace foldproof {
namespace {

// A frame, or a time between two.
std::string time_name(double time) { return fmt::format("{:.6g}", time); }

// To a tenth of the contact's size, as far from the origin as it may be.
std::string place_of(const Contact& contact) {
  const Vec3& at = contact.point;
  const double places = std::ceil(std::log10(at.cwiseAbs().maxCoeff() / (contact.high - contact.low).norm()));
  const int digits = std::isfinite(places) ? std::clamp(static_cast<int>(places) + 2, 3, 17) : 3;
  return fmt::format("at ({:.{}g}, {:.{}g}, {:.{}g})", at[0], digits, at[1], digits, at[2], digits);
}

// The parts or objects; the place where there is only one object.
std::string who(const Contact& contact, Motions motions, const CheckSettings& settings) {
  if (motions.size() == 1 && parts_of(0, motions, settings).names.empty()) {
    return place_of(contact);
  }
  auto names = side_names(contact, motions, settings);
  for (std::string& name : names) name = cell(name);
  if (names[0] != names[1]) return names[0] + " - " + names[1];
  return contact.within() ? names[0] + " with itself" : names[0] + " with another";
}

std::string when(std::span<const Contact> contacts, const ContactGroup& group, const CheckTotals& totals) {
  if (is_single_frame(totals)) return fmt::format("frame {}", totals.first_frame);
  const bool crosses =
      std::ranges::any_of(group.contacts, [&](std::size_t k) { return !contacts[k].frames.empty(); });
  double first = std::numeric_limits<double>::infinity(), last = -first;
  for (const std::size_t k : group.contacts) {
    const Contact& contact = contacts[k];
    if (crosses && contact.frames.empty()) continue;
    first = std::min(first, crosses ? contact.frames.front().time : contact.first_time);
    last = std::max(last, crosses ? contact.frames.back().time : contact.last_time);
  }
  if (first == last) return (crosses ? "frame " : "time ") + time_name(first);
  return (crosses ? "frames " : "times ") + time_name(first) + (crosses ? "-" : " to ") + time_name(last);
}

std::string how_bad(const Contact& contact, const std::string& unit, const CheckTotals& totals) {
  if (contact.frames.empty()) {
    if (contact.pierces) {
      return fmt::format("pierces{}, {}", is_single_frame(totals) ? "" : " between frames",
                         counted(contact.pairs, "pair"));
    }
    const char* touches = totals.contact_unknown_frames > 0 ? "touches; not known whether it crosses"
                          : is_single_frame(totals)         ? "touches"
                                                            : "touches between frames";
    return fmt::format("{}, {}", touches, counted(contact.pairs, "pair"));
  }
  const ContactFrame& frame = contact.frames[contact.worst];
  const std::string start = contact.from_start ? ", from the start" : "";
  if (contact.pierces) {
    return fmt::format("worst {}: pierces in {}{}", time_name(frame.time), counted(frame.crossings, "place"),
                       start);
  }
  if (frame.touching) return fmt::format("touches, {}{}", counted(frame.triangles, "triangle"), start);
  return fmt::format("worst {}: {}{}, {}{}", time_name(frame.time), depth_text(frame, unit),
                     frame.depth ? " deep" : "", counted(frame.triangles, "triangle"), start);
}

}  // namespace

std::string contact_lines(Motions motions, const CheckSettings& settings, const CheckTotals& totals,
                          std::size_t count) {
  const bool is_cut = totals.contact_unknown_frames > 0 && !settings.steps_only;
  if (!totals.contacts_found || (totals.contacts.empty() && !is_cut)) return "";
  struct Line {
    std::string number, who, when, bad;
  };
  const std::string unit = unit_of(motions, settings);
  std::vector<Line> lines;
  std::array<std::size_t, 3> width{};
  const auto groups = group_contacts(totals.contacts);
  std::size_t listed = 0;
  for (const ContactGroup& group : std::span(groups).first(std::min(count, groups.size()))) {
    const Contact& worst = totals.contacts[group.contacts.front()];
    const std::string often = how_often(group);
    const Line& line = lines.emplace_back(Line{
        fmt::format("#{}", worst.number), who(worst, motions, settings), when(totals.contacts, group, totals),
        (often.empty() ? "" : often + ", ") + how_bad(worst, unit, totals)});
    listed += group.contacts.size();
    width[0] = std::max(width[0], line.number.size());
    width[1] = std::max(width[1], line.who.size());
    width[2] = std::max(width[2], line.when.size());
  }
  std::string text = "\n";
  if (!lines.empty()) text += counted(totals.contacts.size(), "contact") + ", the worst first:\n";
  for (const Line& line : lines) {
    fmt::format_to(std::back_inserter(text), "{:<{}}  {:<{}}  {:<{}}  {}\n", line.number, width[0], line.who,
                   width[1], line.when, width[2], line.bad);
  }
  if (listed < totals.contacts.size())
    text += fmt::format("and {} more (--contacts lists all)\n", grouped(totals.contacts.size() - listed));
  if (!totals.lists_all()) text += "Contacts join the listed pairs only (--limit).\n";
  if (totals.contact_unknown_frames > 0) {
    text += fmt::format("In {} it is not known which triangles cross{}.\n",
                        counted(totals.contact_unknown_frames, "frame"),
                        settings.steps_only ? " (--steps-only)" : ": too many pairs (--limit)");
  }
  return text;
}

}  // namespace foldproof
