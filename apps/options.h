/// What several subcommands ask for.
#pragma once

#include <CLI/CLI.hpp>
#include <atomic>
#include <optional>

#include "base/parallel.h"
#include "file_arguments.h"
#include "report/report.h"

namespace foldproof {

/// How motions are read.
struct MotionOptions {
  std::string frames;
  ReadOptions read;
};

inline constexpr const char* kMotionGroup = "Which part of the motion";

/// What a motion is, for the footer of a help text.
inline constexpr const char* kMotionHelp = R"(A MOTION is one topology and its frames:
  walk.glb  walk.gltf  walk.npz   an animation; NPZ holds 'faces' and 'vertices' (frames x n x 3)
  walk.obj walk.pc2               a mesh (OBJ, OFF, PLY) followed by its point cache (.pc2, .mdd)
  frames/  'frames/*.ply'         a directory or a quoted glob of meshes, a frame each, in natural order
)";

/// Adds --frames, --fps and --weld.
void add_motion_options(CLI::App& command, MotionOptions& options);

/// The frames that --frames names, once --fps is found to be good.
Result<FrameRange> frame_range_of(const MotionOptions& options);

/// Adds --threads; 0 stands for all cores.
void add_threads_option(CLI::App& command, int& threads, const char* description);

/// A model that has learned shapes. Error: it is none, or has learned nothing.
Result<Model> load_learned_model(const std::string& path);

/// The one motion that a command line names, of the model's mesh.
Result<std::unique_ptr<Motion>> open_motion_of(const Model& model, const std::vector<std::string>& arguments,
                                               const ReadOptions& options);

/// Makes a limit; 0 stands for none. Error: no sensible number.
Result<void> limit_threads(int threads, std::optional<ThreadLimit>& limit);

/// Error: not finite, negative, or zero where that is not allowed.
Result<void> require_number(const char* option, double value, bool zero_allowed);

/// What was typed, as a shell would take it; the program is called foldproof.
std::string command_line(std::span<char* const> typed);

/// From now on SIGINT, SIGTERM and SIGHUP set this instead of ending the program, so that no file stays
/// behind half written.
const std::atomic<bool>& watch_for_interrupt();

}  // namespace foldproof
