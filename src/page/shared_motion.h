/// Motions that a check reads while requests ask for their frames.
#pragma once

#include <list>
#include <mutex>

#include "foldproof/io.h"

namespace foldproof {

/// One reader at a time, and the frames that requests asked for last.
class SharedMotion final : public Motion {
 public:
  explicit SharedMotion(std::unique_ptr<Motion> motion) : motion_(std::move(motion)) {}

  const std::string& name() const override { return motion_->name(); }
  const Topology& topology() const override { return motion_->topology(); }
  Index frame_count() const override { return motion_->frame_count(); }
  Result<void> read_frame(Index k, std::span<double> out) override;

  using Frame = std::shared_ptr<const std::vector<double>>;
  /// The same, kept for a while.
  Result<Frame> frame(Index k);

 private:
  std::unique_ptr<Motion> motion_;
  std::mutex mutex_;
  std::list<std::pair<Index, Frame>> recent_;  // the last asked for first
};

}  // namespace foldproof
