/// foldproof-steps: takes the steps it is told to, one line of input and one of output each, so that two
/// revisions of the library can take turns (tools/bench_against). It uses nothing of the library but what has
/// long been public.
///
///     scenes                  -> the names of the scenes whose files are there, but for those of growth
///     plan SIZE STEPS         -> the steps to take, FRAME/PART/PARTS each; the first is to warm up
///     scene NAME              -> MILLISECONDS of processor time that the hierarchy took
///     checker                 -> ok; a new one
///     step FRAME PART PARTS   -> WALL PROCESSOR milliseconds, COLLISIONS, a HASH of the answer
///     train NAME              -> WALL PROCESSOR milliseconds of training on all frames
///
/// What goes wrong is told in a line that begins with "error".
#include <fmt/format.h>
#include <oneapi/tbb/global_control.h>

#include <bit>
#include <ctime>
#include <iostream>
#include <optional>
#include <sstream>

#include "base/try.h"
#include "foldproof/model.h"
#include "scene.h"
#if __has_include("foldproof/check.h")
#include "foldproof/check.h"
#else  // before 2026-11-24
#include "foldproof/query.h"
#endif

namespace foldproof::bench {
namespace {

double milliseconds(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) * 1e3 + static_cast<double>(now.tv_nsec) / 1e6;
}

/// Wall and processor time of a call.
template <class Call>
std::array<double, 2> times_of(Call call) {
  const double wall = milliseconds(CLOCK_MONOTONIC), processor = milliseconds(CLOCK_PROCESS_CPUTIME_ID);
  call();
  return {milliseconds(CLOCK_MONOTONIC) - wall, milliseconds(CLOCK_PROCESS_CPUTIME_ID) - processor};
}

/// FNV-1a over everything that a collision says.
std::uint64_t hash_of(const StepResult& result) {
  std::uint64_t hash = 0xcbf29ce484222325;
  const auto add = [&](std::uint64_t value) { hash = (hash ^ value) * 0x100000001b3; };
  for (const auto& c : result.vertex_face)
    for (const std::uint64_t value :
         {std::uint64_t{c.vertex}, std::uint64_t{c.face}, std::bit_cast<std::uint64_t>(c.toi)})
      add(value);
  for (const auto& c : result.edge_edge)
    for (const std::uint64_t value : {std::uint64_t{c.a[0]}, std::uint64_t{c.a[1]}, std::uint64_t{c.b[0]},
                                      std::uint64_t{c.b[1]}, std::bit_cast<std::uint64_t>(c.toi)})
      add(value);
  return hash;
}

class Steps {
 public:
  Result<std::string> answer(const std::string& line) {
    std::istringstream words(line);
    std::string command;
    words >> command;
    if (command == "scenes") return scenes();
    if (command == "plan") return plan(words);
    if (command == "scene") return open(words);
    if (command == "checker") return new_checker();
    if (command == "step") return step(words);
    if (command == "train") return train(words);
    return fail(line, "is no command", "see bench/against/steps.cpp");
  }

 private:
  static Result<std::string> scenes() {
    std::string names;
    for (const SceneInfo& scene : all_scenes())
      if (is_available(scene)) names += scene.name + " ";
    return names;
  }

  Result<std::string> plan(std::istringstream& words) {
    std::string size, out;
    Sampling sampling;
    words >> size >> sampling.steps;
    if (!motion_) return fail("plan", "comes before any scene", "send a scene first");
    for (const StepSize s : {StepSize::Full, StepSize::Tenth, StepSize::Hundredth})
      if (size == size_name(s))
        for (const StepChoice& step : choose_steps(motion_->frame_count(), s, sampling))
          out += fmt::format("{}/{}/{} ", step.frame, step.part, step.parts);
    return out;
  }

  Result<std::string> open(std::istringstream& words) {
    std::string name;
    words >> name;
    const SceneInfo* scene = find_scene(name);
    if (scene == nullptr) return fail(name, "is no scene", "see foldproof-bench --list");
    auto motion = FOLDPROOF_TRY(open_scene(*scene));
    motion_ = std::move(motion);
    loader_.emplace(*motion_);
    std::vector<double> x(std::size_t{motion_->topology().vertex_count()} * 3);
    FOLDPROOF_TRY(motion_->read_frame(0, x));
    Result<Hierarchy> built = fail("", "", "");
    const auto times = times_of([&] { built = Hierarchy::build(motion_->topology(), x); });
    if (!built) return tl::unexpected(built.error());
    hierarchy_ = std::make_shared<const Hierarchy>(std::move(*built));
    return fmt::format("{} {}", times[0], times[1]);
  }

  Result<std::string> new_checker() {
    if (!hierarchy_) return fail("checker", "comes before any scene", "send a scene first");
    checker_.emplace(StepChecker({hierarchy_}));
    return std::string("ok");
  }

  Result<std::string> step(std::istringstream& words) {
    if (!checker_) return fail("step", "comes before any checker", "send checker first");
    StepChoice choice;
    words >> choice.frame >> choice.part >> choice.parts;
    FOLDPROOF_TRY(loader_->load(choice));
    const std::span<const double> x0[] = {loader_->x0()}, x1[] = {loader_->x1()};
    Result<void> done;
    const auto times = times_of([&] { done = checker_->check(x0, x1, {}, result_); });
    if (!done) return tl::unexpected(done.error());
    return fmt::format("{} {} {} {:x}", times[0], times[1], result_.count(), hash_of(result_));
  }

  static Result<std::string> train(std::istringstream& words) {
    std::string name;
    words >> name;
    std::vector<std::string> files;
    for (const char* ending : {".obj", ".pc2"})
      files.push_back((data_directory() / (name + ending)).string());
    auto motions = FOLDPROOF_TRY(open_motions(files));
    std::vector<TrainPose> poses;
    Motion* motion = motions.front().get();
    for (Index frame = 0; frame < motion->frame_count(); ++frame) poses.push_back({motion, frame});
    Result<Model> model = fail("", "", "");
    const auto times = times_of([&] { model = train_model(poses, {}); });
    if (!model) return tl::unexpected(model.error());
    return fmt::format("{} {}", times[0], times[1]);
  }

  std::unique_ptr<Motion> motion_;
  std::optional<StepLoader> loader_;
  std::shared_ptr<const Hierarchy> hierarchy_;
  std::optional<StepChecker> checker_;
  StepResult result_;
};

}  // namespace
}  // namespace foldproof::bench

int main() {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
  foldproof::bench::Steps steps;
  for (std::string line; std::getline(std::cin, line);) {
    const auto answer = steps.answer(line);
    std::cout << (answer ? *answer : "error " + answer.error().line()) << std::endl;
  }
}
