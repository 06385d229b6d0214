/// Named scenes, and which of their steps are measured.
#pragma once

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
/// simulation's is short.
enum class StepSize { Full, Tenth, Hundredth };

/// "full", "tenth", "hundredth".
const char* size_name(StepSize size);

struct StepChoice {
  Index frame = 0;  ///< From this frame to the next.
  int part = 0;     ///< This part of it, from 0.
  int parts = 0;    ///< Of so many.
};

struct Sampling {
  Index steps = 40;  ///< At most.
  bool all = false;  ///< Every step of the motion.
};

/// Steps that follow each other, from the middle of the motion, in order. The first is for a checker to begin
/// with and comes on top of those asked for: the step before them, or where the motion has none left the same
/// step twice.
std::vector<StepChoice> choose_steps(Index frame_count, StepSize size, const Sampling& sampling);

/// Positions at both ends of the steps of one motion.
class StepLoader {
 public:
  explicit StepLoader(Motion& motion);
  Result<void> load(const StepChoice& step);
  std::span<const double> x0() const { return x0_; }
  std::span<const double> x1() const { return x1_; }

 private:
  Result<void> read(Index frame);

  Motion& motion_;
  Index frame_ = kNoIndex;                 // whose step is in ends_
  std::vector<double> ends_[2], x0_, x1_;  // of the whole step, of its part
};

}  // namespace foldproof::bench
