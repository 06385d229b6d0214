/// Motions that are shared with Python.
#pragma once

#include <pybind11/pybind11.h>

#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "report/report.h"

namespace foldproof::python {

/// A motion with shared ownership that several threads may read.
class SharedMotion final : public Motion {
 public:
  explicit SharedMotion(std::unique_ptr<Motion> motion, const ReadOptions& read = {},
                        std::vector<std::string> paths = {})
      : state_(std::make_shared<State>(std::move(motion), read, std::move(paths))) {}

  /// How its files were read.
  const ReadOptions& read() const { return state_->read; }
  /// Absolute, as they were given to open_motions; frames may be read from them as long as this lives.
  const std::vector<std::string>& paths() const { return state_->paths; }

  const std::string& name() const override { return state_->motion->name(); }
  const Topology& topology() const override { return state_->motion->topology(); }
  const MotionInfo& info() const override { return state_->motion->info(); }
  Index frame_count() const override { return state_->motion->frame_count(); }
  Result<void> read_frame(Index k, std::span<double> out) override {
    const std::lock_guard lock(state_->mutex);
    return state_->motion->read_frame(k, out);
  }

 private:
  struct State {
    State(std::unique_ptr<Motion> m, const ReadOptions& options, std::vector<std::string> files)
        : motion(std::move(m)), read(options), paths(std::move(files)) {}
    std::unique_ptr<Motion> motion;
    ReadOptions read;
    std::vector<std::string> paths;
    std::mutex mutex;
  };
  std::shared_ptr<State> state_;
};

/// One motion, or several in a list or tuple; each is a SharedMotion.
std::vector<std::unique_ptr<Motion>> motions_of(const pybind11::handle& motions);

/// None, a slice, an int, or text as the program reads it ("A:B:STEP").
FrameRange frames_of(const pybind11::handle& frames);

}  // namespace foldproof::python
