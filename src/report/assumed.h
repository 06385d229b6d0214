/// What a verdict assumes of files.
#pragma once

#include "report/report.h"

namespace foldproof {

/// What motions were taken for (MotionInfo::taken_as), to follow "no collisions" or "all 9 steps" in a
/// verdict: " between 3 frames of one mesh", " in clip 'Run'"; of several motions, " (run.glb: clip 'Run')".
/// Empty: for nothing else than they are. `poses`: that frames are frames goes without saying.
std::string assumed(Motions motions, bool poses);

}  // namespace foldproof
