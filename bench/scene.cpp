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
      {"pressed-cloths", SceneKind::Contact, {}, pressed_cloths},
      {"ball-heap", SceneKind::Contact, {}, ball_heap},
  };
  return scenes;
}

const SceneInfo* find_scene(const std::string& name) {
  const auto named = [&](const SceneInfo& scene) { return scene.name == name; };
  const auto& all = all_scenes();
  if (const auto scene = std::find_if(all.begin(), all.end(), named); scene != all.end()) return &*scene;
  const auto& growth = growth_scenes();  // made of the others: not to be asked for before
  const auto scene = std::find_if(growth.begin(), growth.end(), named);
  return scene == growth.end() ? nullptr : &*scene;
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

const char* size_name(StepSize size) {
  return size == StepSize::Full ? "full" : size == StepSize::Tenth ? "tenth" : "hundredth";
}

std::vector<StepChoice> choose_steps(Index frame_count, StepSize size, const Sampling& sampling) {
  const Index parts = size == StepSize::Full ? 1 : size == StepSize::Tenth ? 10 : 100;
  const Index available = (frame_count - 1) * parts;
  const Index count = sampling.all ? available : std::min(available, sampling.steps + 1);
  const Index first = (available - count) / 2;
  std::vector<StepChoice> steps;
  for (Index k = first; k < first + count; ++k)
    steps.push_back({k / parts, static_cast<int>(k % parts), static_cast<int>(parts)});
  if (count == available) steps.insert(steps.begin(), steps.front());
  return steps;
}

StepLoader::StepLoader(Motion& motion)
    : motion_(motion), x0_(std::size_t{motion.topology().vertex_count()} * 3), x1_(x0_.size()) {
  ends_[0] = ends_[1] = x0_;
}

// Text files take long to read: parts of one step share its ends.
Result<void> StepLoader::read(Index frame) {
  if (frame == frame_) return {};
  frame_ = kNoIndex;
  for (Index end = 0; end < 2; ++end)
    if (auto done = motion_.read_frame(frame + end, ends_[end]); !done) return done;
  frame_ = frame;
  return {};
}

Result<void> StepLoader::load(const StepChoice& step) {
  if (auto done = read(step.frame); !done) return done;
  for (std::size_t i = 0; i < x0_.size(); ++i) {
    const double motion = ends_[1][i] - ends_[0][i];
    x0_[i] = ends_[0][i] + motion * step.part / step.parts;
    x1_[i] = step.part + 1 == step.parts ? ends_[1][i] : ends_[0][i] + motion * (step.part + 1) / step.parts;
  }
  return {};
}

}  // namespace foldproof::bench
