#include "contacts.h"

#include <nlohmann/json.hpp>

#include "base/try.h"
#include "foldproof/contacts.h"
#include "measure.h"

namespace foldproof::bench {
namespace {

using nlohmann::json;

/// Milliseconds that a call takes are added to `sum`.
template <class Call>
auto timed(bool processor_time, double& sum, Call call) {
  const double start = now_milliseconds(processor_time);
  auto answer = call();
  sum += now_milliseconds(processor_time) - start;
  return answer;
}

Result<json> measure_motion(const std::string& name, Motion& motion, bool processor_time) {
  double checking = 0, finding = 0;
  const auto check = [&](auto call) { return timed(processor_time, checking, call); };
  const auto find = [&](auto call) { timed(processor_time, finding, [&] { return call(), 0; }); };
  StepLoader loader(motion);
  FOLDPROOF_TRY(loader.load({.frame = 0, .parts = 1}));
  auto built = FOLDPROOF_TRY(Hierarchy::build(motion.topology(), loader.x0()));
  StepChecker checker({Object(std::move(built))});
  auto finder = FOLDPROOF_TRY(ContactFinder::make({&motion.topology()}));

  const Index steps = motion.frame_count() - 1;
  std::uint64_t pairs = 0, contacts = 0;
  for (Index k = 0; k < steps; ++k) {
    FOLDPROOF_TRY(loader.load({.frame = k, .parts = 1}));
    const std::span<const double> x0[] = {loader.x0()}, x1[] = {loader.x1()};
    if (k == 0) {
      StaticResult crossings;
      FOLDPROOF_TRY(check([&] { return checker.check_static(x0, {}, crossings); }));
      find([&] { finder.start(0, x0, crossings); });
    }
    StepResult answer;
    FOLDPROOF_TRY(check([&] { return checker.check(x0, x1, {}, answer); }));
    find([&] { finder.step(k, k + 1, x0, x1, answer); });
    pairs += answer.count();
    contacts += finder.take_ended().size();
  }
  contacts += finder.finish().size();
  return json{{"name", name},
              {"steps", steps},
              {"pairs", pairs},
              {"contacts", contacts},
              {"check_milliseconds", checking},
              {"contact_milliseconds", finding}};
}

}  // namespace

Result<json> measure_contacts(const std::vector<SceneInfo>& scenes, bool processor_time) {
  json rows = json::array();
  for (const SceneInfo& scene : scenes) {
    if (scene.kind != SceneKind::Motion && scene.kind != SceneKind::GroundTruth) continue;
    const auto motion = FOLDPROOF_TRY(open_scene(scene));
    rows.push_back(FOLDPROOF_TRY(measure_motion(scene.name, *motion, processor_time)));
  }
  return rows;
}

}  // namespace foldproof::bench
