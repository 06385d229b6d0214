#include "contact_lines.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

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

std::string when(const Contact& contact, const CheckTotals& totals) {
  if (is_single_frame(totals)) return fmt::format("frame {}", totals.first_frame);
  if (contact.frames.empty()) {
    const std::string first = time_name(contact.first_time), last = time_name(contact.last_time);
    return first == last ? "time " + first : fmt::format("times {} to {}", first, last);
  }
  const double first = contact.frames.front().time, last = contact.frames.back().time;
  return first == last ? "frame " + time_name(first)
                       : fmt::format("frames {}-{}", time_name(first), time_name(last));
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
  const std::string space = unit.empty() ? "" : " " + unit;
  const std::string start = contact.from_start ? ", from the start" : "";
  if (contact.pierces) {
    return fmt::format("worst {}: pierces in {}{}", time_name(frame.time), counted(frame.crossings, "place"),
                       start);
  }
  std::string text = fmt::format("worst {}: {}", time_name(frame.time), counted(frame.triangles, "triangle"));
  text += frame.depth ? fmt::format(", {:.3g}{} deep", *frame.depth, space)
                      : fmt::format(", no region: crosses along {:.3g}{}", frame.curve_length, space);
  return text + start;
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
  for (const Contact& contact : std::span(totals.contacts).first(std::min(count, totals.contacts.size()))) {
    const Line& line =
        lines.emplace_back(Line{fmt::format("#{}", contact.number), who(contact, motions, settings),
                                when(contact, totals), how_bad(contact, unit, totals)});
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
  if (lines.size() < totals.contacts.size()) {
    text +=
        fmt::format("and {} more (--contacts lists all)\n", grouped(totals.contacts.size() - lines.size()));
  }
  if (!totals.lists_all()) text += "Contacts join the listed pairs only (--limit).\n";
  if (totals.contact_unknown_frames > 0) {
    text += fmt::format("In {} it is not known which triangles cross{}.\n",
                        counted(totals.contact_unknown_frames, "frame"),
                        settings.steps_only ? " (--steps-only)" : ": too many pairs (--limit)");
  }
  return text;
}

}  // namespace foldproof
