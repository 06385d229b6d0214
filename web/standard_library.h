/// What the library uses of C++20's standard library and Debian's Emscripten does not have. Every source of
/// the WebAssembly build includes it first.
#pragma once

#include <type_traits>
#include <version>

#include <range/v3/algorithm/adjacent_find.hpp>
#include <range/v3/algorithm/all_of.hpp>
#include <range/v3/algorithm/any_of.hpp>
#include <range/v3/algorithm/binary_search.hpp>
#include <range/v3/algorithm/copy.hpp>
#include <range/v3/algorithm/count_if.hpp>
#include <range/v3/algorithm/find.hpp>
#include <range/v3/algorithm/find_if.hpp>
#include <range/v3/algorithm/lower_bound.hpp>
#include <range/v3/algorithm/max_element.hpp>
#include <range/v3/algorithm/min_element.hpp>
#include <range/v3/algorithm/minmax_element.hpp>
#include <range/v3/algorithm/mismatch.hpp>
#include <range/v3/algorithm/none_of.hpp>
#include <range/v3/algorithm/sort.hpp>
#include <range/v3/algorithm/stable_sort.hpp>
#include <range/v3/algorithm/transform.hpp>

#if defined(__cpp_lib_bit_cast) || defined(__cpp_lib_ranges)
#error "this standard library has more than that of Emscripten 3.1.6: remove from this header what it has"
#endif

namespace std {

template <class To, class From>
constexpr To bit_cast(const From& from) noexcept {
  return __builtin_bit_cast(To, from);
}

namespace ranges {
using ::ranges::adjacent_find;
using ::ranges::all_of;
using ::ranges::any_of;
using ::ranges::binary_search;
using ::ranges::copy;
using ::ranges::count_if;
using ::ranges::find;
using ::ranges::find_if;
using ::ranges::lower_bound;
using ::ranges::max_element;
using ::ranges::min_element;
using ::ranges::minmax_element;
using ::ranges::mismatch;
using ::ranges::none_of;
using ::ranges::sort;
using ::ranges::stable_sort;
using ::ranges::transform;
}  // namespace ranges

}  // namespace std
