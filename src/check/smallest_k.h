/// The k smallest of many elements.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

namespace foldproof::inline internal {

/// Appends to a list but keeps only the `k` smallest elements and, until finish(), some more. The result does
/// not depend on the order of adding. From when the list has k elements, element k - 1 is the largest of the
/// first k.
template <class T, class Less>
class SmallestK {
 public:
  SmallestK(std::vector<T>& list, std::uint64_t k, Less less) : list_(list), k_(k), less_(less) {}

  /// Returns false when the element is not one of the smallest; then no larger one is.
  bool add(const T& element) {
    if (list_.size() >= k_ && (k_ == 0 || !less_(element, list_[k_ - 1]))) return false;
    if (list_.size() == list_.capacity()) grow();
    list_.push_back(element);
    if (list_.size() == k_ || (list_.size() > k_ && list_.size() - k_ >= spare())) cut();
    return true;
  }

  /// Cuts the list to the k smallest and sorts it.
  void finish() {
    if (list_.size() > k_) cut();
    std::sort(list_.begin(), list_.end(), less_);
  }

 private:
  // Elements beyond k before the list is cut.
  std::uint64_t spare() const { return k_ / 4 + 1024; }
  // Doubles the capacity, but not beyond the largest size.
  void grow() {
    const std::uint64_t twice = 2 * std::uint64_t{list_.size()} + 16;
    list_.reserve(twice > k_ && twice - k_ > spare() && list_.size() < k_ + spare() ? k_ + spare() : twice);
  }
  void cut() {
    if (k_ > 0) {
      std::nth_element(list_.begin(), list_.begin() + static_cast<std::ptrdiff_t>(k_ - 1), list_.end(),
                       less_);
    }
    list_.resize(k_);
  }

  std::vector<T>& list_;
  std::uint64_t k_;
  Less less_;
};

}  // namespace foldproof::inline internal
