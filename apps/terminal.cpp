#include "terminal.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <iterator>
#include <numeric>
#include <string_view>
#include <system_error>

#include "base/duration.h"
#include "report/verdict.h"
#include "system/program.h"

namespace foldproof {

namespace {

/// Where print_output prints.
std::FILE* output = stdout;

/// The errno of the first failure of standard output; 0 if there was none.
int output_failure = 0;

std::string colored_for(std::FILE* stream, const std::string& text, Tone tone) {
  const char* unwanted = std::getenv("NO_COLOR");
  if ((unwanted != nullptr && *unwanted != '\0') || !system::has_colors(stream)) return text;
  constexpr std::array kCodes = {32, 31, 33};  // green, red, yellow
  return fmt::format("\x1b[1;{}m{}\x1b[0m", kCodes[static_cast<std::size_t>(tone)], text);
}

}  // namespace

void print_notice(const std::string& text) { std::fwrite(text.data(), 1, text.size(), stderr); }

void print_error(const Error& error) {
  print_notice(colored_for(stderr, "foldproof:", Tone::Bad) + " " + error.line() + "\n");
}

std::string colored(const std::string& text, Tone tone) { return colored_for(output, text, tone); }

void print_to_standard_error() { output = stderr; }

void print_output(const std::string& text) {
  if (output_failure == 0 && std::fwrite(text.data(), 1, text.size(), output) != text.size())
    output_failure = errno;
}

Result<void> flush_output() {
  if (output_failure == 0 && std::fflush(output) != 0) output_failure = errno;
  if (output_failure == 0 || system::is_closed_pipe(output_failure)) return {};
  return fail(ErrorCode::FileAccess, output == stdout ? "standard output" : "standard error",
              "cannot be written: " + std::generic_category().message(output_failure),
              "check where it goes and the free space");
}

std::string row(const char* label, const std::string& value) {
  return fmt::format("{:<24}{}\n", label, value);
}

std::string printable(std::string text) {
  for (char& c : text) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '?';
  }
  return text;
}

std::string cell(std::string name) {
  constexpr std::size_t kLongest = 48, kBegin = 15, kEnd = kLongest - kBegin - 3;
  const auto continues_character = [&](std::size_t at) {  // inside a UTF-8 sequence
    return (static_cast<unsigned char>(name[at]) & 0xc0) == 0x80;
  };
  name = printable(std::move(name));
  if (name.size() <= kLongest) return name;
  std::size_t begin = kBegin, end = name.size() - kEnd;
  while (begin > 0 && continues_character(begin)) --begin;
  while (end < name.size() && continues_character(end)) ++end;
  return name.substr(0, begin) + "..." + name.substr(end);
}

