#include "scene.h"

#include <algorithm>
#include <cstdlib>

#include "generated.h"

namespace foldproof::bench {

const std::vector<SceneInfo>& all_scenes() {
  static const std::vector<SceneInfo> scenes = {
      {"elephant-gallop",
       SceneKind::Motion,
       {"elephant/elephant-gallop.obj", "elephant/elephant-gallop.pc2"}},
      {"horse-gallop", SceneKind::Motion, {"horse-gallop/horse-gallop.obj", "horse-gallop/horse-gallop.pc2"}},
      {"lion-anim", SceneKind::Motion, {"lion-anim/lion-anim-loop1.obj", "lion-anim/lion-anim-loop1.pc2"}},
      {"hand-anim", SceneKind::Motion, {"hand/hand-anim.obj", "hand/hand-anim.pc2"}},
      {"samba", SceneKind::Motion, {"samba/samba.obj", "samba/samba.pc2"}},
      {"rumba", SceneKind::Motion, {"rumba/rumba.obj", "rumba/rumba.pc2"}},
      {"cloth-ball", SceneKind::GroundTruth, {"ccd-ground-truth/cloth-ball/frame_*.ply"}},
      {"rod-twist", SceneKind::GroundTruth, {"ccd-ground-truth/rod-twist/frame_*.ply"}},
      {"cloth-funnel", SceneKind::GroundTruth, {"ccd-ground-truth/cloth-funnel/frame_*.ply"}},
      {"bending-cylinder", SceneKind::Generated, {}, bending_cylinder},
      {"squashed-sphere", SceneKind::Generated, {}, squashed_sphere},
      {"folding-cloth", SceneKind::Generated, {}, folding_cloth},
  };
  return scenes;
}

std::filesystem::path data_directory() {
  const char* chosen = std::getenv("FOLDPROOF_DATA");
  return chosen && *chosen ? chosen : FOLDPROOF_DEFAULT_DATA;
}

bool is_available(const SceneInfo& scene) {
  return std::all_of(scene.files.begin(), scene.files.end(), [](const std::string& file) {
    const auto path = data_directory() / file;
    return std::filesystem::exists(file.find('*') == std::string::npos ? path : path.parent_path());
  });
}

Result<std::unique_ptr<Motion>> open_scene(const SceneInfo& scene) {
  if (scene.make) return scene.make();
  std::vector<std::string> arguments;
  for (const std::string& file : scene.files) arguments.push_back((data_directory() / file).string());
  auto motions = open_motions(arguments);
  if (!motions) return tl::unexpected(motions.error());
  return std::move(motions->front());
}

std::vector<StepChoice> choose_steps(Index frame_count, StepSize size, const Sampling& sampling) {
  const int tenth = size == StepSize::Tenth ? 0 : -1;
  const Index available = frame_count - 1;
  std::vector<StepChoice> steps;
  if (sampling.consecutive) {
    const Index parts = size == StepSize::Tenth ? 10 : 1;
    // One more than asked for: the step that warms up comes right before the first that counts.
    const Index count = std::min(available * parts, sampling.all ? available * parts : sampling.steps + 1);
    const Index first = (available * parts - count) / 2;
    for (Index k = first; k < first + count; ++k)
      steps.push_back({k / parts, size == StepSize::Tenth ? static_cast<int>(k % parts) : -1});
    if (count == 1) steps.push_back(steps.front());
    return steps;
  }
  const Index count = sampling.all ? available : std::min(available, sampling.steps);
  for (Index k = 0; k < count; ++k) steps.push_back({(2 * k + 1) * available / (2 * count), tenth});
  steps.insert(steps.begin(), steps.front());
  return steps;
}

StepLoader::StepLoader(Motion& motion)
    : motion_(motion), x0_(std::size_t{motion.topology().vertex_count()} * 3), x1_(x0_.size()) {}

Result<void> StepLoader::load(const StepChoice& step) {
  if (auto read = motion_.read_frame(step.frame, x0_); !read) return read;
  if (auto read = motion_.read_frame(step.frame + 1, x1_); !read) return read;
  if (step.tenth < 0) return {};
  for (std::size_t i = 0; i < x0_.size(); ++i) {
    const double motion = x1_[i] - x0_[i];
    x1_[i] = x0_[i] + motion * (step.tenth + 1) / 10;
    x0_[i] += motion * step.tenth / 10;
  }
  return {};
}

}  // namespace foldproof::bench
