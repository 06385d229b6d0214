#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "base/try.h"
#include "commands.h"
#include "contact_lines.h"
#include "interruptible_motion.h"
#include "io/write_times.h"
#include "progress_bar.h"
#include "report/repair_motions.h"
#include "report/verdict.h"
#include "run_and_summarize.h"
#include "step_options.h"
#include "terminal.h"

namespace foldproof {
namespace {

constexpr const char* kRepairFooter = R"(
It writes the nearest motion that touches nothing, at any time while vertices move straight from frame to frame: each
step is checked as 'foldproof check' does before it is written. What cannot be repaired is listed; then, as when nothing
is written because no frame is free and none can be made so, the exit code is 1. docs/repair.md says more.

Examples:
  foldproof repair walk.glb -o fixed.npz
  foldproof repair body.npz shirt.npz --fixed body.npz -o shirt-fixed.npz     only the shirt moves
  foldproof repair pose.obj -o fixed.obj
  foldproof repair walk.glb --thickness 0.002 --falloff 0.05 -o apart.npz)";

struct RepairArguments : StepArguments {
  std::vector<std::string> outputs, fixed, only, start;
  double falloff = 0;
  Index in_betweens = 0;
  bool quick = false, keep = false, quiet = false, all_contacts = false;
};

// A file per frame.
bool is_pattern(const std::string& path) { return path.find('%') != std::string::npos; }

bool has_point_cache(const std::string& path, std::size_t frames) {
  return extension_of(path) == ".obj" && frames > 1 && !is_pattern(path);
}

std::string times(std::size_t count) { return count == 1 ? "once" : fmt::format("{} times", count); }

Result<void> nothing_may_move(const RepairArguments& a) {
  const std::string fixed = fmt::format("--fixed {}", fmt::join(a.fixed, " --fixed "));
  if (a.only.empty())
    return fail(ErrorCode::InvalidArgument, fixed, "leaves nothing that may move", "leave one of these out");
  return fail(ErrorCode::InvalidArgument, fixed, "fixes all that --only lets move",
              "leave out one or the other");
}

// An output of a motion with added frames needs their times; other outputs are refused before work starts.
Result<void> require_outputs_fit(const RepairArguments& a, Motions motions, std::span<const Index> movable,
                                 std::size_t frames) {
  if (movable.empty()) return nothing_may_move(a);
  if (a.outputs.size() != movable.size()) {
    return fail(ErrorCode::InvalidArgument, "-o",
                fmt::format("is given {}, but {} may move", times(a.outputs.size()),
                            counted(movable.size(), "object")),
                "give it once for each of these, in order");
  }
  for (std::size_t i = 0; i < movable.size(); ++i) {
    const Topology& topology = motions[movable[i]]->topology();
    if (extension_of(a.outputs[i]) == ".npz" && topology.face_count() < topology.triangles().size())
      return fail(ErrorCode::UnsupportedFormat, a.outputs[i],
                  "is NPZ, which holds faces alone, and there are lines or points", "name it .obj");
    if (a.in_betweens > 0 && extension_of(a.outputs[i]) != ".npz" && !has_point_cache(a.outputs[i], frames))
      return fail(ErrorCode::UnsupportedFormat, a.outputs[i],
                  "holds no times, which frames that --in-betweens adds need",
                  frames == 1                ? "leave out --in-betweens: there is one frame"
                  : is_pattern(a.outputs[i]) ? "name it .npz, or .obj without %, which gets an MDD"
                                             : "name it .npz, or .obj, which gets an MDD");
    if (extension_of(a.outputs[i]) == ".ply" && frames > 1 && !is_pattern(a.outputs[i]))
      return fail(ErrorCode::UnsupportedFormat, a.outputs[i], "is PLY, which holds one frame",
                  "name it .npz or .obj, or put %04d into the name for a file per frame");
  }
  return {};
}

Result<std::vector<double>> read_start(const RepairArguments& a, Motions motions) {
  std::vector<double> start;
  if (a.start.empty()) return start;
  if (a.start.size() != motions.size())
    return fail(ErrorCode::InvalidArgument, "--start",
                fmt::format("is given {} for {}", times(a.start.size()), counted(motions.size(), "object")),
                "give it once for each object, in order");
  for (std::size_t i = 0; i < motions.size(); ++i) {
    const auto poses = FOLDPROOF_TRY(read_motions({&a.start[i], 1}, a.motion.read, a.quiet));
    if (poses.size() != 1 || poses[0]->topology() != motions[i]->topology())
      return fail(ErrorCode::InvalidMesh, a.start[i], "has other triangles than " + motions[i]->name(),
                  "give a pose of the same mesh");
    std::vector<double> x(3 * std::size_t{poses[0]->topology().vertex_count()});
    FOLDPROOF_TRY(poses[0]->read_frame(0, x));
    start.insert(start.end(), x.begin(), x.end());
  }
  return start;
}

// "frame 3", "frames 3, 5-9 and 7 more".
std::string frames_named(const std::vector<RepairedFrame>& frames,
                         const std::function<bool(const RepairedFrame&)>& is_meant) {
  constexpr int kMostRuns = 8;
  std::string text;
  std::size_t count = 0, named = 0;
  int runs = 0;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (!is_meant(frames[i])) continue;
    const std::size_t first = i;
    while (i + 1 < frames.size() && is_meant(frames[i + 1])) ++i;
    count += i + 1 - first;
    if (++runs > kMostRuns) continue;
    named = count;
    text += fmt::format("{}{:.6g}", runs == 1 ? "" : ", ", frames[first].time);
    if (i > first) text += fmt::format("-{:.6g}", frames[i].time);
  }
  if (count == 0) return "";
  if (count > named) text += fmt::format(" and {} more", count - named);
  return (count == 1 ? "frame " : "frames ") + text;
}

