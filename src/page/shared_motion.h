/// Motions that the check and requests read at the same time.
#pragma once

#include <list>
#include <mutex>

#include "foldproof/io.h"

namespace foldproof {

/// Serializes reads, and caches the frames that were requested last.
class SharedMotion final : public Motion {
 public:
  explicit SharedMotion(std::unique_ptr<Motion> motion) : motion_(std::move(motion)) {}

  const std::string& name() const override { return motion_->name(); }
  const Topology& topology() const override { return motion_->topology(); }
  const MotionInfo& info() const override { return motion_->info(); }
  Index frame_count() const override { return motion_->frame_count(); }
  Result<void> read_frame(Index k, std::span<double> out) override;

  using Frame = std::shared_ptr<const std::vector<double>>;
  /// Reads a frame through the cache.
  Result<Frame> frame(Index k);

 private:
  std::unique_ptr<Motion> motion_;
  std::mutex mutex_;
  std::list<std::pair<Index, Frame>> recent_;  // most recently used first
};

}  // namespace foldproof
