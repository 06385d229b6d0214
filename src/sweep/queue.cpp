#include <algorithm>

#include "sweep/sweep.h"

namespace foldproof {

SweepQueue::SweepQueue(std::span<const SweepMotion> motions, std::vector<std::size_t> todo) {
  // A large motion at the end would keep one worker busy while the others wait.
  std::stable_sort(todo.begin(), todo.end(),
                   [&](std::size_t a, std::size_t b) { return motions[a].bytes > motions[b].bytes; });
  for (const std::size_t motion : todo) unfinished_[motion] = 0;
  queue_.assign(todo.begin(), todo.end());
}

std::optional<std::size_t> SweepQueue::assign(int worker) {
  while (!queue_.empty()) {
    const std::size_t motion = queue_.front();
    queue_.pop_front();
    // A worker that was considered lost may have answered in the meantime.
    if (!unfinished_.contains(motion)) continue;
    assigned_[worker] = motion;
    return motion;
  }
  return std::nullopt;
}

bool SweepQueue::finish(int worker, std::size_t motion) {
  const auto assigned = assigned_.find(worker);
  if (assigned != assigned_.end() && assigned->second == motion) assigned_.erase(assigned);
  return unfinished_.erase(motion) == 1;
}

std::optional<std::size_t> SweepQueue::worker_lost(int worker) {
  const auto assigned = assigned_.find(worker);
  if (assigned == assigned_.end()) return std::nullopt;
  const std::size_t motion = assigned->second;
  assigned_.erase(assigned);
  const auto unfinished = unfinished_.find(motion);
  if (unfinished == unfinished_.end()) return std::nullopt;
  // A motion that two workers were lost on, for example for lack of memory, would bring down the others too.
  if (++unfinished->second < 2) {
    queue_.push_front(motion);
    return std::nullopt;
  }
  unfinished_.erase(unfinished);
  return motion;
}

}  // namespace foldproof
