#include <algorithm>

#include "sweep/sweep.h"

namespace foldproof {

SweepQueue::SweepQueue(std::span<const SweepMotion> motions, std::vector<std::size_t> todo) {
  // A large one that comes last would keep one worker busy while the others wait.
  std::stable_sort(todo.begin(), todo.end(),
                   [&](std::size_t a, std::size_t b) { return motions[a].bytes > motions[b].bytes; });
  for (const std::size_t motion : todo) open_[motion] = 0;
  waiting_.assign(todo.begin(), todo.end());
}

std::optional<std::size_t> SweepQueue::take(int worker) {
  while (!waiting_.empty()) {
    const std::size_t motion = waiting_.front();
    waiting_.pop_front();
    // A worker that was taken for lost may have answered in the meantime.
    if (!open_.contains(motion)) continue;
    taken_[worker] = motion;
    return motion;
  }
  return std::nullopt;
}

bool SweepQueue::finish(int worker, std::size_t motion) {
  const auto taken = taken_.find(worker);
  if (taken != taken_.end() && taken->second == motion) taken_.erase(taken);
  return open_.erase(motion) == 1;
}

std::optional<std::size_t> SweepQueue::lose(int worker) {
  const auto taken = taken_.find(worker);
  if (taken == taken_.end()) return std::nullopt;
  const std::size_t motion = taken->second;
  taken_.erase(taken);
  const auto open = open_.find(motion);
  if (open == open_.end()) return std::nullopt;
  // What brings down two workers (it may take all their memory) would bring down the rest one by one.
  if (++open->second < 2) {
    waiting_.push_front(motion);
    return std::nullopt;
  }
  open_.erase(open);
  return motion;
}

}  // namespace foldproof
