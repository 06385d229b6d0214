#include "page/shared_motion.h"

#include <algorithm>

#include "base/try.h"

namespace foldproof {
namespace {

// A step needs two frames, and several requests use the same frame: positions, boxes, prediction.
constexpr std::size_t kRecentFrames = 4;

}  // namespace

Result<void> SharedMotion::read_frame(Index k, std::span<double> out) {
  const std::lock_guard lock(mutex_);
  return motion_->read_frame(k, out);
}

Result<SharedMotion::Frame> SharedMotion::frame(Index k) {
  const std::lock_guard lock(mutex_);
  const auto found =
      std::find_if(recent_.begin(), recent_.end(), [&](const auto& f) { return f.first == k; });
  if (found != recent_.end()) {
    recent_.splice(recent_.begin(), recent_, found);
    return found->second;
  }
  std::vector<double> x(3 * std::size_t{topology().vertex_count()});
  FOLDPROOF_TRY(motion_->read_frame(k, x));
  recent_.emplace_front(k, std::make_shared<const std::vector<double>>(std::move(x)));
  if (recent_.size() > kRecentFrames) recent_.pop_back();
  return recent_.front().second;
}

}  // namespace foldproof