// What was done, in rows.
std::string rows_of(const RepairReport& report, const std::string& unit, double thickness) {
  const std::string space = unit.empty() ? "" : " " + unit;
  const auto worst = std::ranges::max_element(report.frames, {}, &RepairedFrame::correction);
  const auto moved = std::ranges::count_if(report.frames, [](const auto& f) { return f.correction > 0; });
  std::string text = row("contacts before", grouped(report.before.size()));
  if (report.written && !report.unchanged) {
    text += row("frames moved", fmt::format("{} of {}", grouped(static_cast<std::uint64_t>(moved)),
                                            grouped(report.frames.size())));
    const auto added = std::ranges::count_if(
        report.frames, [](const auto& f) { return f.time != static_cast<Index>(f.time); });
    if (added > 0) text += row("frames added", grouped(static_cast<std::uint64_t>(added)));
    text += row("largest correction",
                fmt::format("{:.3g}{} in frame {:.6g}", worst->correction, space, worst->time));
    text += row("kept apart by", fmt::format("{:.3g}{}", report.clearance + thickness, space));
  }
  if (const auto late = frames_named(report.frames, [](const auto& f) { return f.late; }); !late.empty())
    text += row("behind the motion", "in " + late);
  if (report.open_loop) text += row("loop", "the motion ends as it begins, what was written does not");
  return text;
}

std::string touching_frames(const RepairReport& report) {
  return frames_named(report.frames, [](const RepairedFrame& f) { return f.limit != RepairLimit::None; });
}

std::string sentence_of(const RepairReport& report, bool has_start) {
  const char* but = report.among_fixed.empty() ? "" : ", but what may not move, with itself";
  if (report.unchanged) return fmt::format("The motion is as it was: nothing touches{}.", but);
  if (report.free) {
    return fmt::format("Proven: nothing touches, in no frame and at no time between frames{}.", but);
  }
  const bool any_free =
      std::ranges::any_of(report.frames, [](const RepairedFrame& f) { return f.limit == RepairLimit::None; });
  std::string text = "No frame is free and none could be made so: nothing was written";
  if (report.written || any_free)
    text = fmt::format(
        "{}: something touches in {}",
        report.written ? "Not all could be repaired" : "Nothing could be repaired, and nothing was written",
        touching_frames(report));
  return text + (has_start ? "." : "; a pose that touches nothing may help (--start FILE or --model FILE).");
}

