#include "report/verdict.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "base/grouped.h"
#include "report/assumed.h"

namespace foldproof {
namespace {

bool starts_crossing(const CheckTotals& totals) { return totals.starts_crossing.value_or(0) > 0; }

/// A sentence's begin in capitals.
std::string capital(std::string text) {
  if (!text.empty() && text[0] >= 'a' && text[0] <= 'z') text[0] = static_cast<char>(text[0] - 'a' + 'A');
  return text;
}

/// What is said if nothing was found, without the full stop. It claims freedom only if everything was tested.
Sentence clean_sentence(const CheckSettings& settings, const CheckTotals& totals,
                        const std::string& subject) {
  Sentence out;
  const std::string all = totals.steps == 1 ? "the one step" : "all " + counted(totals.steps, "step");
  if (settings.poses) {
    out << "No triangles cross in ";
    if (totals.steps == 1) {
      (out << "frame ").frame(totals.first_frame);
    } else {
      out << "any of " + counted(totals.steps, "frame");
    }
    return out << subject << ", proven. What happens between frames was not tested";
  }
  if (!totals.starts_crossing) {
    out << "No contact begins in " << all << subject << ", proven. Crossings from frame ";
    return out.frame(totals.first_frame) << " on were not tested (--steps-only)";
  }
  out << "No collisions" << subject << ": no triangles cross in frame ";
  out.frame(totals.first_frame);
  if (!is_single_frame(totals))
    return out << ", and " << all << (totals.steps == 1 ? " is" : " are") << " proven free";
  return out << (settings.step.thickness > 0 ? ", and all is farther apart than the thickness, proven"
                                             : ", proven");
}

/// What was found, in numbers.
std::string found_sentence(const CheckSettings& settings, const CheckTotals& totals,
                           const std::string& subject) {
  std::string text;
  if (starts_crossing(totals)) {
    text = capital(start_of(totals));
    if (totals.collisions.sum() == 0)
      return text + (is_single_frame(totals) ? "" : "; no other contact begins in the steps") + subject + ".";
    text += ". ";
  }
  if (!settings.poses && is_single_frame(totals)) {
    return text + fmt::format("{} in frame {}{} as close as the thickness and the tolerance.",
                              counted(totals.collisions.sum(), "pair"), totals.first_frame, subject);
  }
  std::string when = step_name(*totals.earliest, settings);
  if (!settings.poses) when += fmt::format(", {:.4g} of the way", totals.earliest_toi);
  return text + fmt::format("{} in {} of {}{}, the first in {}.", settings.poses ? "Crossings" : "Collisions",
                            grouped(totals.steps_with_collisions),
                            counted(totals.steps, settings.poses ? "frame" : "step"), subject, when);
}

std::string statistical_sentence(const CheckTotals& totals, const std::string& subject) {
  return fmt::format("{}STATISTICAL: the mode paper found {} of {}{}. Omit --mode for the proven answer.",
                     starts_crossing(totals) ? capital(start_of(totals)) + ". " : "",
                     grouped(totals.collisions.sum()),
                     counted(totals.collisions.sum() + totals.missed, "colliding pair"), subject);
}

/// "shin_l and shin_r go through each other", "cloth comes within 2 mm of itself".
std::string who_does_what(const Contact& worst, Motions motions, const CheckSettings& settings,
                          bool may_cross) {
  const auto [a, b] = side_names(worst, motions, settings);
  const bool is_one = worst.within() && a == b;
  std::string text = is_one ? a : a == b ? a + " and another " + b : a + " and " + b;
  if (goes_through(worst)) {
    text += is_one ? " goes through" : " go through";
  } else if (settings.step.thickness > 0 && !settings.poses) {
    text += fmt::format(" come{} within {} of", is_one ? "s" : "",
                        length_text(settings.step.thickness, unit_of(motions, settings)));
  } else if (worst.frames.empty() && !settings.poses) {
    text += is_one ? " meets" : " meet";  // and may have passed through
  } else {
    text += is_one ? " touches" : " touch";
  }
  return text + (is_one ? " itself" : " each other") + (may_cross ? " and may cross" : "");
}

/// "6.6 cm at worst"; empty for what only touches or pierces.
std::string how_bad(const Contact& worst, const std::string& unit, bool several) {
  if (worst.touching() || worst.pierces) return "";
  const ContactFrame& frame = worst.frames[worst.worst];
  const bool says_deep = frame.depth && (!several || unit.empty());
  return depth_text(frame, unit) + (says_deep ? " deep" : "") + (several ? " at worst" : "");
}

/// In which frame, or between which two; poses have the names of their files.
void add_time(Sentence& out, double time, std::span<const std::string> names) {
  const double before = std::floor(time), after = std::ceil(time);
  const bool has_names = after < static_cast<double>(names.size());
  const auto add = [&](double frame) {
    if (has_names) {
      out << names[static_cast<std::size_t>(frame)];
    } else {
      out.frame(frame);
    }
  };
  out << (before == after ? "in " : "between ") << (has_names ? "pose" : "frame")
      << (before == after ? " " : "s ");
  add(before);
  if (before == after) return;
  out << " and ";
  add(after);
}

/// What of the contacts is not known, besides what was left out.
std::string unknown_of(const CheckSettings& settings, const CheckTotals& totals) {
  if (settings.steps_only && !settings.poses)
    return fmt::format("; crossings from frame {} on were not tested (--steps-only)", totals.first_frame);
  if (totals.contact_unknown_frames == 0) return "";
  return fmt::format("; which triangles cross is not known in {} (--limit)",
                     counted(totals.contact_unknown_frames, "frame"));
}

CheckVerdictKind kind_of(const CheckSettings& settings, const CheckTotals& totals) {
  if (!totals.clean()) return CheckVerdictKind::Found;
  const bool proven = !settings.paper_miss_rate && (settings.poses || totals.starts_crossing);
  return proven ? CheckVerdictKind::Free : CheckVerdictKind::Limited;
}

}  // namespace

Sentence& Sentence::operator<<(std::string_view text) {
  if (pieces_.empty() || std::holds_alternative<double>(pieces_.back())) pieces_.emplace_back(std::string());
  std::get<std::string>(pieces_.back()) += text;
  return *this;
}

Sentence& Sentence::frame(double time) {
  pieces_.emplace_back(time);
  return *this;
}

std::string Sentence::text() const {
  std::string text;
  for (const auto& piece : pieces_) {
    const double* time = std::get_if<double>(&piece);
    text += time ? fmt::format("{:.6g}", *time) : std::get<std::string>(piece);
  }
  return text;
}

std::string step_name(const StepIndex& index, const CheckSettings& settings) {
  if (index.frame == index.next_frame) return fmt::format("frame {}", index.frame);
  std::string name = fmt::format("frames {} to {}", index.frame, index.next_frame);
  if (settings.substeps > 1) name += fmt::format(", part {} of {}", index.substep + 1, settings.substeps);
  return name;
}

std::string start_of(const CheckTotals& totals) {
  return fmt::format("frame {} starts with {} of triangles", totals.first_frame,
                     counted(*totals.starts_crossing, "crossing pair"));
}

std::string short_name(Index object, Motions motions) {
  namespace fs = std::filesystem;
  const auto is_alone = [&](const auto& name_of) {
    const auto name = name_of(*motions[object]);
    return !name.empty() &&
           std::ranges::count_if(motions, [&](const auto& motion) { return name_of(*motion) == name; }) == 1;
  };
  const auto stem = [](const Motion& m) { return fs::path(m.name()).stem().string(); };
  const auto file = [](const Motion& m) { return fs::path(m.name()).filename().string(); };
  if (is_alone(stem)) return stem(*motions[object]);
  return is_alone(file) ? file(*motions[object]) : motions[object]->name();
}

std::string with_untested(std::string sentence, std::span<const std::string> untested) {
  if (untested.empty()) return sentence;
  sentence.pop_back();  // the full stop
  for (const std::string& part : untested) sentence += "; " + part;
  return sentence + ".";
}

Sentence contact_sentence(Motions motions, const CheckSettings& settings, const CheckTotals& totals) {
  const auto groups = group_contacts(totals.contacts);
  const ContactGroup& group = groups.front();
  const Contact& worst = totals.contacts[group.contacts.front()];
  const std::size_t about = group.crossing > 0 ? group.crossing : group.contacts.size();
  Sentence out;
  out << who_does_what(worst, motions, settings, worst.frames.empty() && totals.contact_unknown_frames > 0);
  const std::string often = how_often(group);
  if (!often.empty()) out << " " + often;
  const bool several = about > 1 || worst.frames.size() > 1;
  const std::string bad = how_bad(worst, unit_of(motions, settings), several);
  if (!bad.empty()) out << ", " + bad;
  out << (often.empty() && bad.empty() ? " " : ", ");
  add_time(out, worst.frames.empty() ? worst.first_time : worst.frames[worst.worst].time,
           motions[0]->info().frame_names);
  out << assumed(motions, settings.poses || is_single_frame(totals), "of");
  if (const std::size_t more = totals.contacts.size() - about; more > 0)
    out << fmt::format("; {} more contact{}", grouped(more), more == 1 ? "" : "s");
  return out << unknown_of(settings, totals);
}

CheckVerdict verdict(Motions motions, const CheckSettings& settings, const CheckTotals& totals) {
  // One frame is none of several.
  const std::string subject = assumed(motions, settings.poses || is_single_frame(totals));
  CheckVerdict out{.kind = kind_of(settings, totals), .sentence = {}, .numbers = {}};
  const auto not_tested = untested(motions, settings, totals);
  out.whole = not_tested.empty();
  if (settings.paper_miss_rate) {
    out.sentence << statistical_sentence(totals, subject);
    out.whole = false;
    return out;
  }
  if (totals.clean()) {
    out.sentence = clean_sentence(settings, totals, subject);
    out.sentence << with_untested(".", not_tested);
  } else if (totals.contacts.empty()) {
    out.sentence << with_untested(found_sentence(settings, totals, subject), not_tested);
  } else {
    out.sentence = contact_sentence(motions, settings, totals);
    out.sentence << with_untested(".", not_tested);
    out.numbers = found_sentence(settings, totals, subject);
  }
  if (const std::string still = still_pairs(motions, settings, totals); !still.empty())
    out.sentence << " " + still + " (--still-pairs counts them).";
  return out;
}

}  // namespace foldproof
