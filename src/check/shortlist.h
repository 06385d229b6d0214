/// The first of many.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

namespace foldproof {

/// Adds to a list, and keeps of what is added no more than the `limit` smallest, and a share on top of that.
/// What stays does not depend on the order of adding. From when the list has `limit` elements, number limit -
/// 1 is the largest of those before it.
template <class T, class Less>
class Shortlist {
 public:
  Shortlist(std::vector<T>& list, std::uint64_t limit, Less less) : list_(list), limit_(limit), less_(less) {}

  /// False when it is none of the smallest; nor is anything larger, then.
  bool add(const T& element) {
    if (list_.size() >= limit_ && (limit_ == 0 || !less_(element, list_[limit_ - 1]))) return false;
    if (list_.size() == list_.capacity()) grow();
    list_.push_back(element);
    if (list_.size() == limit_ || (list_.size() > limit_ && list_.size() - limit_ >= spare())) cut();
    return true;
  }

  /// Ascending, and no longer than the limit.
  void finish() {
    if (list_.size() > limit_) cut();
    std::sort(list_.begin(), list_.end(), less_);
  }

 private:
  std::uint64_t spare() const { return limit_ / 4 + 1024; }
  // Doubles, but not beyond what it will ever hold.
  void grow() {
    const std::uint64_t twice = 2 * std::uint64_t{list_.size()} + 16;
    list_.reserve(twice > limit_ && twice - limit_ > spare() && list_.size() < limit_ + spare()
                      ? limit_ + spare()
                      : twice);
  }
  void cut() {
    if (limit_ > 0) {
      std::nth_element(list_.begin(), list_.begin() + static_cast<std::ptrdiff_t>(limit_ - 1), list_.end(),
                       less_);
    }
    list_.resize(limit_);
  }

  std::vector<T>& list_;
  std::uint64_t limit_;
  Less less_;
};

}  // namespace foldproof
