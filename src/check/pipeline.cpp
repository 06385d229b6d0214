#include "check/pipeline.h"

#include "base/try.h"

namespace foldproof::internal {

Result<void> Pipeline::find_leaf_pairs(const StepSettings& settings, double distance, Work& work) {
  FOLDPROOF_TRY(culling.begin_step(motion, settings, distance));
  broad_phase.find(motion, culling, filter, settings, distance, work);
  motion.fill_features(broad_phase.tasks(), broad_phase.leaf_pairs());
  return {};
}

void Pipeline::explain(const StepSettings& settings, double distance, Explanation& out) {
  culling.explain(motion, broad_phase.tasks(), broad_phase.leaf_pairs(), out);
  if (!settings.certificates) return;  // no pair is certified
  out.leaf_pairs[static_cast<std::size_t>(Reason::Certified)] =
      broad_phase.count_near_leaves(motion, filter, settings, distance) - broad_phase.leaf_pairs().size();
}

}  // namespace foldproof::internal
