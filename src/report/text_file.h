/// A text file that is written in large blocks and appears only when it is complete.
#pragma once

#include <fmt/format.h>

#include <iterator>

#include "base/try.h"
#include "foldproof/io.h"

namespace foldproof {

class TextFile {
 public:
  explicit TextFile(FileWriter file) : file_(std::move(file)) {}

  template <class... Args>
  void add(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(text_), format, std::forward<Args>(args)...);
  }

  /// Writes the buffer if it has grown large. Call it regularly between `add`s.
  Result<void> flush_if_large() { return text_.size() < kBlock ? Result<void>{} : flush(); }

  Result<void> commit() {
    FOLDPROOF_TRY(flush());
    return file_.commit();
  }

 private:
  static constexpr std::size_t kBlock = 1 << 16;

  Result<void> flush() {
    auto done = file_.write(std::span<const char>(text_.data(), text_.size()));
    text_.clear();
    return done;
  }

  FileWriter file_;
  fmt::memory_buffer text_;
};

}  // namespace foldproof
