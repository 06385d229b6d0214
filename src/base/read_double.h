/// std::from_chars of a double, where the standard library has it or not.
#pragma once

#include <charconv>

#if !defined(__cpp_lib_to_chars)  // libc++, for one
#if !__has_include(<fast_float/fast_float.h>)
#error "this standard library reads no double by std::from_chars: install the headers of fast_float"
#endif
#include <fast_float/fast_float.h>
#endif

namespace foldproof::inline internal {

/// As std::from_chars; `value` is of use only if there is no error.
inline std::from_chars_result read_double(const char* begin, const char* end, double& value) {
#if defined(__cpp_lib_to_chars)
  return std::from_chars(begin, end, value);
#else
  const auto [stop, status] = fast_float::from_chars(begin, end, value);
  return {stop, status};
#endif
}

}  // namespace foldproof::inline internal
