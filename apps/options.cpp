#include "options.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/try.h"
#include "io/progress.h"
#include "progress_bar.h"
#include "system/program.h"
#include "terminal.h"

namespace foldproof {
namespace {

std::atomic<bool> interrupted = false;
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler sets it");

extern "C" void interrupt(int) { interrupted = true; }

/// Quotes an argument for a shell.
std::string quoted(std::string_view argument) {
  constexpr std::string_view kPlain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_./:=,+@%";
  if (!argument.empty() && argument.find_first_not_of(kPlain) == argument.npos) return std::string(argument);
  return in_quotes(argument);
}

}  // namespace

std::string in_quotes(std::string_view text) {
  std::string quotes = "'";
  for (const char c : text) quotes += c == '\'' ? "'\\''" : std::string(1, c);
  return quotes + "'";
}

std::string command_line(std::span<char* const> arguments) {
  std::string line = "foldproof";
  for (const char* argument : arguments.subspan(std::min<std::size_t>(1, arguments.size())))
    line += " " + quoted(argument);
  return line;
}

const std::atomic<bool>& watch_for_interrupt() {
  system::on_interrupt(interrupt);
  return interrupted;
}

Option add_weld_options(const Subcommand& command, ReadOptions& options) {
  const Option never = command.add_flag(
      "--no-weld", [&] { options.weld = Weld::Never; }, "Keep the seams of glTF: merge no vertices");
  return command
      .add_flag(
          "--weld", [&] { options.weld = Weld::Always; },
          "Merge all vertices that coincide in the first frame; without it, the seams of glTF and STL")
      .excludes(never);
}

void add_motion_options(const Subcommand& command, MotionOptions& options) {
  command
      .add_option("--frames", options.frames,
                  "Every STEP-th frame from A to B, B excluded; negative ones count from the end")
      .type_name("A:B[:STEP]")
      .group(kMotionGroup);
  command.add_option("--fps", options.read.fps, "Sampling rate for animated glTF, frames per second [24]")
      .type_name("RATE")
      .group(kMotionGroup);
  const Option weld = add_weld_options(command, options.read);
  weld.group(kMotionGroup);
  command.option("--no-weld").group(kMotionGroup);
  const Option separate = command
                              .add_flag(
                                  "--separate", [&] { options.read.mesh_files = MeshFiles::Separate; },
                                  "Several mesh files are bodies, also if their names are those of frames")
                              .group(kMotionGroup);
  command
      .add_flag(
          "--sequence", [&] { options.read.mesh_files = MeshFiles::Sequence; },
          "Several mesh files are frames of one motion, also if they look like bodies")
      .group(kMotionGroup)
      .excludes(separate);
  command
      .add_option("--clip", options.read.clip,
                  "The animation of a glTF that is read, by its name, or as 'animations[1]' [the longest]")
      .type_name("NAME")
      .group(kMotionGroup);
  command.add_flag("--points", options.read.points, "Check vertices in no face and no line as points")
      .group(kMotionGroup);
}

Result<FrameRange> frame_range_of(const MotionOptions& options) {
  FOLDPROOF_TRY(require_number("--fps", options.read.fps, false));
  return options.frames.empty() ? FrameRange{} : parse_frame_range(options.frames);
}

void add_threads_option(const Subcommand& command, int& threads, const char* description) {
  command.add_option("--threads", threads, description).type_name("N");
}

Result<Model> load_learned_model(const std::string& path) {
  auto model = FOLDPROOF_TRY(load_model(path));
  FOLDPROOF_TRY(require_learned(model));
  return model;
}

Result<std::vector<std::unique_ptr<Motion>>> read_motions(std::span<const std::string> arguments,
                                                          const ReadOptions& options, bool quiet) {
  std::string current;
  std::optional<ProgressBar> bar;  // of the current file
  const auto progress = [&](const std::string& file, std::uint64_t done, std::uint64_t all) {
    if (file != current) bar.emplace(!quiet);
    current = file;
    const double bytes = static_cast<double>(done), of = static_cast<double>(all);
    const std::string amount =
        done == all ? "now building its mesh" : fmt::format("{:.0f} of {:.0f} MB", bytes / 1e6, of / 1e6);
    bar->show(bytes / of, fmt::format("reading {}: {}", cell(file), amount));
  };
  return io::open_with_progress(arguments, options, progress);
}

Result<std::unique_ptr<Motion>> open_motion_of(const Model& model, const std::vector<std::string>& arguments,
                                               const ReadOptions& options, bool quiet) {
  auto motions = FOLDPROOF_TRY(read_motions(arguments, options, quiet));
  if (motions.size() != 1) {
    return fail(ErrorCode::InvalidArgument, arguments[0],
                fmt::format("and the following arguments are {} motions", motions.size()), "give one");
  }
  const Motion& motion = *motions.front();
  FOLDPROOF_TRY(require_model_of(model, motion.topology(), motion.name(), motion.info().merged));
  return std::move(motions.front());
}

Result<void> limit_threads(int threads, std::optional<ThreadLimit>& limit) {
  if (threads < 0 || threads > 4096) {
    return fail(ErrorCode::InvalidArgument, "--threads", fmt::format("{} is not between 1 and 4096", threads),
                "give another, or leave it out to use all cores");
  }
  if (threads > 0) limit.emplace(threads);
  return {};
}

Result<void> require_number(const char* option, double value, bool zero_allowed) {
  if (!std::isfinite(value)) {
    return fail(ErrorCode::InvalidArgument, option, fmt::format("{} is not a finite number", value),
                "give another");
  }
  if (value > 0 || (zero_allowed && value == 0)) return {};
  return fail(ErrorCode::InvalidArgument, option,
              fmt::format("{} is {}", value, value < 0 ? "below 0" : "not above 0"),
              zero_allowed ? "give a number of at least 0" : "give a number above 0");
}

}  // namespace foldproof
