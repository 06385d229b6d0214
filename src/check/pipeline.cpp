#include "check/pipeline.h"

#include "check/answer.h"

namespace foldproof::internal {

Result<void> Pipeline::find_leaf_pairs(const StepSettings& settings, double distance, Work& work) {
  settings_ = settings;
  distance_ = distance;
  FOLDPROOF_TRY(culling.begin_step(motion, settings, distance));
  broad_phase.find(motion, culling, filter, settings, distance, work);
  motion.fill_features(broad_phase.tasks(), broad_phase.leaf_pairs());
  return {};
}

void Pipeline::explain(Explanation& out) {
  if (!settings_.explain) return;
  culling.explain(motion, broad_phase.tasks(), broad_phase.leaf_pairs(), out);
  if (settings_.certificates)
    out.leaf_pairs[static_cast<std::size_t>(Reason::Certified)] =
        broad_phase.count_near_leaves(motion, culling, filter, settings_, distance_) -
        broad_phase.leaf_pairs().size();
  explain_copies(filter.distinct, out);
}

}  // namespace foldproof::internal
