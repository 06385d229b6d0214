/// Arithmetic as every proof assumes it: rounded to nearest, denormal numbers kept, nothing trapped
/// (docs/soundness.md, "Arithmetic"). A program may have set its threads otherwise; one that is linked with
/// -ffast-math does so before it begins.
#pragma once

#if defined(__SSE2__)
#include <immintrin.h>
#else
#include <cfenv>
#endif

namespace foldproof {

/// While it lives, this thread calculates plainly; afterwards as it did before. For every function that the
/// library's users call, and every task of another thread (base/parallel.h). Costs a few nanoseconds.
class PlainArithmetic {
 public:
#if defined(__SSE2__)
  PlainArithmetic() : before_(_mm_getcsr()), other_((before_ & ~kRaised) != kPlain) {
    if (other_) _mm_setcsr(kPlain);
  }
  ~PlainArithmetic() {
    if (other_) _mm_setcsr(before_);
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
  static constexpr unsigned kRaised = 0x3f, kPlain = 0x1f80;  // what has happened; how a program starts
  unsigned before_;
  bool other_;
#else
  std::fenv_t before_;
#endif
};

}  // namespace foldproof
