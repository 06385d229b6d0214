/// Which frames of a motion are checked.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "foldproof/base.h"

namespace foldproof {

/// Selects frames like a Python slice: `begin` is included, `end` is not, negative values count from the end,
/// and values beyond the motion are clamped.
struct FrameRange {
  std::optional<std::int64_t> begin, end;
  Index step = 1;  ///< At least 1.
  bool selects_all() const { return step == 1 && begin.value_or(0) == 0 && !end; }
};

/// Parses "A:B" or "A:B:STEP", where each part may be omitted, or a single frame "A". Error: anything else.
Result<FrameRange> parse_frame_range(const std::string& text);

/// "every 2nd frame".
std::string every_nth_frame(Index n);

/// The selected frames, ascending. Empty when the range selects none.
std::vector<Index> select_frames(const FrameRange& range, Index frame_count);

}  // namespace foldproof
