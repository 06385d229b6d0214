#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "base/try.h"
#include "commands.h"
#include "contact_lines.h"
#include "interruptible_motion.h"
#include "page/repaired_report.h"
#include "page_files.h"
#include "progress_bar.h"
#include "report/repair_files.h"
#include "report/repair_report.h"
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
  foldproof repair walk.glb -o fixed.glb
  foldproof repair body.npz shirt.npz --fixed body.npz -o shirt-fixed.npz     only the shirt moves
  foldproof repair pose.obj -o fixed.obj
  foldproof repair walk.glb --thickness 0.002 --falloff 0.05 -o apart.npz --report apart.html)";

struct RepairArguments : StepArguments {
  std::vector<std::string> outputs, fixed, fixed_vertices, only, start;
  std::vector<std::pair<std::string, std::string>> contacts;
  std::string json, page, command, unit;
  double falloff = 0;
  Index in_betweens = 0;
  bool quick = false, keep = false, quiet = false, all_contacts = false;
};

Result<void> nothing_may_move(const RepairArguments& a) {
  const std::string fixed =
      a.fixed.empty() ? "--fixed-vertices" : fmt::format("--fixed {}", fmt::join(a.fixed, " --fixed "));
  if (a.only.empty())
    return fail(ErrorCode::InvalidArgument, fixed, "leaves nothing that may move", "leave one of these out");
  return fail(ErrorCode::InvalidArgument, fixed, "fixes all that --only lets move",
              "leave out one or the other");
}

Result<void> require_one_each(const char* option, const std::vector<std::string>& given, Motions motions) {
  if (given.empty() || given.size() == motions.size()) return {};
  return fail(
      ErrorCode::InvalidArgument, option,
      fmt::format("is given {} for {}", how_often_given(given.size()), counted(motions.size(), "object")),
      "give it once for each object, in order");
}

// Per object.
Result<std::vector<std::vector<Index>>> read_fixed_vertices(const RepairArguments& a, Motions motions) {
  std::vector<std::vector<Index>> fixed;
  FOLDPROOF_TRY(require_one_each("--fixed-vertices", a.fixed_vertices, motions));
  for (std::size_t i = 0; i < a.fixed_vertices.size(); ++i) {
    const NumberTable table = FOLDPROOF_TRY(read_csv(a.fixed_vertices[i]));
    const Index vertices = motions[i]->topology().vertex_count();
    if (table.values.size() != vertices)
      return fail(
          ErrorCode::InvalidFile, a.fixed_vertices[i],
          fmt::format("has {} for {} vertices", counted(table.values.size(), "number"), grouped(vertices)),
          "give a number for each vertex, not 0 if it may not move");
    auto& of_object = fixed.emplace_back();
    for (Index v = 0; v < vertices; ++v) {
      if (table.values[v] != 0) of_object.push_back(v);
    }
  }
  return fixed;
}

Result<std::vector<double>> read_start(const RepairArguments& a, Motions motions) {
  std::vector<double> start;
  FOLDPROOF_TRY(require_one_each("--start", a.start, motions));
  if (a.start.empty()) return start;
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
  if (const auto late = frames_named(report.frames, [](const auto& f) { return f.late; }).text();
      !late.empty())
    text += row("behind the motion", "in " + late);
  if (report.open_loop) text += row("loop", "the motion ends as it begins, what was written does not");
  return text;
}

std::string summary_of(const RepairArguments& a, Motions motions, const RepairRequest& request,
                       const RepairReport& report) {
  const CheckSettings& settings = request.check;
  std::string text = rows_of(report, unit_of(motions, settings), settings.step.thickness);
  if (report.interrupted) {
    text += fmt::format("\nInterrupted: {} of the input were finished, and are written.\n",
                        frames_named(report.frames, [](const auto&) { return true; }).text());
  }
  text += "\n" +
          colored(printable(repair_verdict(motions, request, report).sentence.text()),
                  report.free ? Tone::Good : Tone::Bad) +
          "\n";
  if (no_way(request, report)) {
    text += "Let it move, too, or add frames (--in-betweens N).\n";
  } else if (!report.free && report.left.empty() && a.start.empty() && a.models.empty()) {
    text += "A pose that touches nothing may help (--start FILE or --model FILE).\n";
  }
  const auto listed = [&](const std::vector<Contact>& contacts) {
    return contact_lines(motions, settings, contact_totals(contacts, report),
                         a.all_contacts ? std::numeric_limits<std::size_t>::max() : kFewContacts);
  };
  text += listed(report.remaining);
  if (!report.left.empty()) text += "\nWhat was left:\n" + listed(report.left);
  if (!report.among_fixed.empty())
    text += "\nWhat may not move touches itself, and was left so:\n" + listed(report.among_fixed);
  return text;
}

