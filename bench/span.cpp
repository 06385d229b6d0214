#include "span.h"

#include <algorithm>

#include <nlohmann/json.hpp>

#include "base/parallel.h"
#include "base/try.h"

namespace foldproof::bench {

using nlohmann::json;

#if defined(FOLDPROOF_THREADS_RECORD)

namespace {

using Loops = std::vector<std::vector<double>>;

// What oneTBB takes for a piece and for a loop on so many processors, milliseconds. A piece: measured on one
// thread, with pieces of 2 and 10 us. A loop: assumed.
constexpr double kPiece = 0.0001;
double cost_of_loop(int processors) { return processors == 2 ? 0.002 : 0.004; }

// When the last processor is done, if a free one takes the next piece.
double makespan(const std::vector<double>& pieces, int processors) {
  std::vector<double> ends(static_cast<std::size_t>(processors));
  for (const double piece : pieces) *std::min_element(ends.begin(), ends.end()) += piece + kPiece;
  return *std::max_element(ends.begin(), ends.end());
}

struct Sums {
  double steps = 0, total = 0, serial = 0, imbalance = 0, loops = 0, pieces = 0, on_2 = 0, on_16 = 0;

  void add(const Loops& step, double milliseconds) {
    double parallel = 0, ends_2 = 0, ends_16 = 0;
    for (const std::vector<double>& loop : step) {
      double work = 0;
      for (const double piece : loop) work += piece;
      const double last = makespan(loop, 16);
      imbalance += last - work / 16;
      parallel += work;
      ends_2 += makespan(loop, 2) + cost_of_loop(2);
      ends_16 += last + cost_of_loop(16);
      pieces += static_cast<double>(loop.size());
    }
    loops += static_cast<double>(step.size());
    total += milliseconds;
    serial += milliseconds - parallel;
    on_2 += milliseconds - parallel + ends_2;
    on_16 += milliseconds - parallel + ends_16;
    ++steps;
  }
};

Result<json> span_of(Motion& motion, StepSize size, const Plan& plan) {
  StepChecker checker({FOLDPROOF_TRY(build_hierarchy(motion, plan.hierarchy))});
  StepLoader loader(motion);
  StepResult result;
  Sums sums;
  for (const StepChoice& step : choose_steps(motion.frame_count(), size, plan.sampling)) {
    FOLDPROOF_TRY(loader.load(step));
    Loops loops;
    recorded_loops = &loops;
    const double start = now_milliseconds(false);
    const auto done = checker.check(loader.x0(), loader.x1(), {}, result);
    const double milliseconds = now_milliseconds(false) - start;
    recorded_loops = nullptr;
    FOLDPROOF_TRY(done);
    if (step.measured) sums.add(loops, milliseconds);
  }
  const double n = sums.steps;
  return json{{"step", size_name(size)},
              {"triangles", motion.topology().triangles().size()},
              {"milliseconds", sums.total / n},
              {"serial", sums.serial / n},
              {"imbalance", sums.imbalance / n},
              {"loops", sums.loops / n},
              {"pieces", sums.pieces / n},
              {"speedup_2", sums.total / sums.on_2},
              {"speedup_16", sums.total / sums.on_16}};
}

bool is_wanted(const SceneInfo& scene) {
  const Index n = scene.triangles;
  return scene.kind == SceneKind::Motion || scene.kind == SceneKind::GroundTruth ||
         (n > 199'000 && n < 300'000) || n > 1'500'000;
}

}  // namespace

Result<json> measure_span(std::span<const SceneInfo> scenes, const Plan& plan) {
  json rows = json::array();
  for (const SceneInfo& scene : scenes) {
    if (!is_wanted(scene) || scene.triangles > plan.growth_largest || !is_available(scene)) continue;
    auto motion = FOLDPROOF_TRY(open_scene(scene));
    for (const StepSize size : {StepSize::Full, StepSize::SmoothTenth}) {
      if (std::ranges::find(plan.sizes, size) == plan.sizes.end()) continue;
      if (is_smooth(size) && scene.kind == SceneKind::GroundTruth) continue;
      auto row = FOLDPROOF_TRY(span_of(*motion, size, plan));
      row["name"] = scene.name;
      rows.push_back(std::move(row));
    }
  }
  return rows;
}

#else

Result<json> measure_span(std::span<const SceneInfo>, const Plan&) {
  return fail("--span", "this program does not record loops",
              "build the preset span: build-span/foldproof-bench");
}

#endif

}  // namespace foldproof::bench