namespace {

using Text = std::back_insert_iterator<std::string>;

std::string objects_table(Motions motions) {
  const auto continues_character = [](char c) { return (static_cast<unsigned char>(c) & 0xc0) == 0x80; };
  std::size_t width = 6;
  for (const auto& motion : motions) {
    const std::string name = cell(motion->name());
    width = std::max<std::size_t>(width,
                                  name.size() - std::count_if(name.begin(), name.end(), continues_character));
  }
  std::string text =
      fmt::format("\n{:<{}}  {:>12}  {:>12}  {:>8}\n", "object", width, "vertices", "triangles", "frames");
  for (const auto& motion : motions) {
    fmt::format_to(Text(text), "{:<{}}  {:>12}  {:>12}  {:>8}\n", cell(motion->name()), width,
                   grouped(motion->topology().vertex_count()), grouped(motion->topology().face_count()),
                   grouped(motion->frame_count()));
  }
  for (const auto& motion : motions) {
    const Topology& t = motion->topology();
    std::string more = t.line_count() > 0 ? counted(t.line_count(), "line") : "";
    if (t.point_count() > 0) more += (more.empty() ? "" : " and ") + counted(t.point_count(), "point");
    if (!more.empty()) fmt::format_to(Text(text), "{}: {} in no face\n", cell(motion->name()), more);
  }
  return text;
}

// "97.8 % of leaf pairs; not: 1.2 % too curved, 0.6 % near other parts"
std::string certified_share(const ReasonCounts& leaf_pairs) {
  constexpr std::array<const char*, kReasonNames.size()> kWords{
      "certified",        "not built yet",   "moved too far from their charts", "overlapping", "too curved",
      "near other parts", "certificates off"};
  const auto all =
      static_cast<double>(std::accumulate(leaf_pairs.begin(), leaf_pairs.end(), std::uint64_t{0}));
  const auto percent = [&](std::uint64_t count) {
    const double share = 100 * static_cast<double>(count) / all;
    return share < 0.05 ? "< 0.1 %" : fmt::format("{:.1f} %", share);
  };
  std::vector<std::size_t> reasons;
  for (std::size_t i = 1; i < leaf_pairs.size(); ++i) {
    if (leaf_pairs[i] > 0) reasons.push_back(i);
  }
  std::sort(reasons.begin(), reasons.end(),
            [&](std::size_t a, std::size_t b) { return leaf_pairs[a] > leaf_pairs[b]; });
  if (all == 0) return "no leaf pairs";
  std::string text = (leaf_pairs[0] == 0 ? "0 %" : percent(leaf_pairs[0])) + " of leaf pairs";
  for (const std::size_t i : reasons)
    text += fmt::format("{}{} {}", i == reasons[0] ? "; not: " : ", ", percent(leaf_pairs[i]), kWords[i]);
  return text;
}

/// What crosses in the first frame.
std::string first_frame_rows(const CheckSettings& settings, const CheckTotals& totals) {
  std::string text;
  const auto add = [&](const char* label, const std::string& value) { text += row(label, value); };
  if (totals.still_crossing.value_or(0) > 0)
    add("cross standing still", grouped(*totals.still_crossing) + " pairs of triangles  (not counted)");
  if (totals.starts_crossing) {
    add("first frame", *totals.starts_crossing > 0
                           ? start_of(totals)
                           : fmt::format("no triangles cross in frame {}", totals.first_frame));
    if (totals.start_listed < *totals.starts_crossing) {
      add("  listed", fmt::format("{} of {}  (those with the smallest ids; more with --limit)",
                                  grouped(totals.start_listed), grouped(*totals.starts_crossing)));
    }
  } else if (!settings.poses) {
    add("first frame", "not tested for crossings (--steps-only)");
  }
  return text;
}

/// "(frames 0 to 8, every 2nd frame)"
std::string frames_checked(const CheckSettings& settings, const CheckTotals& totals) {
  return fmt::format("(frames {} to {}{})", totals.first_frame, totals.last_frame,
                     skips_frames(settings, totals) ? ", " + every_nth_frame(settings.frames.step) : "");
}

/// What took time besides the steps; without what nobody notices.
std::string other_times(const CheckSettings& settings, const CheckTotals& totals) {
  constexpr double kNoticed = 0.5;  // milliseconds
  const std::pair<const char*, double> parts[] = {
      {"proving balls", settings.ball_milliseconds},    {"building the hierarchy", totals.build_milliseconds},
      {"first frame", totals.start_milliseconds.total}, {"contacts", totals.contact_milliseconds},
      {"reading frames", totals.read_milliseconds},     {"writing reports", totals.write_milliseconds}};
  std::string text;
  for (const auto& [what, milliseconds] : parts) {
    if (milliseconds < kNoticed) continue;
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", what, duration(milliseconds));
  }
  return text;
}

/// What the mode paper missed, and what the proven answer costs.
std::string paper_rows(const CheckSettings& settings, const CheckTotals& totals) {
  const std::uint64_t all = totals.collisions.sum() + totals.missed;
  const double steps = static_cast<double>(std::max<std::uint64_t>(totals.steps, 1));
  return row("missed",
             fmt::format("{} of the {} in the proven answer ({:.3g} %)", grouped(totals.missed), grouped(all),
                         all ? 100.0 * static_cast<double>(totals.missed) / static_cast<double>(all) : 0.0)) +
         row("proven answer",
             fmt::format("{} per {}, {:.2f} times as long", duration(totals.proven_milliseconds / steps),
                         settings.poses ? "frame" : "step",
                         totals.proven_milliseconds / std::max(1e-9, totals.milliseconds.total)));
}

}  // namespace

