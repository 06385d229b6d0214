/// A stand-in for the parts of oneTBB that foldproof uses, for the thread sanitizer only.
///
/// Debian's libtbb is not built for the sanitizer, which therefore does not see how TBB hands work from
/// thread to thread, and calls every task a data race. Suppressing that would hide races in our own tasks as
/// well, since TBB is on every stack. Here the same loops run on plain threads that the sanitizer knows, and
/// nothing is suppressed.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <thread>
#include <vector>

#include "tbb/global_control.h"

namespace tbb {

template <class Value>
class blocked_range {
 public:
  blocked_range(Value begin, Value end, std::size_t grain = 1) : begin_(begin), end_(end), grain_(grain) {}
  Value begin() const { return begin_; }
  Value end() const { return end_; }
  std::size_t size() const { return static_cast<std::size_t>(end_ - begin_); }
  std::size_t grainsize() const { return grain_; }

 private:
  Value begin_, end_;
  std::size_t grain_;
};

/// Pieces of a grain each, taken in turn by several threads, of which the caller is one.
template <class Value, class Body>
void parallel_for(const blocked_range<Value>& range, const Body& body) {
  std::atomic<std::size_t> next = 0;
  const std::size_t size = range.size();
  const auto work = [&] {
    for (std::size_t at; (at = next.fetch_add(range.grainsize())) < size;) {
      const std::size_t end = std::min(size, at + range.grainsize());
      body(blocked_range<Value>(range.begin() + at, range.begin() + end, range.grainsize()));
    }
  };
  const std::size_t pieces = (size + range.grainsize() - 1) / range.grainsize();
  std::vector<std::thread> helpers;
  for (std::size_t k = 1; k < std::min(pieces, global_control::threads()); ++k) helpers.emplace_back(work);
  work();
  for (std::thread& helper : helpers) helper.join();
}

template <class Value, class Body>
void parallel_for(Value begin, Value end, const Body& body) {
  parallel_for(blocked_range<Value>(begin, end), [&](const blocked_range<Value>& range) {
    for (Value k = range.begin(); k < range.end(); ++k) body(k);
  });
}

}  // namespace tbb
