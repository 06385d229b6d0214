/// Returns errors to the caller without a line for each.
#pragma once

#include <type_traits>
#include <utility>

#include "foldproof/base.h"

namespace foldproof {

template <class T>
T value_of(Result<T>&& result) {
  if constexpr (!std::is_void_v<T>) return std::move(*result);
}

}  // namespace foldproof

/// The value of an expression of type Result<T>; where that is an error, returns it from the function, which
/// gives a Result too. An expression of its own in GNU C++ (GCC and Clang).
#define FOLDPROOF_TRY(...)                                                             \
  __extension__({                                                                      \
    auto foldproof_result = (__VA_ARGS__);                                             \
    if (!foldproof_result) return tl::unexpected(std::move(foldproof_result.error())); \
    ::foldproof::value_of(std::move(foldproof_result));                                \
  })
