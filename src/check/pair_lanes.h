/// Feeds the eight lanes of a march.
#pragma once

#include <atomic>

#include "ccd/march.h"

namespace foldproof {

/// Follows pairs of one kind through a step, eight at a time, the first test for eight at once before. Each
/// carries something of the caller's, which is handed to `note` with its result, in no certain order.
template <class Carried, class Note>
class PairLanes {
 public:
  /// `latest`: a time that may fall while pairs are followed, none of which matter beyond it; null: as the
  /// settings have it.
  PairLanes(bool edge_edge, const CcdSettings& settings, const std::atomic<double>* latest, Note note)
      : march_(edge_edge, settings), settings_latest_(settings.latest), latest_(latest), note_(note) {}

  /// A point of the pair that is added next, at both ends.
  void set_point(int point, const double* x0, const double* x1) { batch_.set(count_, point, x0, x1); }
  void add(const Carried& carried) {
    carried_[count_] = carried;
    if (++count_ == 8) start();
  }
  void finish() {
    if (count_ > 0) start();
    while (march_.busy()) look();
  }

 private:
  void start() {
    const unsigned left = march_.take(batch_, count_);
    for (int k = 0; k < count_; ++k) {
      if ((left >> k & 1) == 0) {
        note_(carried_[k], CcdResult{});
        continue;
      }
      while (march_.full()) look();
      followed_[march_.start(k, latest())] = carried_[k];
    }
    count_ = 0;
  }

  void look() {
    for (unsigned done = march_.look(); done != 0; done &= done - 1) {
      const int lane = __builtin_ctz(done);
      note_(followed_[lane], march_.result(lane));
    }
  }

  double latest() const {
    return latest_ != nullptr ? latest_->load(std::memory_order_relaxed) : settings_latest_;
  }

  March march_;
  PairBatch batch_{};
  int count_ = 0;
  std::array<Carried, 8> carried_, followed_;  // of the batch; per lane of the march
  double settings_latest_;
  const std::atomic<double>* latest_;
  Note note_;
};

}  // namespace foldproof
