/// A sweep by several processes that mpirun started: rank 0 hands out motions and writes, the others check.
#pragma once

#include <atomic>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include "sweep/sweep.h"

namespace foldproof {

/// Motions to be checked, and where their lines go.
struct SweepTask {
  const std::vector<SweepMotion>& motions;
  std::vector<std::size_t> todo;  ///< Numbers of `motions`.
  const SweepSettings& settings;
  std::function<Result<void>(std::size_t motion, const std::string& line)> done;
  /// Called now and then with what is being checked: numbers of `motions`, and the share that is done of
  /// each.
  std::function<void(std::span<const std::pair<std::size_t, double>>)> progress;
  const std::atomic<bool>* cancel = nullptr;
};

/// This process among those that mpirun started. One that is alone has no use for what follows `here`.
class Ranks {
 public:
  /// Error, in rank 0 only: there are several, but they cannot work together.
  static Result<Ranks> join(double patience);

  bool alone() const { return count_ == 1; }
  bool leads() const { return rank_ == 0; }
  /// Nothing to do here, and nothing to say: rank 0 says what is wrong.
  bool superfluous() const { return superfluous_; }
  /// How many processes share this machine.
  int here() const { return here_; }

  /// Rank 0: has motions checked until all are done. False: cancelled. Error: one from `done`, or no rank is
  /// left.
  Result<bool> hand_out(const SweepTask& task);
  /// Rank 0, in any case: sends the others home.
  void dismiss();
  /// The others: check what they are given until they are sent home.
  int work(const std::function<Result<SweepSettings>()>& load, const std::atomic<bool>& interrupted);

 private:
  int rank_ = 0, count_ = 1, here_ = 1;
  bool superfluous_ = false;
  std::set<int> lost_;    ///< Ranks that were lost and not heard of since.
  double patience_ = 30;  ///< Seconds.
};

}  // namespace foldproof
