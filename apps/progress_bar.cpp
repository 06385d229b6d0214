#include "progress_bar.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "system/program.h"

namespace foldproof {
namespace {

std::string clock_text(double seconds) {
  const std::int64_t whole = std::llround(seconds);
  return fmt::format("{}:{:02}", whole / 60, whole % 60);
}

}  // namespace

ProgressBar::ProgressBar(bool enabled)
    : lines_(!system::is_terminal(stderr)),
      enabled_(enabled && (!lines_ || std::getenv("FOLDPROOF_PROGRESS") != nullptr)) {
  if (enabled_) thread_ = system::thread_without_signals([this] { run(); });
}

ProgressBar::~ProgressBar() {
  clear();
  if (!enabled_) return;
  {
    const std::lock_guard lock(mutex_);
    ends_ = true;
  }
  wake_.notify_one();
  thread_.join();
}

void ProgressBar::run() {
  std::unique_lock lock(mutex_);
  while (!ends_) {
    wake_.wait_for(lock, kTick);
    const Clock::time_point now = Clock::now();
    if (!ends_ && active_ && now - begin_ >= kDelay && now - last_ >= kTick) draw(now);
  }
}

void ProgressBar::begin(const std::string& text) {
  if (!enabled_) return;
  const std::lock_guard lock(mutex_);
  begin_ = Clock::now();
  last_ = begin_ + kDelay - kPause;
  part_ = 0;
  text_ = text;
  active_ = true;
}

void ProgressBar::show(double part, const std::string& text) {
  if (!enabled_) return;
  const std::lock_guard lock(mutex_);
  part_ = part;
  text_ = text;
  active_ = true;
  const Clock::time_point now = Clock::now();
  const bool completes = shown_ && part >= 1;
  if (now - last_ >= kPause || completes) draw(now);
}

void ProgressBar::draw(Clock::time_point now) {
  constexpr int kWidth = 30;
  last_ = now;
  const double spent = std::chrono::duration<double>(now - begin_).count();
  std::string line = lines_ ? "" : "\r\x1b[K";
  if (part_ > 0) {
    const int filled = static_cast<int>(part_ * kWidth);
    line += lines_ ? fmt::format("{:.0f}% {}", std::floor(100 * part_), text_)
                   : fmt::format("[{:#<{}}{:.<{}}] {}", "", filled, "", kWidth - filled, text_);
    if (part_ < 1) line += fmt::format(", {} left", clock_text(spent / part_ - spent));
  } else {
    line += fmt::format("{}, {}", text_, clock_text(spent));
  }
  if (lines_) line += '\n';
  std::fwrite(line.data(), 1, line.size(), stderr);
  shown_ = true;
}

void ProgressBar::clear() {
  if (!enabled_) return;
  const std::lock_guard lock(mutex_);
  if (shown_ && !lines_) std::fputs("\r\x1b[K", stderr);
  shown_ = active_ = false;
}

}  // namespace foldproof
