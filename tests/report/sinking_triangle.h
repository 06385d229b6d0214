/// A motion with known collisions: a triangle, tip down, sinks through a large floor triangle.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "report/report.h"

namespace foldproof::testing {

/// Vertices 0 1 2 and face 0 are the floor at z = 0; vertex 3 is the tip at `height`, 4 and 5 are one above
/// it. A step hits exactly the vertices that pass z = 0, all with face 0; no two edges ever meet.
inline std::vector<double> sinking_frame(double height) {
  return {-9, -9, 0, 20, -9, 0, -9, 20, 0, 0.1, 0.1, height, 0.3, 0.1, height + 1, 0.1, 0.3, height + 1};
}

inline std::unique_ptr<Motion> sinking_triangle(const std::vector<double>& heights,
                                                std::string name = "sinking triangle") {
  std::vector<std::vector<double>> frames;
  for (const double height : heights) frames.push_back(sinking_frame(height));
  return memory_motion(std::move(name), *Topology::make(6, {{0, 1, 2}, {3, 4, 5}}), std::move(frames));
}

/// The sinking triangle without the floor, as an object of its own: its tip is vertex 0.
inline std::unique_ptr<Motion> lone_triangle(const std::vector<double>& heights) {
  std::vector<std::vector<double>> frames;
  for (const double height : heights) {
    const std::vector<double> frame = sinking_frame(height);
    frames.emplace_back(frame.begin() + 9, frame.end());
  }
  return memory_motion("lone triangle", *Topology::make(3, {{0, 1, 2}}), std::move(frames));
}

inline std::unique_ptr<Motion> lone_floor(std::size_t frames) {
  const std::vector<double> frame = sinking_frame(0);
  return memory_motion("lone floor", *Topology::make(3, {{0, 1, 2}}),
                       std::vector<std::vector<double>>(frames, {frame.begin(), frame.begin() + 9}));
}

/// The tip hits in step 1 (0.6 of the way), the other two vertices in step 2 (again 0.6), nothing in steps 0
/// and 3. Frames 2 and 3 stand in the floor: height -0.4 with the tip below it, and not any more at -1.4.
inline const std::vector<double> kSinking = {1.6, 0.6, -0.4, -1.4, -2.4};

template <class... M>
std::vector<std::unique_ptr<Motion>> list(M... motions) {
  std::vector<std::unique_ptr<Motion>> all;
  (all.push_back(std::move(motions)), ...);
  return all;
}

/// A directory for one test's files, removed afterwards.
class TemporaryDirectory {
 public:
  TemporaryDirectory() {
    std::string pattern = (std::filesystem::temp_directory_path() / "foldproof-test-XXXXXX").string();
    if (::mkdtemp(pattern.data()) == nullptr) ADD_FAILURE() << "no temporary directory";
    path_ = pattern;
  }
  ~TemporaryDirectory() { std::filesystem::remove_all(path_); }
  TemporaryDirectory(const TemporaryDirectory&) = delete;
  TemporaryDirectory& operator=(const TemporaryDirectory&) = delete;

  std::string operator/(const std::string& name) const { return (path_ / name).string(); }
  std::string path() const { return path_.string(); }
  /// Names of what is in it, sorted.
  std::vector<std::string> names() const {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(path_))
      names.push_back(entry.path().filename());
    std::sort(names.begin(), names.end());
    return names;
  }

 private:
  std::filesystem::path path_;
};

inline std::string read_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  EXPECT_TRUE(file) << path;
  return {std::istreambuf_iterator<char>(file), {}};
}

/// The marks of a PLY that ply_report wrote: the byte after the vertices of each face record at its end. Two
/// more properties of four bytes follow where it has contacts.
inline std::vector<int> read_marks(const std::string& path, std::size_t faces) {
  const std::string bytes = read_file(path);
  std::vector<int> marks;
  const std::size_t record = bytes.find("\nproperty int contact\n") == bytes.npos ? 14 : 22;
  EXPECT_GE(bytes.size(), faces * record);
  for (std::size_t face = 0; face < faces && bytes.size() >= faces * record; ++face) {
    marks.push_back(static_cast<unsigned char>(bytes[bytes.size() - (faces - face) * record + 13]));
  }
  return marks;
}

}  // namespace foldproof::testing