std::string summary(Motions motions, const CheckSettings& settings, const CheckTotals& totals) {
  std::string text = objects_table(motions) + "\n";
  const auto add = [&](const char* label, const std::string& value) { text += row(label, value); };
  const CollisionCounts& found = totals.collisions;
  const double steps = static_cast<double>(std::max<std::uint64_t>(totals.steps, 1));
  if (settings.paper_miss_rate) {
    add("mode", fmt::format("paper: STATISTICAL, can miss collisions (miss rate {:g} % in training poses; "
                            "new motions miss more)",
                            100 * *settings.paper_miss_rate));
  }
  text += first_frame_rows(settings, totals);
  add(settings.poses ? "frames checked" : "steps checked",
      grouped(totals.steps) + "  " + frames_checked(settings, totals));
  add("  with collisions", grouped(totals.steps_with_collisions));
  const bool first_only = settings.step.earliest_only;
  add(first_only ? "earliest pairs" : "colliding pairs",
      settings.poses ? grouped(found.sum()) + "  (triangles that cross)"
                     : fmt::format("{}  (vertex-face {}, edge-edge {})", grouped(found.sum()),
                                   grouped(found.vertex_face), grouped(found.edge_edge)));
  if (!totals.lists_all()) {
    add("  listed", fmt::format("{} of {}  (those with the smallest ids; more with --limit)",
                                grouped(totals.listed.sum()), grouped(found.sum())));
  }
  if (settings.paper_miss_rate) text += paper_rows(settings, totals);
  if (totals.worst) {
    // Of the earliest pairs alone, their number says nothing.
    if (!first_only)
      add("worst", fmt::format("{}: {}", step_name(*totals.worst, settings),
                               counted(totals.worst_collisions.sum(), "pair")));
    std::string earliest = step_name(*totals.earliest, settings);
    if (totals.earliest->frame != totals.earliest->next_frame)
      earliest += fmt::format(", time of impact {:.6g}", totals.earliest_toi);
    add("earliest", earliest);
  }
  if (!settings.poses) {
    add("undecided pairs",
        grouped(totals.work.undecided) + (totals.work.undecided ? "  (counted as collisions)" : ""));
    add("tolerance", fmt::format("{:.3g} mesh units", totals.tolerance));
  }
  if (settings.step.explain) add("certified", certified_share(totals.leaf_pairs));
  add(settings.poses ? "time per frame" : "time per step",
      fmt::format("{}, the slowest {}", duration(totals.milliseconds.total / steps),
                  duration(totals.slowest_step)));
  if (const std::string other = other_times(settings, totals); !other.empty()) add("other time", other);
  const Tone tone = settings.paper_miss_rate ? Tone::Doubtful : totals.clean() ? Tone::Good : Tone::Bad;
  const CheckVerdict result = verdict(motions, settings, totals);
  text += "\n" + colored(printable(result.sentence.text()), tone) + "\n";
  return result.numbers.empty() ? text : text + printable(result.numbers) + "\n";
}

namespace {

void announce_listed(const CheckedStep& step) {
  if (step.listed().sum() < step.collisions.sum())
    print_output(fmt::format("  {} of {} pairs:\n", step.listed().sum(), step.collisions.sum()));
}

class PairListing : public ReportWriter {
 public:
  explicit PairListing(Motions motions) : motions_(motions) {}

  Result<void> start(const CheckedStep& pose) override {
    if (pose.collisions.sum() == 0) return {};
    print_output(fmt::format("frame {} at the start\n", pose.index.frame));
    announce_listed(pose);
    list(*pose.pose);
    return {};
  }

  Result<void> step(const CheckedStep& step) override {
    if (step.collisions.sum() == 0) return {};
    print_output(fmt::format("frame {} substep {}\n", step.index.frame, step.index.substep));
    announce_listed(step);
    if (step.pose) {
      list(*step.pose);
      return {};
    }
    for (const VertexFaceCollision& c : step.step->vertex_face) {
      print_output(fmt::format("  vertex {}{} meets {} at {:.6g}\n", c.vertex, of(c.vertex_object),
                               triangle(c.face_object, c.face), c.toi));
    }
    for (const EdgeEdgeCollision& c : step.step->edge_edge) {
      print_output(fmt::format("  edge {}-{}{} meets edge {}-{}{} at {:.6g}\n", c.a[0], c.a[1],
                               of(c.object_a), c.b[0], c.b[1], of(c.object_b), c.toi));
    }
    return {};
  }

  Result<void> finish(const CheckTotals&) override { return {}; }

 private:
  void list(const StaticResult& pose) const {
    for (const TriangleCrossing& c : pose.crossings) {
      print_output(fmt::format("  {} crosses {}\n", triangle(c.object_a, c.triangle_a),
                               triangle(c.object_b, c.triangle_b)));
    }
  }

  /// "face 7", "line 0 of object 1"; a point is its vertex.
  std::string triangle(Index object, Index id) const {
    const Topology& t = motions_[object]->topology();
    switch (t.element(id)) {
      case Element::Face:
        break;
      case Element::Line:
        return fmt::format("line {}{}", id - t.face_count(), of(object));
      case Element::Point:
        return fmt::format("point {}{}", t.triangles()[id][0], of(object));
    }
    return fmt::format("face {}{}", id, of(object));
  }

  /// Names the object only if there are several.
  std::string of(Index object) const {
    return motions_.size() < 2 ? "" : fmt::format(" of object {}", object);
  }

  Motions motions_;
};

}  // namespace

std::unique_ptr<ReportWriter> pair_listing(Motions motions) { return std::make_unique<PairListing>(motions); }

}  // namespace foldproof
