/// Options that several subcommands share.
#pragma once

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

/// Of commands for which frames are poses.
inline MotionOptions pose_options() { return {.frames = {}, .read = {.mesh_files = MeshFiles::Poses}}; }

inline constexpr const char* kMotionGroup = "Which part of the motion";

/// Describes motions, for the footer of a help text.
inline constexpr const char* kMotionHelp = R"(A MOTION is one topology and its frames:
  walk.glb  walk.gltf  walk.npz   an animation; NPZ holds 'faces' and 'vertices' (frames x n x 3)
  x.npy faces.npy                 the same as two files
  walk.obj walk.pc2               a mesh followed by its point cache (.pc2, .mdd)
  walk.pvd                        the VTK files of a ParaView collection
  frames/  'frames/*.ply'         a directory or a quoted glob of meshes: frames, in natural order, if their names differ
                                  in nothing but one number, as f01.obj and f02.obj do; else a body each
  walk_%04d.obj  walk_*.obj       numbered meshes, a frame each; the second as the shell expands it
Where frames look like bodies, a check asks for --sequence or --separate, which hold for all of these.
Meshes are OBJ, OFF, PLY, STL, VTP, VTU, VTK and MSH.
)";

/// Adds --weld, which is returned, and --no-weld; not both go together.
Option add_weld_options(const Subcommand& command, ReadOptions& options);

/// Adds --frames, --fps, --weld, --no-weld, --separate, --sequence and --clip.
void add_motion_options(const Subcommand& command, MotionOptions& options);

/// The frames that --frames selects. Error: --frames or --fps is invalid.
Result<FrameRange> frame_range_of(const MotionOptions& options);

/// Adds --threads; 0 means all cores.
void add_threads_option(const Subcommand& command, int& threads, const char* description);

/// Loads a model that has learned shapes. Error: it cannot be loaded, or has not.
Result<Model> load_learned_model(const std::string& path);

/// open_motions; on a terminal, unless `quiet`, it shows how much of a large file is read.
Result<std::vector<std::unique_ptr<Motion>>> read_motions(std::span<const std::string> arguments,
                                                          const ReadOptions& options, bool quiet);

/// The same for the only motion of a command line. Error: several, or another mesh than the model's.
Result<std::unique_ptr<Motion>> open_motion_of(const Model& model, const std::vector<std::string>& arguments,
                                               const ReadOptions& options, bool quiet);

/// Sets a limit; 0 means none. Error: the number is out of range.
Result<void> limit_threads(int threads, std::optional<ThreadLimit>& limit);

/// Error: not finite, negative, or zero if that is not allowed.
Result<void> require_number(const char* option, double value, bool zero_allowed);

/// In single quotes, for a shell.
std::string in_quotes(std::string_view text);

/// The command line, quoted for a shell, with foldproof as the program's name.
std::string command_line(std::span<char* const> arguments);

/// From now on Ctrl-C and its like (system::on_interrupt) set the returned flag instead of ending the
/// program, so that no incomplete file is left behind.
const std::atomic<bool>& watch_for_interrupt();

}  // namespace foldproof
