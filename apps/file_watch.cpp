#include "file_watch.h"

#include <algorithm>
#include <thread>

#include "system/file.h"

namespace foldproof {
namespace {

namespace fs = std::filesystem;

constexpr std::chrono::milliseconds kPause(100);
constexpr int kPausesToSettle = 3, kPausesOfAWriter = 10;

}  // namespace

FileWatch::FileWatch(const FileArguments& files, const std::atomic<bool>& interrupted)
    : files_(files), interrupted_(interrupted) {}

FileWatch::State FileWatch::look() const {
  State state;
  for (const fs::path& path : files_.files_read()) {
    const auto status = system::status_of(path).value_or(system::FileStatus());
    const bool is_file = status.kind == system::FileKind::File;
    state.emplace_back(path.generic_string(), is_file ? status.size : 0, status.modified);
  }
  std::ranges::sort(state);
  return state;
}

bool FileWatch::pause() const {
  std::this_thread::sleep_for(kPause);
  return !interrupted_;
}

void FileWatch::settle() {
  settled_ = look();
  for (int quiet = 0; quiet < kPausesToSettle && pause(); ++quiet) {
    State now = look();
    if (now == settled_) continue;
    settled_ = std::move(now);
    quiet = -1;
  }
}

bool FileWatch::is_changing() {
  for (int k = 0; k < kPausesOfAWriter; ++k) {
    if (look() != settled_) return true;
    if (!pause()) return false;
  }
  return false;
}

std::string FileWatch::wait() {
  do {
    const State now = look();
    if (now == settled_) continue;
    const auto [changed, before] = std::ranges::mismatch(now, settled_);
    // Both are sorted, so the one that comes first is missing from the other, or differs.
    if (changed == now.end()) return std::get<0>(*before);
    return std::get<0>(before == settled_.end() ? *changed : std::min(*changed, *before));
  } while (pause());
  return "";
}

}  // namespace foldproof