// The library names its settings.
Error by_options(Error error, const RepairArguments& a) {
  if (error.where == "thickness") error.where = "--thickness";
  if (error.where == "start") error.where = fmt::format("--start {}", fmt::join(a.start, " --start "));
  return error;
}

Result<int> run_repair(const RepairArguments& a) {
  auto settings = FOLDPROOF_TRY(step_settings(a));
  settings.unit = a.unit;
  FOLDPROOF_TRY(require_number("--falloff", a.falloff, true));
  FOLDPROOF_TRY(a.files.check());
  std::vector<PageFile> files;
  if (!a.page.empty()) files = FOLDPROOF_TRY(require_page_files());
  std::optional<ThreadLimit> limit;
  FOLDPROOF_TRY(limit_threads(a.threads, limit));
  const auto motions = FOLDPROOF_TRY(read_motions(a.motions, a.motion.read, a.quiet));
  settings.models = FOLDPROOF_TRY(load_models(a.models, motions));
  RepairRequest request{settings, {}, a.fixed, a.only};
  for (const auto& [one, other] : a.contacts) request.between.push_back({one, other});
  request.repair.falloff = a.falloff;
  request.repair.calm = !a.quick;
  request.repair.keep = a.keep;
  request.repair.in_betweens = a.in_betweens;
  request.repair.start = FOLDPROOF_TRY(read_start(a, motions));
  request.fixed_vertices = FOLDPROOF_TRY(read_fixed_vertices(a, motions));
  const auto movable = FOLDPROOF_TRY(movable_objects(motions, request));
  const auto frames = FOLDPROOF_TRY(frames_to_check(motions, settings));
  if (movable.empty()) FOLDPROOF_TRY(nothing_may_move(a));
  const RepairOutputs outputs{a.outputs, a.motion.read, a.in_betweens};
  FOLDPROOF_TRY(require_outputs_fit(outputs, motions, movable, frames.size()));
  request.repair.single_precision = std::ranges::any_of(
      a.outputs, [&](const std::string& path) { return is_single_precision(path, frames.size()); });
  const std::atomic<bool>& interrupted = watch_for_interrupt();
  ProgressBar bar(!a.quiet);
  request.repair.interrupted = [&] { return interrupted.load(); };
  request.repair.progress = [&](double share) { bar.show(share, "repairing"); };
  const auto done = repair_motions(motions, request);
  bar.clear();
  if (!done) return tl::unexpected(by_options(done.error(), a));
  if (done->report.written) FOLDPROOF_TRY(write_outputs(outputs, motions, request, *done));
  if (!a.json.empty()) FOLDPROOF_TRY(write_repair_json(a.json, motions, request, done->report));
  if (!a.page.empty())
    FOLDPROOF_TRY(write_repaired_report(a.page, motions, request, *done, a.command, files));
  if (!a.quiet) print_output(summary_of(a, motions, request, done->report));
  if (done->report.interrupted) return kExitInterrupted;
  return exit_code(done->report.free);
}

