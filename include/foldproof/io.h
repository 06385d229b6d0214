/// Reading and writing meshes and motions in common file formats.
#pragma once

#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "foldproof/mesh.h"

namespace foldproof {

/// Parts of a mesh, by name.
struct ObjectParts {
  std::vector<std::string> names;
  /// An index into names for each triangle, lines and points included; empty: there are no parts.
  std::vector<Index> of_triangle;
};

/// What a reader knows of a motion besides its triangles and frames.
struct MotionInfo {
  /// The parts that the file names, such as the groups of an OBJ (docs/formats.md). None where it names fewer
  /// than two.
  ObjectParts parts = {};
  /// What a mesh unit is, where the format defines it: "m" for glTF. Empty: not known.
  std::string unit = {};
  /// What the file holds and this motion leaves out, or what was assumed: one sentence each, for the user.
  std::vector<std::string> notes = {};
  /// What files were taken for where they might mean something else, to be named in the verdict: "3 frames of
  /// one mesh". Empty: nothing was assumed.
  std::string taken_as = {};
  /// What of the file is not checked, to be named in the verdict: "5 vertices in no face were not checked".
  std::vector<std::string> unchecked = {};
  /// Per vertex, the one that triangles name in its place: itself, or the one that it was merged into. Empty:
  /// none was merged.
  std::vector<Index> merged = {};
  /// Faces with the same three vertices are layers of one surface, such as its two sides, and do not cross.
  bool layered = false;
  /// Of poses that are files of different names: these names, without folders and extensions. Empty: frames
  /// have numbers.
  std::vector<std::string> frame_names = {};
  /// The clips of a glTF, as ReadOptions::clip takes them.
  std::vector<std::string> clips = {};
  /// The motion is a single pose that stands still as long as others move (ReadOptions::still).
  bool still = false;
};

/// One topology and its frames, read one at a time; memory holds a frame or two, never the sequence.
class Motion {
 public:
  virtual ~Motion() = default;
  /// The file or directory it came from, for messages.
  virtual const std::string& name() const = 0;
  virtual const Topology& topology() const = 0;
  /// Empty unless a reader has something to say.
  virtual const MotionInfo& info() const;
  /// At least 1.
  virtual Index frame_count() const = 0;
  /// Fills `out` (vertex_count x 3, row-major, mesh units) with frame `k` < frame_count(). Frames may be read
  /// in any order, any number of times. Not thread-safe. Error: the file changed, or this frame is invalid
  /// (other topology, NaN, truncated).
  virtual Result<void> read_frame(Index k, std::span<double> out) = 0;
};

/// Which vertices become one. Only triangles change: vertices keep their numbers (MotionInfo::merged).
enum class Weld : std::uint8_t {
  ByFormat,  ///< Those that are one by construction: the seams of glTF and STL (docs/formats.md).
  Always,    ///< All that are at exactly one place in the first frame. Where they part later: an error.
  Never,
};

/// What several mesh files are: those of a directory, glob or numbered name, and those that are named one
/// after the other.
enum class MeshFiles : std::uint8_t {
  /// Frames of one motion if their names differ in nothing but one number, else bodies. Where the frames look
  /// like bodies: an error of the code Ambiguous (docs/formats.md).
  ByName,
  Poses,     ///< Poses of one mesh where one argument names them; else by name. Nothing is doubted.
  Sequence,  ///< Frames of one motion. Of arguments, those without a number are one motion, too.
  Separate,  ///< Bodies, each a motion of its own.
};

struct ReadOptions {
  double fps = 24;  ///< Sampling rate for animated glTF, frames per second.
  Weld weld = Weld::ByFormat;
  MeshFiles mesh_files = MeshFiles::ByName;
  /// Motions of a single frame stand still as long as the longest of the others lasts. With
  /// MeshFiles::ByName, files that are more or fewer than the others have frames are bodies.
  bool still = false;
  /// Vertices in no face and no line are checked as points. Off: they are named in MotionInfo::unchecked.
  bool points = false;
  /// The clip of a glTF that is read: its name, or "animations[1]". Empty: the longest.
  std::string clip = {};
};

/// A path's extension in lower case, with its dot; empty when it has none.
std::string extension_of(const std::string& path);

/// Opens the motions that a command line names (docs/formats.md). A mesh file followed by its .pc2 or .mdd is
/// one motion. What other mesh files are, those of a directory, a quoted glob or a name with "%d" or "%04d"
/// for their number, or several one after the other, ReadOptions::mesh_files decides; frames are in natural
/// order. Every other argument is a motion of its own: a mesh file (one frame), or a .gltf, .glb, .npz or
/// .pvd file.
Result<std::vector<std::unique_ptr<Motion>>> open_motions(std::span<const std::string> arguments,
                                                          const ReadOptions& options = {});

/// A motion that is already in memory: `frames`, each vertex_count x 3. MotionInfo::unchecked names vertices
/// in no triangle.
std::unique_ptr<Motion> memory_motion(std::string name, Topology topology,
                                      std::vector<std::vector<double>> frames);

/// A file that appears under its name only when `commit` is called; without it, nothing is left behind.
/// The temporary file is in the target's directory, so the final rename is atomic.
class FileWriter {
 public:
  /// "-" is standard output, which is written directly, as are other names of what is open already, such as
  /// /dev/stdout; that the reader of standard output has closed it is no error.
  static Result<FileWriter> open(const std::string& path);
  FileWriter(FileWriter&&) noexcept;
  FileWriter& operator=(FileWriter&&) noexcept;
  ~FileWriter();
  Result<void> write(std::span<const char> bytes);
  Result<void> write(const std::string& text) {
    return write(std::span<const char>(text.data(), text.size()));
  }
  /// Overwrites bytes already written. Error: the target is written directly.
  Result<void> rewrite(std::uint64_t offset, std::span<const char> bytes);
  Result<void> commit();

