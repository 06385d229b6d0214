#include "check/step.h"

#include "base/plain_arithmetic.h"
#include "check/answer.h"

namespace foldproof {

Result<void> check_step(const Query& query, Positions x0, Positions x1, const StepSettings& settings,
                        StepResult& out) {
  const PlainArithmetic plain;
  Pipeline& pipeline = query.pipeline;
  LookAhead* const look_ahead = query.look_ahead;
  Stopwatch total, watch;
  clear(out);
  if (auto ok = check_settings(settings); !ok) return ok;

  // Motion: read and validate positions, refit.
  StepMotion& motion = pipeline.motion;
  const LookAhead::Plan plan =
      look_ahead != nullptr ? look_ahead->plan(motion, x0, x1, settings) : LookAhead::Plan{};
  if (auto ok = plan.is_served() ? motion.check_isolated_vertices(x0, x1) : motion.update(x0, x1, plan.steps);
      !ok)
    return ok;
  out.searched = plan.is_served() ? 0 : motion.ahead();
  out.tolerance = tolerance_for(settings, plan.is_served() ? plan.side : motion.largest_side());
  const double distance = settings.thickness + out.tolerance;
  out.milliseconds.update = watch.lap();

  // Broad phase and culling: pairs of leaves.
  if (!plan.is_served()) {
    auto ok = look_ahead != nullptr ? look_ahead->search(pipeline, x0, x1, settings, distance, out.work)
                                    : pipeline.find_leaf_pairs(x0, x1, settings, distance, out.work);
    if (!ok) return ok;
  }
  out.milliseconds.traverse = watch.lap();

  // Narrow phase: which of their features collide.
  const BroadPhase& found = pipeline.broad_phase;
  NarrowStep narrow(settings, out.tolerance, motion.trees(), found.tasks(), x0, x1);
  narrow.filter = query.filter;
  narrow.distinct = query.distinct;
  if (look_ahead != nullptr) {
    look_ahead->test(narrow, pipeline, watch, out);
  } else {
    test_leaf_pairs(narrow, found.leaf_pairs(), pipeline.chunks, watch, out);
  }
  finish(settings, out);
  out.milliseconds.narrow += watch.lap();
  out.milliseconds.total = total.lap();
  if (settings.explain) {
    pipeline.explain(settings, distance, out.explanation);
    spread(query.distinct, out.explanation);
  }
  return {};
}

}  // namespace foldproof