void add_output_options(const Subcommand& command, RepairArguments& a) {
  a.files
      .writes(
          command.add_option(
              "-o,--output", a.outputs,
              "The motion to write: .npz; .glb for what was glTF, as it was but for what moves; .obj with "
              ".pc2, or .mdd with --in-betweens; .ply for one frame; once for each object that may move, "
              "in order"),
          FileArguments::Output::Motion, {".glb"})
      .type_name("FILE")
      .one_value_each_time()
      .required();
  a.files
      .writes(command.add_option("--json", a.json,
                                 "What was done, frame by frame, and all contacts; - is standard output"),
              FileArguments::Output::Text)
      .type_name("FILE");
  a.files
      .writes(command.add_option("--report", a.page,
                                 "A page with pictures of contacts before and after, how far each frame was "
                                 "moved, and what remains"),
              FileArguments::Output::File, {".html", ".htm"})
      .type_name("FILE");
  command.add_flag("--keep", a.keep, "After Ctrl-C, write the frames that are finished");
  command.add_flag("--contacts", a.all_contacts,
                   fmt::format("List all contacts in the summary, not only the {} worst", kFewContacts));
  command.add_option("--unit", a.unit, "What a mesh unit is, such as cm: named beside lengths [m for glTF]")
      .type_name("NAME");
  command.add_flag("-q,--quiet", a.quiet, "Print nothing but errors");
}

constexpr const char* kHow = "What may move, and how";

void add_choice_options(const Subcommand& command, RepairArguments& a) {
  command
      .add_option("--fixed", a.fixed,
                  "An object or part that may not move, by name; several times for several")
      .type_name("NAME")
      .one_value_each_time()
      .group(kHow);
  a.files
      .reads(command.add_option(
          "--fixed-vertices", a.fixed_vertices,
          "Vertices that may not move: a text file with a number for each vertex, not 0 for "
          "these; once for each object"))
      .type_name("FILE")
      .one_value_each_time()
      .group(kHow);
  command.add_option("--only", a.only, "An object or part that may move; then no other may")
      .type_name("NAME")
      .one_value_each_time()
      .group(kHow);
  command
      .add_option("--contact", a.contacts,
                  "Repair only contacts of these two objects or parts, by name, and leave all others")
      .type_name("A B")
      .one_value_each_time()
      .group(kHow);
  command.add_option("--ignore", a.ignore, "Pairs of two objects or parts that may touch, by name")
      .type_name("A B")
      .one_value_each_time()
      .group(kHow);
}

void add_correction_options(const Subcommand& command, RepairArguments& a) {
  command
      .add_option("--falloff", a.falloff,
                  "How far along the surface a correction spreads, in mesh units [a twentieth of the size]")
      .type_name("D")
      .group(kHow);
  command.add_option("--thickness", a.thickness, "Keep everything farther apart than this, in mesh units [0]")
      .type_name("D")
      .group(kHow);
  a.files
      .reads(command.add_option(
          "--start", a.start, "A pose that touches nothing to start from, a mesh file; once for each object"))
      .type_name("FILE")
      .one_value_each_time()
      .group(kHow);
  a.files
      .reads(command.add_option("--model", a.models,
                                "A model from 'foldproof train': where no frame is free, start in one of its "
                                "poses; one for all objects of its mesh, or one for each object, in order"))
      .type_name("FILE")
      .one_value_each_time()
      .group(kHow);
  command
      .add_option("--in-betweens", a.in_betweens,
                  "Add up to N frames between two where a correction cannot keep up; NPZ has their 'times', "
                  "in frames, MDD in seconds [0]")
      .type_name("N")
      .group(kHow);
  command.add_flag("--quick", a.quick, "Leave out the pass that makes corrections calm in time").group(kHow);
}

}  // namespace

Command add_repair(CommandLine& program, std::span<char* const> arguments) {
  const Subcommand command =
      program.add_subcommand("repair", "Write the nearest motion that touches nothing, proven");
  command.footer(std::string(kMotionHelp) + kRepairFooter);
  const auto a = std::make_shared<RepairArguments>();
  a->command = command_line(arguments);
  a->files.reads(command.add_option("MOTION", a->motions, "What to repair (see below)"))
      .type_name("")
      .required();
  add_output_options(command, *a);
  add_choice_options(command, *a);
  add_correction_options(command, *a);
  add_motion_options(command, a->motion);
  add_threads_option(command, a->threads, "At most N threads [all cores]");
  return [a] { return run_repair(*a); };
}

}  // namespace foldproof