 private:
  FileWriter() = default;
  struct State;
  std::unique_ptr<State> state_;
};

/// Binary little-endian PLY with double positions and, per face and line, one unsigned byte property `mark`
/// (`marks`: per triangle; may be empty: no property). Lines become PLY's edges; points are left out.
Result<void> write_ply(const std::string& path, const Topology& topology, std::span<const double> positions,
                       std::span<const std::uint8_t> marks);

/// A PLY property of faces and edges: one value per triangle. The PLY type is that of the values.
struct FaceProperty {
  const char* name;
  std::variant<std::span<const std::uint8_t>, std::span<const std::int32_t>, std::span<const float>> values;
};

/// As write_ply, with any properties.
Result<void> write_ply_properties(const std::string& path, const Topology& topology,
                                  std::span<const double> positions,
                                  std::span<const FaceProperty> properties);

/// OBJ of one pose.
Result<void> write_obj(const std::string& path, const Topology& topology, std::span<const double> positions);

/// OBJ of the first frame and PC2 (float32) of all frames, streamed from `motion`.
Result<void> write_obj_pc2(const std::string& obj_path, const std::string& pc2_path, Motion& motion);

/// NPZ with `faces` (triangles x 3, int32) and `vertices` (frames x n x 3, float64), streamed from `motion`.
/// Error: lines or points, which it does not hold.
Result<void> write_npz(const std::string& path, Motion& motion);

/// Writes a motion in the format that the extension names: .npz; .obj, with the frames in a .pc2 beside it
/// when there are several; .ply, for one frame. "%d" or "%04d" in the name of an .obj or .ply: a file per
/// frame, numbered from 0; an error removes those that it has written. .ply leaves points out.
Result<void> write_motion(const std::string& path, Motion& motion);

/// Finite numbers from a file.
struct NumberTable {
  std::vector<std::uint64_t> shape;  ///< Rows first; at least one value in all.
  std::vector<std::string> names;    ///< Of the columns, if a CSV has them; else empty.
  std::vector<double> values;        ///< Row-major.
};

/// Reads text with a row per line and commas between numbers; the first line may hold names, all different,
/// each with a letter, and none a number, NaN, infinity or a word such as "null". Empty lines and comments,
/// which start with '#', are skipped. A line that starts with a spreadsheet's error value, such as `#N/A`, is
/// no comment but an error. Shape: rows x columns.
Result<NumberTable> read_csv(const std::string& path);

/// Reads a float32 or float64 array of any shape from an NPZ into memory.
Result<NumberTable> read_npz_numbers(const std::string& path, const std::string& array);

/// Whether an NPZ has an array of this name.
Result<bool> npz_has_array(const std::string& path, const std::string& array);

}  // namespace foldproof
