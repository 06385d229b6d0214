// A motion whose frames are in memory.
#include <algorithm>
#include <cassert>

#include "base/try.h"
#include "io/readers.h"

namespace foldproof {
namespace {

class MemoryMotion final : public Motion {
 public:
  MemoryMotion(std::string name, Topology topology, std::vector<std::vector<double>> frames)
      : name_(std::move(name)), topology_(std::move(topology)), frames_(std::move(frames)) {
    const std::size_t loose = io::loose_vertices(topology_, {}).size();
    if (loose > 0) info_.unchecked.push_back(io::unchecked_vertices(topology_, loose));
  }

  const std::string& name() const override { return name_; }
  const Topology& topology() const override { return topology_; }
  const MotionInfo& info() const override { return info_; }
  Index frame_count() const override { return static_cast<Index>(frames_.size()); }

  Result<void> read_frame(Index k, std::span<double> out) override {
    FOLDPROOF_TRY(io::check_request(*this, k, out));
    if (frames_[k].size() != out.size()) {
      return fail(
          ErrorCode::InvalidArgument, name_ + ", frame " + std::to_string(k),
          "holds " + std::to_string(frames_[k].size()) + " numbers instead of " + std::to_string(out.size()),
          "give every frame vertex_count x 3 numbers");
    }
    FOLDPROOF_TRY(io::check_finite(name_ + ", frame " + std::to_string(k), frames_[k]));
    std::copy(frames_[k].begin(), frames_[k].end(), out.begin());
    return {};
  }

 private:
  std::string name_;
  Topology topology_;
  MotionInfo info_;
  std::vector<std::vector<double>> frames_;
};

}  // namespace

std::unique_ptr<Motion> memory_motion(std::string name, Topology topology,
                                      std::vector<std::vector<double>> frames) {
  assert(!frames.empty());
  return std::make_unique<MemoryMotion>(std::move(name), std::move(topology), std::move(frames));
}

}  // namespace foldproof
