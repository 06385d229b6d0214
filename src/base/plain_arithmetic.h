/// The floating-point mode that every proof assumes: rounding to nearest, denormals kept, no traps
/// (docs/soundness.md, "Arithmetic"). A program may run its threads in another mode; linking with -ffast-math
/// sets one before main().
#pragma once

#if defined(__SSE2__)
#include <immintrin.h>
#else
#include <cfenv>
#endif

namespace foldproof::inline internal {

#if defined(__MINGW32__)
/// MinGW's mathematical functions (nearbyint, log, exp, ldexp) compute in the x87 unit, which has a mode of
/// its own. Scope guard: as PlainArithmetic, for that unit.
class PlainX87 {
 public:
  PlainX87() {
    asm volatile("fnstcw %0" : "=m"(before_));
    if (before_ != kPlain) set(kPlain);
  }
  ~PlainX87() {
    if (before_ != kPlain) set(before_);
  }
  PlainX87(const PlainX87&) = delete;
  PlainX87& operator=(const PlainX87&) = delete;

 private:
  using ControlWord = unsigned short;
  static constexpr ControlWord kPlain = 0x37f;  // to nearest, 64 bits, no traps: as MinGW's programs start
  static void set(ControlWord mode) { asm volatile("fldcw %0" : : "m"(mode)); }
  ControlWord before_;
};
#endif

/// Scope guard: sets the mode for this thread and restores the previous one. Every function that users of the
/// library call holds one, and so does every task of another thread (base/parallel.h). Costs a few
/// nanoseconds.
class PlainArithmetic {
 public:
#if defined(__SSE2__)
  PlainArithmetic() : before_(_mm_getcsr()), changes_mode_((before_ & ~kRaised) != kPlain) {
    if (changes_mode_) _mm_setcsr(kPlain);
  }
  ~PlainArithmetic() {
    if (changes_mode_) _mm_setcsr(before_);
  }
#else
  PlainArithmetic() {
    std::fegetenv(&before_);
    std::fesetenv(FE_DFL_ENV);
  }
  ~PlainArithmetic() { std::fesetenv(&before_); }
#endif
  PlainArithmetic(const PlainArithmetic&) = delete;
  PlainArithmetic& operator=(const PlainArithmetic&) = delete;

 private:
#if defined(__SSE2__)
  // Bits of MXCSR: the exception flags, and the mode in which a program starts.
  static constexpr unsigned kRaised = 0x3f, kPlain = 0x1f80;
  unsigned before_;
  bool changes_mode_;
#if defined(__MINGW32__)
  PlainX87 x87_;
#endif
#else
  std::fenv_t before_;
#endif
};

}  // namespace foldproof::inline internal
