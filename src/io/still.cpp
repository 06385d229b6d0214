// Motions of a single frame that stand still beside others.
#include "base/try.h"
#include "io/readers.h"

namespace foldproof::io {
namespace {

class StillMotion final : public Motion {
 public:
  StillMotion(std::unique_ptr<Motion> pose, Index frames)
      : pose_(std::move(pose)), info_(pose_->info()), frames_(frames) {
    info_.still = true;
  }

  const std::string& name() const override { return pose_->name(); }
  const Topology& topology() const override { return pose_->topology(); }
  const MotionInfo& info() const override { return info_; }
  Index frame_count() const override { return frames_; }
  Result<void> read_frame(Index k, std::span<double> out) override {
    FOLDPROOF_TRY(check_request(*this, k, out));
    return pose_->read_frame(0, out);
  }

 private:
  std::unique_ptr<Motion> pose_;
  MotionInfo info_;
  Index frames_;
};

}  // namespace

void stand_still(std::span<std::unique_ptr<Motion>> motions) {
  Index frames = 1;
  for (const auto& motion : motions) frames = std::max(frames, motion->frame_count());
  for (auto& motion : motions) {
    if (frames > 1 && motion->frame_count() == 1)
      motion = std::make_unique<StillMotion>(std::move(motion), frames);
  }
}

}  // namespace foldproof::io
