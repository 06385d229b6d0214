#include "check/step.h"

#include "base/plain_arithmetic.h"
#include "base/stopwatch.h"
#include "base/try.h"
#include "check/answer.h"

namespace foldproof::internal {

Result<void> check_step(const Query& query, Positions x0, Positions x1, const StepSettings& settings,
                        StepResult& out) {
  const PlainArithmetic plain;
  Pipeline& pipeline = query.pipeline;
  LookAhead* const look_ahead = query.look_ahead;
  Stopwatch total, watch;
  clear(out);
  FOLDPROOF_TRY(check_settings(settings, pipeline.motion.size()));

  // Motion: reads and validates positions, refits.
  StepMotion& motion = pipeline.motion;
  const LookAhead::Plan plan =
      look_ahead != nullptr ? look_ahead->plan(motion, x0, x1, settings) : LookAhead::Plan{};
  const bool cache_hit = plan.is_cache_hit();
  FOLDPROOF_TRY(cache_hit ? motion.check_isolated_vertices(x0, x1) : motion.update(x0, x1, plan.steps));
  out.work.refits = cache_hit ? 0 : motion.size();
  out.search_steps = cache_hit ? 0 : motion.steps();
  out.tolerance = tolerance_for(settings, cache_hit ? plan.extent : motion.step_extent());
  const double distance = settings.thickness + out.tolerance;
  out.milliseconds.update = watch.lap();

  // Broad phase and culling: finds pairs of leaves.
  if (!cache_hit) {
    FOLDPROOF_TRY(look_ahead != nullptr ? look_ahead->search(pipeline, settings, distance, out.work)
                                        : pipeline.find_leaf_pairs(settings, distance, out.work));
  }
  out.milliseconds.traverse = watch.lap();

  // Narrow phase: finds which of their features collide.
  const BroadPhase& found = pipeline.broad_phase;
  NarrowStep narrow(settings, out.tolerance, motion.bvhs(), found.tasks(), x0, x1);
  narrow.filter = pipeline.filter;
  if (look_ahead != nullptr) {
    look_ahead->test(narrow, pipeline, out);
  } else {
    test_leaf_pairs(narrow, found.leaf_pairs(), pipeline.narrow, out);
  }
  finish(settings, out);
  out.milliseconds.narrow = watch.lap();
  out.milliseconds.total = total.lap();
  if (settings.explain) {
    pipeline.explain(settings, distance, out.explanation);
    explain_copies(pipeline.filter.distinct, out.explanation);
  }
  out.complete = true;
  return {};
}

}  // namespace foldproof::internal
