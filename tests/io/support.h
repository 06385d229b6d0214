/// Small files in a scratch directory, and shortcuts to open them.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <bit>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "foldproof/io.h"
#include "system/file.h"

namespace foldproof::testing {

/// A temporary directory, removed with its content.
class ScratchDirectory {
 public:
  ScratchDirectory() {
    // In memory if possible: some tests write tens of thousands of files.
    const bool memory = std::filesystem::is_directory("/dev/shm");
    const auto parent = memory ? std::filesystem::path("/dev/shm") : std::filesystem::temp_directory_path();
    static std::atomic<int> made = 0;
    while (path_.empty()) {  // an earlier process of this number may have left some behind
      const std::string name =
          "foldproof-test-" + std::to_string(system::process_number()) + "-" + std::to_string(made++);
      if (std::filesystem::create_directory(parent / name)) path_ = (parent / name).generic_string();
    }
  }
  ScratchDirectory(const ScratchDirectory&) = delete;
  ScratchDirectory& operator=(const ScratchDirectory&) = delete;
  ~ScratchDirectory() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }

  std::string path(const std::string& name) const { return path_ + "/" + name; }
  std::string write(const std::string& name, std::string_view bytes) const {
    std::filesystem::create_directories(std::filesystem::path(path(name)).parent_path());
    std::ofstream(path(name), std::ios::binary)
        .write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    return path(name);
  }

 private:
  std::string path_;
};

inline std::string read_bytes(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

/// The bytes of a number in the given order.
template <class T>
std::string bytes_of(T value, std::endian order = std::endian::little) {
  std::string raw(sizeof(T), '\0');
  std::memcpy(raw.data(), &value, sizeof(T));
  if (order != std::endian::native) std::reverse(raw.begin(), raw.end());
  return raw;
}

class IoTest : public ::testing::Test {
 protected:
  /// Opens the only motion that the arguments name.
  std::unique_ptr<Motion> open(const std::vector<std::string>& arguments, const ReadOptions& options = {}) {
    auto motions = open_motions(arguments, options);
    if (!motions) {
      ADD_FAILURE() << motions.error().line();
      return nullptr;
    }
    EXPECT_EQ(motions->size(), 1u);
    return std::move(motions->front());
  }

  static std::vector<double> frame(Motion& motion, Index k) {
    std::vector<double> positions(std::size_t{3} * motion.topology().vertex_count());
    const auto read = motion.read_frame(k, positions);
    EXPECT_TRUE(read) << read.error().line();
    return positions;
  }

  static std::vector<Triangle> triangles(const Motion& motion) {
    return {motion.topology().triangles().begin(), motion.topology().triangles().end()};
  }

  /// The error's line, without the scratch directory.
  std::string shown(const Error& error) const {
    std::string line = error.line();
    for (std::size_t at; (at = line.find(files.path(""))) != line.npos;)
      line.erase(at, files.path("").size());
    return line;
  }

  std::string open_error(const std::vector<std::string>& arguments, const ReadOptions& options = {}) const {
    const auto motions = open_motions(arguments, options);
    return motions ? "no error" : shown(motions.error());
  }

  std::string frame_error(Motion& motion, Index k) const {
    std::vector<double> positions(std::size_t{3} * motion.topology().vertex_count());
    const auto read = motion.read_frame(k, positions);
    return read ? "no error" : shown(read.error());
  }

  ScratchDirectory files;
};

inline const std::vector<double> kTrianglePositions{0, 0, 0, 1, 0, 0, 0, 1, 0};
inline const std::vector<Triangle> kOneTriangle{{0, 1, 2}};

}  // namespace foldproof::testing
