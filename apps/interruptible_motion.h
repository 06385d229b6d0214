/// Writing a motion until Ctrl-C.
#pragma once

#include <atomic>

#include "foldproof/io.h"

namespace foldproof {

/// A motion whose frames fail to read once the program is interrupted, so that writing it ends.
class InterruptibleMotion final : public Motion {
 public:
  InterruptibleMotion(Motion& motion, const std::atomic<bool>& interrupted)
      : motion_(motion), interrupted_(interrupted) {}
  const std::string& name() const override { return motion_.name(); }
  const Topology& topology() const override { return motion_.topology(); }
  const MotionInfo& info() const override { return motion_.info(); }
  Index frame_count() const override { return motion_.frame_count(); }
  Result<void> read_frame(Index k, std::span<double> out) override {
    if (interrupted_) {
      return fail(ErrorCode::Interrupted, "interrupted", "the motion was not finished", "run it again");
    }
    return motion_.read_frame(k, out);
  }

 private:
  Motion& motion_;
  const std::atomic<bool>& interrupted_;
};

}  // namespace foldproof
