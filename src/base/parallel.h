/// oneTBB's loops with plain arithmetic in every task: oneTBB runs tasks in the mode that its arena was made
/// in, whatever that of their caller is (base/plain_arithmetic.h).
#pragma once

#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include "base/plain_arithmetic.h"

namespace foldproof {

/// body(i) for all i from `first` to before `last`.
template <class I, class Body>
void in_parallel(I first, I last, const Body& body) {
  tbb::parallel_for(first, last, [&](I i) {
    const PlainArithmetic plain;
    body(i);
  });
}

/// body(part) for the parts of a range.
template <class Range, class Body>
void in_parallel(const Range& range, const Body& body) {
  tbb::parallel_for(range, [&](const Range& part) {
    const PlainArithmetic plain;
    body(part);
  });
}

/// Values of parts of a range, body(part, so far), joined.
template <class Range, class Value, class Body, class Join>
Value reduce_in_parallel(const Range& range, const Value& nothing, const Body& body, const Join& join) {
  return tbb::parallel_reduce(
      range, nothing,
      [&](const Range& part, Value so_far) {
        const PlainArithmetic plain;
        return body(part, std::move(so_far));
      },
      join);
}

}  // namespace foldproof
