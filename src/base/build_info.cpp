#include <fmt/format.h>

#include <string_view>

#undef HWY_TARGET_INCLUDE  // Highway compiles this file once per instruction set
#define HWY_TARGET_INCLUDE "base/build_info.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "base/parallel.h"
#include "foldproof/base.h"

HWY_BEFORE_NAMESPACE();
namespace foldproof::HWY_NAMESPACE {

const char* InstructionSet() { return hwy::TargetName(HWY_TARGET); }

}  // namespace foldproof::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace foldproof {

HWY_EXPORT(InstructionSet);

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

std::string instruction_set() {
  const std::string_view name = HWY_DYNAMIC_DISPATCH(InstructionSet)();
  return name.starts_with("AVX3") ? "AVX-512" : std::string(name);
}

}  // namespace

std::string build_info() { return fmt::format("{}, {}, {}", compiler(), threads(), instruction_set()); }

}  // namespace foldproof
#endif
