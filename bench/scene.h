/// Named scenes, and which of their steps are measured.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "foldproof/io.h"

namespace foldproof::bench {

enum class SceneKind { Motion, GroundTruth, Generated };

struct SceneInfo {
  std::string name;
  SceneKind kind;
  std::vector<std::string> files;  ///< Below the data directory, as on a command line. Empty when generated.
  std::unique_ptr<Motion> (*make)() = nullptr;
};

/// In the order of the table.
const std::vector<SceneInfo>& all_scenes();

/// The directory named by FOLDPROOF_DATA, else the one beside the source tree. It need not exist.
std::filesystem::path data_directory();

/// True when the scene is generated or its files are there.
bool is_available(const SceneInfo& scene);

Result<std::unique_ptr<Motion>> open_scene(const SceneInfo& scene);

enum class StepSize { Full, Tenth };

struct StepChoice {
  Index frame;  ///< From this frame to the next.
  int tenth;    ///< 0 to 9: this tenth of the step. -1: all of it.
};

struct Sampling {
  Index steps = 8;
  bool all = false;          ///< Every step of the motion.
  bool consecutive = false;  ///< Steps that follow each other, from the middle of the motion; tenths as well.
};

/// The steps to measure, in order of time. The first is an extra one to warm up with.
std::vector<StepChoice> choose_steps(Index frame_count, StepSize size, const Sampling& sampling);

/// Positions at both ends of the steps of one motion.
class StepLoader {
 public:
  explicit StepLoader(Motion& motion);
  Result<void> load(const StepChoice& step);
  std::span<const double> x0() const { return x0_; }
  std::span<const double> x1() const { return x1_; }

 private:
  Motion& motion_;
  std::vector<double> x0_, x1_;
};

}  // namespace foldproof::bench
