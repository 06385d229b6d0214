/// Files and their bytes. Every read is checked against the actual size of the file.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <vector>

#include "io/progress.h"
#include "system/file.h"

namespace foldproof::io {

/// A regular file, open for reading at any offset.
class InputFile {
 public:
  /// Error: it cannot be opened, or is not data (recognize.h), whatever the format.
  static Result<InputFile> open(const std::string& path);

  const std::string& path() const { return path_; }
  std::uint64_t size() const { return status_.size; }

  /// Fills `out` with the bytes from `offset`. Error: the file ends before `out` is full, or has been written
  /// to since it was opened.
  Result<void> read_at(std::uint64_t offset, std::span<char> out) const;

 private:
  InputFile() = default;
  std::string path_;
  system::File file_;
  system::FileStatus status_;  // when it was opened
};

/// The error for a path at which there is nothing.
tl::unexpected<Error> does_not_exist(const std::string& path);

/// Reads a whole regular file.
Result<std::vector<char>> read_file(const std::string& path, const ReadProgress& progress = {});
/// Writes a whole file, by FileWriter.
Result<void> write_file(const std::string& path, std::span<const char> bytes);

/// Reads a number from any address, aligned or not, in the given byte order.
template <class T>
T load(const char* bytes, std::endian order) {
  std::array<char, sizeof(T)> raw;
  std::memcpy(raw.data(), bytes, sizeof(T));
  if (order != std::endian::native) std::reverse(raw.begin(), raw.end());
  return std::bit_cast<T>(raw);
}

/// Appends the bytes of `value` in the given byte order.
template <class T>
void append(std::vector<char>& bytes, T value, std::endian order = std::endian::little) {
  auto raw = std::bit_cast<std::array<char, sizeof(T)>>(value);
  if (order != std::endian::native) std::reverse(raw.begin(), raw.end());
  bytes.insert(bytes.end(), raw.begin(), raw.end());
}

/// The bytes of an array of numbers, as in memory.
std::span<const char> bytes_of(const auto& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(values[0])};
}

/// The location of a byte, for errors: "walk.pc2, byte 32".
std::string at_byte(const std::string& path, std::uint64_t offset);

}  // namespace foldproof::io
