/// Named scenes, and which of their steps are measured.
#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "foldproof/io.h"

namespace foldproof::bench {

/// Motions of the data and of simulations with known collisions; made by the bench, without and with many
/// places where surfaces touch; one shape at many resolutions.
enum class SceneKind { Motion, GroundTruth, Generated, Contact, Growth };

struct SceneInfo {
  std::string name;
  SceneKind kind;
  std::vector<std::string> files;  ///< Below the data directory, as on a command line. Empty when generated.
  std::function<Result<std::unique_ptr<Motion>>()> make = nullptr;  ///< Where more is to do than to read.
  Index triangles = 0;                                              ///< Of growth scenes.
};

/// In the order of the table.
const std::vector<SceneInfo>& all_scenes();

/// The lion and the hand, subdivided, and a generated cloth, from 10,000 to 2,000,000 triangles. Of each the
/// coarsest first.
const std::vector<SceneInfo>& growth_scenes();

/// Among both; null when there is none of this name.
const SceneInfo* find_scene(const std::string& name);

/// The directory named by FOLDPROOF_DATA, else the one beside the source tree. It need not exist.
std::filesystem::path data_directory();

/// True when the scene is generated or its files are there.
bool is_available(const SceneInfo& scene);

Result<std::unique_ptr<Motion>> open_scene(const SceneInfo& scene);

/// A step of the motion, or one of the parts that it is cut into: an animation's step is long, a
/// simulation's is short. Parts lie on the straight lines between frames, where vertices turn at frames only,
/// or on smooth curves through them, where vertices turn all the time.
enum class StepSize { SmoothTenth, SmoothFortieth, SmoothHundredth, Full, Tenth, Hundredth };
/// In the order of the tables: what motions do comes first, straight parts, the best case there is, last.
inline constexpr std::array<StepSize, 6> kStepSizes = {StepSize::SmoothTenth,     StepSize::SmoothFortieth,
                                                       StepSize::SmoothHundredth, StepSize::Full,
                                                       StepSize::Tenth,           StepSize::Hundredth};
bool is_smooth(StepSize size);

/// "motion", "ground truth", "generated", "generated contact", "growth".
const char* kind_name(SceneKind kind);

/// "smooth tenth", "smooth fortieth", "smooth hundredth", "full", "tenth", "hundredth".
const char* size_name(StepSize size);

struct StepChoice {
  Index frame = 0;       ///< From this frame to the next.
  int part = 0;          ///< This part of it, from 0.
  int parts = 0;         ///< Of so many.
  bool smooth = false;   ///< On the curve through the frames instead of the line between them.
  bool measured = true;  ///< Else it is only there to warm up.
};

struct Sampling {
  /// At most. Of parts as many as make whole steps, where there are more than one: motions turn at frames,
  /// and a few parts between two frames would tell of a motion that never turns.
  Index steps = 40;
  bool all = false;   ///< Every step of the motion.
  Index warm_up = 1;  ///< Steps before those measured, at most; one there always is.
};

/// Steps that follow each other, in order: those measured, from the middle of the motion, and before them
/// those to warm up, as many as the motion has there. Where it has none, the first measured step comes twice.
std::vector<StepChoice> choose_steps(Index frame_count, StepSize size, const Sampling& sampling);

/// Positions at both ends of the steps of one motion.
class StepLoader {
 public:
  explicit StepLoader(Motion& motion);
  Result<void> load(const StepChoice& step);
  std::span<const double> x0() const { return x0_; }
  std::span<const double> x1() const { return x1_; }

 private:
  struct Frame {
    Index number = kNoIndex;
    std::vector<double> x;
  };
  Result<void> read(Index number, Frame& frame);
  /// Where the vertices are after `part` of the `parts` of the way between the two frames.
  void place_on_line(int part, int parts, std::vector<double>& x) const;
  void place_on_curve(int part, int parts, std::vector<double>& x) const;

  Motion& motion_;
  Frame before_, begin_, end_, after_;  // the outer ones for smooth steps only
  std::vector<double> x0_, x1_;
};

}  // namespace foldproof::bench
