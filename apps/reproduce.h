/// The parts of `foldproof reproduce`.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "foldproof/check.h"
#include "foldproof/model.h"
#include "picture/picture.h"

namespace foldproof::reproduce {

/// A mesh to experiment on: poses to learn from, and a motion that learning never sees.
struct Subject {
  std::string id;      ///< Begins the names of its files.
  std::string name;    ///< For people, as a sentence begins: "The creature".
  std::string source;  ///< Generated or from which files, what is derived, whom to credit.
  std::unique_ptr<Motion> poses = nullptr, motion = nullptr;
  bool pictures = true;  ///< False: for the table alone.
  View view = {};
  Index bent = 0;         ///< Of the motion: the frame to be shown and rebuilt.
  std::string limb = {};  ///< What is bent inwards in that frame; empty: no limb.
};

/// How large the generated meshes are.
enum class Size { Full, Quick };

/// Cylinder and creature; both generated.
std::vector<Subject> generated_subjects(Size size);
/// What there is of lion, hand, horse and elephant in a directory that is laid out as docs/reproduction.md
/// says. Error: a file that is there cannot be read.
Result<std::vector<Subject>> subjects_in(const std::string& directory);

/// Frames of a motion, all in memory.
Result<std::vector<std::vector<double>>> read_frames(Motion& motion);

/// A way to answer steps, measured over a motion. What it gives is held against plain hierarchies, step by
/// step.
struct ModeRow {
  std::string name;
  double milliseconds = 0;  ///< Median over the steps but the first.
  double leaf_pairs = 0;    ///< Mean per step, without the first.
  double removed = 0;       ///< Share of the leaf pairs that plain hierarchies test.
  Index empty_steps = 0;    ///< In which no feature was tested.
  std::uint64_t collisions = 0, misses = 0, extra = 0;  ///< In all steps.
  bool statistical = false;                             ///< May miss.
};

/// The step with the most collisions, as plain hierarchies find them.
struct WorstStep {
  Index frame = 0;
  StepResult answer;  ///< Nothing in it when no step collides.
};

struct Measured {
  Index steps = 0;
  std::vector<ModeRow> modes;  ///< Plain hierarchies first.
  std::vector<ModeRow>
      reduced;  ///< The same for the motion in the subspace; empty where nothing was learned.
  Index reduced_modes = 0;
  WorstStep worst;
};

struct Hooks {
  std::function<void(double, const std::string&)>
      progress;  ///< Share of a part that is done, and what it is.
  const std::atomic<bool>* cancel = nullptr;
  bool cancelled() const { return cancel->load(std::memory_order_relaxed); }
};

/// Error: a frame cannot be read, cancelled.
Result<Measured> measure(Subject& subject, const Model& model, const Hooks& hooks);

/// Pictures that stand in the directory, and what is to be said about them, in Markdown.
struct Figure {
  std::vector<std::string> files;
  std::string text;
};

/// Draws into a directory; each gives one figure.
class Figures {
 public:
  explicit Figures(std::string directory) : directory_(std::move(directory)) {}

  Result<Figure> key_points(Subject& subject, const Model& model) const;     ///< Fig. 2, 3
  Result<Figure> training_poses(Subject& subject) const;                     ///< Fig. 4
  Result<Figure> prediction(Subject& subject, const Model& model) const;     ///< Fig. 5
  Result<Figure> bent(Subject& subject, const Model& model) const;           ///< Fig. 6
  Result<Figure> collision(Subject& subject, const WorstStep& worst) const;  ///< Fig. 7, 8
  Result<Figure> rebuilt(Subject& subject, const Model& model) const;        ///< Fig. 9
  /// What the paper says of directions without an example: the cylinder, taught to bend in one plane only.
  Result<Figure> missing_direction(Size size, const Hooks& hooks) const;

 private:
  Result<void> write(const std::string& file, std::span<const Panel> panels,
                     const PictureSettings& settings) const;
  std::string directory_;
};

/// Markdown tables.
std::string table_of(const Measured& measured);

}  // namespace foldproof::reproduce