std::string summary_of(const RepairArguments& a, Motions motions, const RepairReport& report,
                       CheckSettings& settings) {
  CheckTotals totals;
  totals.contacts_found = true;
  totals.first_frame = static_cast<Index>(report.frames.front().time);
  totals.last_frame = static_cast<Index>(report.frames.back().time);
  std::string text = rows_of(report, unit_of(motions, settings), settings.step.thickness);
  if (report.interrupted) {
    text += fmt::format("\nInterrupted: {} of the input were finished, and are written.\n",
                        frames_named(report.frames, [](const auto&) { return true; }));
  }
  auto not_tested = untested(motions, settings, totals);
  if (settings.step.thickness > 0 && (!a.fixed.empty() || !a.only.empty()))
    not_tested.emplace_back("what may not move was not tested with itself for the thickness");
  text += "\n" +
          colored(printable(with_untested(sentence_of(report, !a.start.empty()), not_tested)),
                  report.free ? Tone::Good : Tone::Bad) +
          "\n";
  const auto listed = [&](std::vector<Contact> contacts) {
    std::ranges::sort(contacts, is_worse);
    totals.contacts = std::move(contacts);
    return contact_lines(motions, settings, totals,
                         a.all_contacts ? std::numeric_limits<std::size_t>::max() : kFewContacts);
  };
  text += listed(report.remaining);
  if (!report.among_fixed.empty())
    text += "\nWhat may not move touches itself, and was left so:\n" + listed(report.among_fixed);
  return text;
}

Result<void> write_outputs(const RepairArguments& a, const RepairedMotions& done) {
  std::vector<double> times;
  for (const RepairedFrame& frame : done.report.frames) times.push_back(frame.time);
  for (std::size_t i = 0; i < done.movable.size(); ++i) {
    const auto motion = done.motion(done.movable[i]);
    const std::string& path = a.outputs[i];
    if (a.in_betweens == 0) {
      FOLDPROOF_TRY(write_motion(path, *motion));
    } else if (extension_of(path) == ".npz") {
      FOLDPROOF_TRY(io::write_npz(path, *motion, times));
    } else {
      std::vector<double> seconds;
      seconds.reserve(times.size());
      for (const double time : times) seconds.push_back(time / a.motion.read.fps);
      const auto cache = std::filesystem::path(path).replace_extension(".mdd");
      FOLDPROOF_TRY(io::write_obj_mdd(path, cache.string(), *motion, seconds));
    }
  }
  return {};
}

// The library names its settings.
Error by_options(Error error, const RepairArguments& a) {
  if (error.where == "thickness") error.where = "--thickness";
  if (error.where == "start") error.where = fmt::format("--start {}", fmt::join(a.start, " --start "));
  return error;
}

Result<int> run_repair(const RepairArguments& a) {
  auto settings = FOLDPROOF_TRY(step_settings(a));
  FOLDPROOF_TRY(require_number("--falloff", a.falloff, true));
  FOLDPROOF_TRY(a.files.check());
  std::optional<ThreadLimit> limit;
  FOLDPROOF_TRY(limit_threads(a.threads, limit));
  const auto motions = FOLDPROOF_TRY(read_motions(a.motions, a.motion.read, a.quiet));
  settings.models = FOLDPROOF_TRY(load_models(a.models, motions));
  RepairRequest request{settings, {}, a.fixed, a.only};
  request.repair.falloff = a.falloff;
  request.repair.calm = !a.quick;
  request.repair.keep = a.keep;
  request.repair.in_betweens = a.in_betweens;
  request.repair.start = FOLDPROOF_TRY(read_start(a, motions));
  const auto movable = FOLDPROOF_TRY(movable_objects(motions, request));
  const auto frames = FOLDPROOF_TRY(frames_to_check(motions, settings));
  FOLDPROOF_TRY(require_outputs_fit(a, motions, movable, frames.size()));
  request.repair.single_precision = std::ranges::any_of(
      a.outputs, [&](const std::string& path) { return has_point_cache(path, frames.size()); });
  const std::atomic<bool>& interrupted = watch_for_interrupt();
  ProgressBar bar(!a.quiet);
  request.repair.interrupted = [&] { return interrupted.load(); };
  request.repair.progress = [&](double share) { bar.show(share, "repairing"); };
  const auto done = repair_motions(motions, request);
  bar.clear();
  if (!done) return tl::unexpected(by_options(done.error(), a));
  if (done->report.written) FOLDPROOF_TRY(write_outputs(a, *done));
  if (!a.quiet) print_output(summary_of(a, motions, done->report, settings));
  if (done->report.interrupted) return kExitInterrupted;
  return exit_code(done->report.free);
}

