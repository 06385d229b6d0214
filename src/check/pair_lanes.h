/// Feeds the eight lanes of a ConservativeAdvancement.
#pragma once

#include <atomic>

#include "ccd/conservative_advancement.h"

namespace foldproof::inline internal {

/// Tests pairs of one kind, eight at a time. Each pair has a payload, which is passed to `report` with the
/// pair's result, in any order.
template <class Payload, class Report>
class PairLanes {
 public:
  /// `latest`: contacts after this time do not matter; it may decrease during the tests. Null: as in the
  /// settings.
  PairLanes(bool edge_edge, const CcdSettings& settings, const std::atomic<double>* latest, Report report,
            const PairSettings& pairs = {})
      : advancement_(edge_edge, settings, pairs),
        settings_latest_(settings.latest),
        latest_(latest),
        report_(report) {}

  /// Sets a point, at both ends of the step, of the pair that is added next.
  void set_point(int point, const double* x0, const double* x1) { batch_.set(count_, point, x0, x1); }
  void add(const Payload& payload) {
    batch_payloads_[count_] = payload;
    if (++count_ == 8) start();
  }
  void finish() {
    if (count_ > 0) start();
    while (advancement_.busy()) iterate();
  }

 private:
  void start() {
    const unsigned unproven = advancement_.load(batch_, count_);
    for (int k = 0; k < count_; ++k) {
      if ((unproven >> k & 1) == 0) {
        report_(batch_payloads_[k], CcdResult{});
        continue;
      }
      while (advancement_.full()) iterate();
      lane_payloads_[advancement_.start(k, latest())] = batch_payloads_[k];
    }
    count_ = 0;
  }

  void iterate() {
    for (unsigned done = advancement_.iterate(); done != 0; done &= done - 1) {
      const int lane = __builtin_ctz(done);
      report_(lane_payloads_[lane], advancement_.result(lane));
    }
  }

  double latest() const {
    return latest_ != nullptr ? latest_->load(std::memory_order_relaxed) : settings_latest_;
  }

  ConservativeAdvancement advancement_;
  PairBatch batch_{};
  int count_ = 0;
  std::array<Payload, 8> batch_payloads_, lane_payloads_;
  double settings_latest_;
  const std::atomic<double>* latest_;
  Report report_;
};

}  // namespace foldproof::inline internal
