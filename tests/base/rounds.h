/// How many random cases a test takes.
#pragma once

namespace foldproof::testing {

// Defined by GCC, which the presets with sanitizers compile with.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr int kShare = 8;
#else
inline constexpr int kShare = 1;
#endif

/// `all`, or an eighth of it under a sanitizer, which takes ten times as long and sees the same code.
constexpr int rounds(int all) { return (all + kShare - 1) / kShare; }

}  // namespace foldproof::testing
