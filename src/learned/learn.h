/// How a model learns.
#pragma once

#include <atomic>
#include <functional>

#include "certificate/library.h"
#include "foldproof/learned.h"

namespace foldproof::inline internal {

struct LearnHooks {
  std::function<void(double)> progress = {};  ///< Called with the share of the work that is done.
  const std::atomic<bool>* cancel = nullptr;  ///< Polled; true ends learning with an error.
};

/// What is learned from.
struct LearnInput {
  std::vector<Index> poses;  ///< Indices into Model::poses, ascending; at least 3.
  Eigen::MatrixXd samples;   ///< Their positions, by the user's vertex ids, a column each.
  std::vector<Index> nodes;  ///< From predictable_nodes.
  Eigen::MatrixXd margins;   ///< Of these nodes, a column per pose.
};

/// The same input gives the same result for any number of threads. Memory: about four times the samples.
/// Error: all poses are equal, a number is not finite, a setting is out of range, cancelled.
Result<Learned> learn(const Hierarchy& hierarchy, const LearnInput& input, const LearnSettings& settings,
                      const LearnHooks& hooks = {});

/// Nodes whose margins are predicted: those with a chart, by whole levels from the root down. Ascending.
std::vector<Index> predictable_nodes(const ChartLibrary& charts, Index max_count = 2048);

/// Computes margins. One per thread; runs in the caller's oneTBB arena.
class MarginMeter {
 public:
  explicit MarginMeter(std::shared_ptr<const ChartLibrary> charts);
  ~MarginMeter();
  MarginMeter(MarginMeter&&) noexcept;
  /// The margin of each node in a pose; -1 without a chart. `positions`: by the user's vertex ids, finite.
  Eigen::VectorXd measure(std::span<const Index> nodes, std::span<const double> positions);

 private:
  struct Scratch;
  std::unique_ptr<Scratch> scratch_;
};

}  // namespace foldproof::inline internal
