/// What a command is doing, while it is doing it.
#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>

namespace foldproof {

/// A line on standard error: a bar with the remaining time where the share of the work that is done is known,
/// else for how long it has been going on. If standard error is not a terminal, it is silent, or with
/// FOLDPROOF_PROGRESS in the environment writes lines such as "37% repairing, 0:20 left". A thread of its own
/// draws, so the line goes on where the work gives no sign of life. Nothing appears in the first half second.
class ProgressBar {
 public:
  explicit ProgressBar(bool enabled);
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  /// From now on, `text` is being done.
  void begin(const std::string& text);
  /// `part`: the share of the work since begin() (or since the bar was made) that is done, in (0,1]; `text`:
  /// the same in words.
  void show(double part, const std::string& text);
  /// Erases the line, so that other text can follow. It appears again with the next begin() or show().
  void clear();

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::milliseconds kDelay{500}, kPause{100}, kTick{500};

  void run();
  void draw(Clock::time_point now);

  bool lines_, enabled_;
  std::mutex mutex_;  // of all below
  std::condition_variable wake_;
  bool ends_ = false, active_ = false, shown_ = false;
  double part_ = 0;  // 0: not known
  std::string text_;
  Clock::time_point begin_ = Clock::now(), last_ = begin_ + kDelay - kPause;
  std::thread thread_;  // only if enabled
};

}  // namespace foldproof
