#include "scene.h"

#include <algorithm>
#include <cstdlib>

#include "base/try.h"
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
    std::error_code none;
    if (file.find('*') == std::string::npos) return std::filesystem::exists(path, none);
    return std::filesystem::exists(path.parent_path(), none) &&
           !std::filesystem::is_empty(path.parent_path(), none);
  });
}

Result<std::unique_ptr<Motion>> open_scene(const SceneInfo& scene) {
  if (scene.make) return scene.make();
  std::vector<std::string> arguments;
  for (const std::string& file : scene.files) arguments.push_back((data_directory() / file).string());
  auto motions = FOLDPROOF_TRY(open_motions(arguments));
  return std::move(motions.front());
}

bool is_smooth(StepSize size) { return size <= StepSize::SmoothHundredth; }

const char* kind_name(SceneKind kind) {
  constexpr const char* kNames[] = {"motion", "ground truth", "generated", "generated contact", "growth"};
  return kNames[static_cast<std::size_t>(kind)];
}

const char* size_name(StepSize size) {
  constexpr const char* kNames[] = {"smooth tenth", "smooth fortieth", "smooth hundredth",
                                    "full",         "tenth",           "hundredth"};
  return kNames[static_cast<std::size_t>(size)];
}

std::vector<StepChoice> choose_steps(Index frame_count, StepSize size, const Sampling& sampling) {
  constexpr Index kParts[] = {10, 40, 100, 1, 10, 100};
  const Index parts = kParts[static_cast<std::size_t>(size)];
  const Index available = (frame_count - 1) * parts;
  const Index together = frame_count > 2 ? parts : 1;  // a single step has no turns
  const Index wanted = (sampling.steps + together - 1) / together * together;
  const Index count = sampling.all ? available : std::min(available, wanted);
  const Index first = (available - count + 1) / 2;
  const Index before = std::min(first, std::max<Index>(1, sampling.warm_up));
  const auto step = [&](Index k, bool measured) {
    return StepChoice{k / parts, static_cast<int>(k % parts), static_cast<int>(parts), is_smooth(size),
                      measured};
  };
  std::vector<StepChoice> steps;
  if (before == 0) steps.push_back(step(first, false));
  for (Index k = first - before; k < first + count; ++k) steps.push_back(step(k, k >= first));
  return steps;
}

StepLoader::StepLoader(Motion& motion)
    : motion_(motion), x0_(std::size_t{motion.topology().vertex_count()} * 3), x1_(x0_.size()) {}

// Text files take long to read: parts of one step share its frames.
Result<void> StepLoader::read(Index number, Frame& frame) {
  if (frame.number == number) return {};
  frame.number = kNoIndex;
  frame.x.resize(x0_.size());
  if (auto done = motion_.read_frame(number, frame.x); !done) return done;
  frame.number = number;
  return {};
}

Result<void> StepLoader::load(const StepChoice& step) {
  if (auto done = read(step.frame, begin_); !done) return done;
  if (auto done = read(step.frame + 1, end_); !done) return done;
  if (step.smooth) {
    // Beyond its ends the motion stands still.
    if (auto done = read(step.frame == 0 ? 0 : step.frame - 1, before_); !done) return done;
    if (auto done = read(std::min(step.frame + 2, motion_.frame_count() - 1), after_); !done) return done;
  }
  const auto place = step.smooth ? &StepLoader::place_on_curve : &StepLoader::place_on_line;
  (this->*place)(step.part, step.parts, x0_);
  (this->*place)(step.part + 1, step.parts, x1_);
  return {};
}

void StepLoader::place_on_line(int part, int parts, std::vector<double>& x) const {
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double motion = end_.x[i] - begin_.x[i];
    x[i] = part == parts ? end_.x[i] : begin_.x[i] + motion * part / parts;
  }
}

// Catmull-Rom: at a frame the curve goes the way from the frame before to the one after. At both ends all
// factors but one are exactly 0, so that the curve of the next two frames begins where this one ends.
void StepLoader::place_on_curve(int part, int parts, std::vector<double>& x) const {
  const double t = static_cast<double>(part) / parts, u = 1 - t;
  const double at_begin = u * u * (1 + 2 * t), at_end = t * t * (1 + 2 * u);
  const double way_at_begin = t * u * u / 2, way_at_end = -t * t * u / 2;
  for (std::size_t i = 0; i < x.size(); ++i)
    x[i] = at_begin * begin_.x[i] + at_end * end_.x[i] + way_at_begin * (end_.x[i] - before_.x[i]) +
           way_at_end * (after_.x[i] - begin_.x[i]);
}

}  // namespace foldproof::bench
