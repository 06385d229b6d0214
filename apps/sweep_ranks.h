/// A sweep by several processes that mpirun started: rank 0 distributes motions and writes results, the
/// others check.
#pragma once

#include <atomic>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include "sweep/sweep.h"

namespace foldproof {

/// Motions to check, and the receiver of their lines.
struct SweepTask {
  const std::vector<SweepMotion>& motions;
  std::vector<std::size_t> todo;  ///< Indices of `motions`.
  const SweepSettings& settings;
  std::function<Result<void>(std::size_t motion, const std::string& line)> done;
  /// Called regularly with the motions being checked: indices of `motions`, and the finished share of each.
  std::function<void(std::span<const std::pair<std::size_t, double>>)> progress;
  const std::atomic<bool>* cancel = nullptr;
};

/// This process among those that mpirun started.
class Ranks {
 public:
  /// Error: there are several processes, but they cannot communicate. Each says so, as a lone process that
  /// inherited a launcher's environment must not seem to have checked something.
  static Result<Ranks> join(double timeout);

  bool alone() const { return count_ == 1; }
  bool leads() const { return rank_ == 0; }
  /// Number of processes on this machine.
  int local_count() const { return local_count_; }

  /// In rank 0 of several: distributes motions until all are done. False: cancelled. Error: one from `done`,
  /// or all other ranks are lost.
  Result<bool> distribute(const SweepTask& task);
  /// In rank 0, whatever happened: tells the others, if any, to exit.
  void dismiss();
  /// In the others: checks assigned motions until dismissed.
  int work(const std::function<Result<SweepSettings>()>& load, const std::atomic<bool>& interrupted);

 private:
  int rank_ = 0, count_ = 1, local_count_ = 1;
  std::set<int> lost_;   ///< Ranks that stopped responding.
  double timeout_ = 30;  ///< Seconds.
};

}  // namespace foldproof
