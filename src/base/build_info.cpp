#include <fmt/format.h>
#include <hwy/targets.h>

#include <string_view>

#include "base/parallel.h"
#include "foldproof/base.h"

namespace foldproof {
namespace {

std::string compiler() {
#if defined(__clang__)
  return fmt::format("Clang {}.{}.{}", __clang_major__, __clang_minor__, __clang_patchlevel__);
#elif defined(__GNUC__)
  return fmt::format("GCC {}.{}.{}", __GNUC__, __GNUC_MINOR__, __GNUC_PATCHLEVEL__);
#else
  return "an unknown compiler";
#endif
}

std::string threads() {
#if defined(FOLDPROOF_THREADS_TBB)
  const char* const by = "oneTBB";
#elif defined(FOLDPROOF_THREADS_STD)
  const char* const by = "std::thread";
#else
  const char* const by = "none";
#endif
  return fmt::format("threads {} ({})", by, thread_count());
}

/// Of those that the library has code for and this machine runs, the best, which Highway takes.
std::string instruction_set() {
  const std::int64_t both = HWY_SUPPORTED_TARGETS & HWY_TARGETS;
  const std::string_view name = hwy::TargetName(both & -both);
  return name.starts_with("AVX3") ? "AVX-512" : std::string(name);
}

}  // namespace

std::string build_info() { return fmt::format("{}, {}, {}", compiler(), threads(), instruction_set()); }

}  // namespace foldproof