void add_output_options(const Subcommand& command, RepairArguments& a) {
  a.files
      .writes(command.add_option(
                  "-o,--output", a.outputs,
                  "The motion to write: .npz, .obj with .pc2, or .mdd with --in-betweens, .ply for "
                  "one frame; once for each object that may move, in order"),
              FileArguments::Output::Motion)
      .type_name("FILE")
      .one_value_each_time()
      .required();
  command.add_flag("--keep", a.keep, "After Ctrl-C, write the frames that are finished");
  command.add_flag("--contacts", a.all_contacts,
                   fmt::format("List all contacts in the summary, not only the {} worst", kFewContacts));
  command.add_flag("-q,--quiet", a.quiet, "Print nothing but errors");
}

}  // namespace

Command add_repair(CommandLine& program) {
  const Subcommand command =
      program.add_subcommand("repair", "Write the nearest motion that touches nothing, proven");
  command.footer(std::string(kMotionHelp) + kRepairFooter);
  const auto a = std::make_shared<RepairArguments>();
  a->files.reads(command.add_option("MOTION", a->motions, "What to repair (see below)"))
      .type_name("")
      .required();
  add_output_options(command, *a);
  const char* group = "What may move, and how";
  command
      .add_option("--fixed", a->fixed,
                  "An object or part that may not move, by name; several times for several")
      .type_name("NAME")
      .one_value_each_time()
      .group(group);
  command.add_option("--only", a->only, "An object or part that may move; then no other may")
      .type_name("NAME")
      .one_value_each_time()
      .group(group);
  command
      .add_option("--falloff", a->falloff,
                  "How far along the surface a correction spreads, in mesh units [a twentieth of the size]")
      .type_name("D")
      .group(group);
  command
      .add_option("--thickness", a->thickness, "Keep everything farther apart than this, in mesh units [0]")
      .type_name("D")
      .group(group);
  command.add_option("--ignore", a->ignore, "Pairs of two objects or parts that may touch, by name")
      .type_name("A B")
      .one_value_each_time()
      .group(group);
  a->files
      .reads(
          command.add_option("--start", a->start,
                             "A pose that touches nothing to start from, a mesh file; once for each object"))
      .type_name("FILE")
      .one_value_each_time()
      .group(group);
  a->files
      .reads(command.add_option("--model", a->models,
                                "A model from 'foldproof train': where no frame is free, start in one of its "
                                "poses; one for all objects of its mesh, or one for each object, in order"))
      .type_name("FILE")
      .one_value_each_time()
      .group(group);
  command
      .add_option("--in-betweens", a->in_betweens,
                  "Add up to N frames between two where a correction cannot keep up; NPZ has their 'times', "
                  "in frames, MDD in seconds [0]")
      .type_name("N")
      .group(group);
  command.add_flag("--quick", a->quick, "Leave out the pass that makes corrections calm in time")
      .group(group);
  add_motion_options(command, a->motion);
  add_threads_option(command, a->threads, "At most N threads [all cores]");
  return [a] { return run_repair(*a); };
}

}  // namespace foldproof
