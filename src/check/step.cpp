#include "check/step.h"

#include "check/answer.h"
#include "check/stretches.h"

namespace foldproof::internal {

Result<void> check_step(const Query& query, Positions x0, Positions x1, const StepSettings& settings,
                        StepResult& out) {
  Pipeline& pipeline = query.pipeline;
  StepMotion& motion = pipeline.motion;
  LookAhead* const look_ahead = query.look_ahead;
  clear(out);
  FOLDPROOF_TRY(check_settings(settings, motion.size()));

  bool cache_hit = false, cuts_time = false;
  double distance = 0;
  // Reads and validates positions, refits.
  const auto update = [&]() -> Result<void> {
    const LookAhead::Plan plan =
        look_ahead != nullptr ? look_ahead->plan(motion, x0, x1, settings) : LookAhead::Plan{};
    cache_hit = plan.is_cache_hit();
    FOLDPROOF_TRY(cache_hit ? motion.check_isolated_vertices(x0, x1) : motion.update(x0, x1, plan.steps));
    out.work.refits = cache_hit ? 0 : motion.size();
    out.search_steps = cache_hit ? 0 : motion.steps();
    out.tolerance = tolerance_for(settings, cache_hit ? plan.extent : motion.step_extent());
    distance = query.search_distance(settings, out);
    cuts_time = !settings.explain && settings.declared_free == nullptr && !cache_hit && motion.steps() == 1 &&
                is_long(motion);
    return {};
  };
  // Broad phase and culling: finds pairs of leaves.
  const auto search = [&]() -> Result<void> {
    if (cache_hit || cuts_time) return {};
    return look_ahead != nullptr ? look_ahead->search(pipeline, settings, distance, out.work)
                                 : pipeline.find_leaf_pairs(settings, distance, out.work);
  };
  // Finds which of their features collide.
  const auto narrow = [&]() -> Result<void> {
    if (cuts_time) return {};
    const BroadPhase& found = pipeline.broad_phase;
    NarrowStep step(settings, out.tolerance, motion.bvhs(), found.tasks(), x0, x1);
    query.set_pairs(settings, step);
    if (look_ahead != nullptr) {
      look_ahead->test(step, pipeline, out);
    } else {
      test_leaf_pairs(step, found.leaf_pairs(), pipeline.narrow, out);
    }
    finish(settings, out);
    return {};
  };
  FOLDPROOF_TRY(run_stages(out.milliseconds, update, search, narrow));
  if (cuts_time) FOLDPROOF_TRY(check_in_stretches(query, x0, x1, settings, out));
  if (settings.explain) pipeline.explain(out.explanation);
  out.complete = true;
  return {};
}

}  // namespace foldproof::internal
