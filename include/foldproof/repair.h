/// Repair: the nearest motion that touches nothing, proven (docs/repair.md).
#pragma once

#include <functional>
#include <limits>

#include "foldproof/contacts.h"

namespace foldproof {

/// An object of a motion to repair.
struct RepairObject {
  Object object;
  /// Per vertex, 0 where it may not move; empty: all may. Vertices that may not move still follow the motion.
  std::vector<std::uint8_t> movable = {};
  /// Per vertex, the one that triangles name in its place (MotionInfo::merged): both move together. Empty:
  /// none was merged.
  std::vector<Index> merged = {};
  std::string name = {};  ///< For errors.
};

/// What comes in. Positions of a frame are those of all objects, one object after the other: vertex_count x 3
/// row-major doubles each, mesh units.
struct RepairInput {
  std::vector<RepairObject> objects;
  Index frame_count = 1;
  Index first_frame = 0;  ///< The number of frame 0, for errors.
  /// Fills `x` with frame `k` < frame_count. Called for any frame, any number of times, from the thread that
  /// called repair; an error ends the repair and is returned.
  std::function<Result<void>(Index k, std::span<double> x)> read;
  /// Pairs that may touch; null: none. Pairs of features that may not move are left as they are without it.
  std::shared_ptr<const PairFilter> filter = nullptr;
  /// For contacts, as ContactFinder takes them.
  Parts parts = {};
};

struct RepairSettings {
  /// Mesh units, >= 0. Nothing may come as close as this.
  double thickness = 0;
  /// Mesh units: how far along the surface a correction spreads. 0: a twentieth of the size of what may move,
  /// or four edges, whichever is larger.
  double falloff = 0;
  /// Round positions to single precision before they are proven, as a file that holds no more does.
  bool single_precision = false;
  /// How many frames may be added between two frames where a correction cannot keep up otherwise.
  Index in_betweens = 0;
  /// How close to the minimum a correction is, relative to what is usual, in (0,1]; closer takes longer.
  double accuracy = 1;
  /// A second pass makes corrections calm in time.
  bool calm = true;
  /// A pose that touches nothing, of all objects one after the other, from which frame `start_frame` is
  /// approached. Empty: a frame that is free, a pose of `poses` that is, or one that can be untangled.
  std::vector<double> start = {};
  Index start_frame = 0;
  /// Poses of the same form that may touch nothing, such as a model's: the repair starts in the first of
  /// these that does not. Called at most once, and only where no frame is free; null: there are none.
  std::function<Result<std::vector<std::vector<double>>>()> poses = nullptr;
  /// Only contacts for which this is true are repaired; what touches in all others may go on touching, and so
  /// may triangles next to it. Null: all are.
  std::function<bool(const Contact&)> chosen = nullptr;
  /// When interrupted, write the frames that are finished so far.
  bool keep = false;
  /// Asked several times a frame, from the thread that called repair: whether to stop.
  std::function<bool()> interrupted = nullptr;
  /// Called with the share of the work that is done, in [0,1].
  std::function<void(double)> progress = nullptr;
};

/// Why a frame is not free.
enum class RepairLimit : std::uint8_t {
  None,         ///< It is free, and so is the way to it.
  NoFreeStart,  ///< What touches in it was in contact where the repair began.
  GivenUp,      ///< What may not move leaves no way, or none was found. The frame is that of the input.
};
inline constexpr std::array<const char*, 3> kRepairLimitNames{"none", "no_free_start", "given_up"};

/// A frame that was written.
struct RepairedFrame {
  double time = 0;        ///< In frames of the input; added frames have times between.
  double correction = 0;  ///< The largest distance that a vertex was moved, mesh units.
  /// The correction could not keep up: more frames would make it smaller, or the frame is free, but on the
  /// other side of what the motion goes through.
  bool late = false;
  RepairLimit limit = RepairLimit::None;  ///< Of the frame and the step before it.
};

struct RepairReport {
  /// Proven: nothing that was not ignored touches at any time, while vertices move straight from each frame
  /// that was written to the next, but maybe what may not move, with itself (among_fixed), and what was left.
  bool free = false;
  /// The motion came back as it was: it was free.
  bool unchanged = false;
  /// It was interrupted, and the frames that were finished were written (RepairSettings::keep).
  bool interrupted = false;
  /// Frames were written. False where there was no free start.
  bool written = false;
  /// The input ends as it begins, what was written does not: it could not be made so.
  bool open_loop = false;
  std::vector<RepairedFrame> frames;
  std::vector<Contact> before;     ///< Contacts of the input.
  std::vector<Contact> remaining;  ///< Contacts of what was written, or would have been.
  std::vector<Contact> left;       ///< Those of what was written that were not RepairSettings::chosen.
  /// Contacts of what may not move with itself, in no other list; without regard to the thickness. Empty: it
  /// is proven that there are none.
  std::vector<Contact> among_fixed;
  double falloff = 0;    ///< As used, mesh units.
  double clearance = 0;  ///< How far apart surfaces are kept beyond the thickness, mesh units.
};

/// Writes the motion that is nearest to the input and touches nothing.
///
/// A correction is as rigid as possible relative to the input (Sorkine and Alexa, As-rigid-as-possible
/// surface modeling, 2007), and a logarithmic barrier keeps features apart (Li et al., Incremental potential
/// contact, 2020). Every frame is accepted only if StepChecker proves the straight way to it. It starts at a
/// frame that is free, or in a pose that is given or untangled, and goes forwards and backwards.
///
/// `write` gets the frames in order, after all are found: its positions as in RepairInput, read until it
/// returns. Where nothing has a free start, it is not called. Each step that is written was checked as
/// StepChecker::check does, rounded; the report says what touches. Bit-identical for any number of threads.
/// Memory: the meshes, a few frames, and 28 bytes for each vertex of a frame that moves. Cost: 10 to 50 times
/// that of checking the frames in contact. Error: what `read` and `write` return; wrong sizes, coordinates
/// that are not finite or above 1e30; a thickness that neighboring features of the mesh do not keep; single
/// precision that is too coarse for the mesh; nothing that may move; Interrupted, without `keep`.
Result<RepairReport> repair(const RepairInput& input, const RepairSettings& settings,
                            const std::function<Result<void>(double time, std::span<const double> x)>& write);

}  // namespace foldproof
