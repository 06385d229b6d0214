/// What a verdict assumes of files.
#pragma once

#include "report/report.h"

namespace foldproof {

/// What motions were taken for (MotionInfo::taken_as), to follow "no collisions" or "all 9 steps" in a
/// verdict: " between 3 frames of one mesh", " in clip 'Run'"; of several motions, " (run.glb: clip 'Run')".
/// Empty: for nothing else than they are. `poses`: that frames are frames goes without saying.
/// `preposition`: instead of "between" and "in".
std::string assumed(Motions motions, bool poses, const char* preposition = nullptr);

}  // namespace foldproof
