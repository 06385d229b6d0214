// Key-point tracks: positions of key points, frame by frame.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>
#include <unordered_map>

#include "base/try.h"
#include "foldproof/learned.h"

namespace foldproof {
namespace {

constexpr const char* kLayouts =
    "give an NPZ with 'keypoints' (frames x points x 3), a CSV with the columns frame, vertex, x, y, z, or a "
    "CSV with x y z of every key point in a row";

Result<KeyPointTracks> from_rows(const std::string& path, std::uint64_t frames, std::size_t points,
                                 std::vector<double> values) {
  if (frames >= kNoIndex) return fail(ErrorCode::LimitExceeded, path, "has too many frames", "split it");
  return KeyPointTracks{path, static_cast<Index>(frames), static_cast<Index>(points), std::move(values)};
}

Result<KeyPointTracks> from_array(const std::string& path, NumberTable table, std::size_t points) {
  const auto& shape = table.shape;
  const bool single = shape.size() == 2, several = shape.size() == 3;
  if ((single || several) && shape.back() == 3 && shape[shape.size() - 2] == points) {
    return from_rows(path, single ? 1 : shape[0], points, std::move(table.values));
  }
  return fail(ErrorCode::InvalidFile, path + ", array 'keypoints'",
              fmt::format("is of shape {}, and the model has {} key points", fmt::join(shape, " x "), points),
              kLayouts);
}

/// Rows of frame, vertex, x, y, z in any order; vertices that are not key points are skipped.
class LongTable {
 public:
  LongTable(const std::string& path, const NumberTable& table, std::span<const Index> vertices)
      : path_(path), table_(table), vertices_(vertices) {}

  Result<KeyPointTracks> read() {
    FOLDPROOF_TRY(find_columns());
    std::unordered_map<double, std::size_t> point_of;
    for (std::size_t k = 0; k < vertices_.size(); ++k) point_of[vertices_[k]] = k;
    std::set<double> frames;
    for (std::uint64_t row = 0; row < table_.shape[0]; ++row) frames.insert(at(row, 0));
    FOLDPROOF_TRY(check_consecutive(frames));
    std::unordered_map<double, std::size_t> frame_of;
    for (const double frame : frames) frame_of.emplace(frame, frame_of.size());
    // A table of few rows must not claim much memory.
    if (frames.size() * vertices_.size() > table_.shape[0]) return missing(*frames.begin());
    std::vector<double> values(frames.size() * vertices_.size() * 3, NAN);
    for (std::uint64_t row = 0; row < table_.shape[0]; ++row) {
      const auto point = point_of.find(at(row, 1));
      if (point == point_of.end()) continue;
      double* x = &values[3 * (frame_of[at(row, 0)] * vertices_.size() + point->second)];
      if (!std::isnan(*x)) {
        return fail(ErrorCode::InvalidFile, path_,
                    fmt::format("has vertex {} twice in frame {}", at(row, 1), at(row, 0)),
                    "keep one of them");
      }
      for (int axis = 0; axis < 3; ++axis) x[axis] = at(row, 2 + axis);
    }
    for (const double frame : frames) {
      for (std::size_t k = 0; k < vertices_.size(); ++k) {
        if (std::isnan(values[3 * (frame_of[frame] * vertices_.size() + k)])) return missing(frame);
      }
    }
    return from_rows(path_, frames.size(), vertices_.size(), std::move(values));
  }

 private:
  double at(std::uint64_t row, int column) const { return table_.values[5 * row + columns_[column]]; }

  tl::unexpected<Error> missing(double frame) const {
    return fail(ErrorCode::InvalidFile, path_,
                fmt::format("lacks key points, for example in frame {}", frame),
                "give every key point in every frame; 'predict MODEL --list-key-points' lists them");
  }

  // The step between two frames is a straight line, which frames that are missing need not lie on.
  Result<void> check_consecutive(const std::set<double>& frames) const {
    const auto gap = std::ranges::adjacent_find(frames, [](double a, double b) { return b != a + 1; });
    if (gap == frames.end()) return {};
    const double frame = *gap, next = *std::next(gap);
    return fail(ErrorCode::InvalidFile, path_,
                next < frame + 1
                    ? fmt::format("has frame {} right after frame {}", next, frame)
                    : fmt::format("lacks frame {}: frame {} follows frame {}", frame + 1, next, frame),
                "number frames one after the other, and give all of them");
  }

  Result<void> find_columns() {
    if (table_.names.empty()) return {};
    const char* const names[] = {"frame", "vertex", "x", "y", "z"};
    for (int k = 0; k < 5; ++k) {
      const auto found = std::find(table_.names.begin(), table_.names.end(), names[k]);
      if (found == table_.names.end()) {
        return fail(ErrorCode::InvalidFile, path_, fmt::format("has no column '{}'", names[k]), kLayouts);
      }
      columns_[k] = static_cast<std::size_t>(found - table_.names.begin());
    }
    return {};
  }

  const std::string& path_;
  const NumberTable& table_;
  std::span<const Index> vertices_;
  std::array<std::size_t, 5> columns_{0, 1, 2, 3, 4};
};

}  // namespace

Result<KeyPointTracks> read_key_point_tracks(const std::string& path, std::span<const Index> vertices) {
  if (extension_of(path) != ".csv") {
    auto table = FOLDPROOF_TRY(read_npz_numbers(path, "keypoints"));
    return from_array(path, std::move(table), vertices.size());
  }
  auto table = FOLDPROOF_TRY(read_csv(path));
  if (table.shape[1] == 5) return LongTable(path, table, vertices).read();
  if (table.shape[1] == 3 * vertices.size()) {
    return from_rows(path, table.shape[0], vertices.size(), std::move(table.values));
  }
  return fail(ErrorCode::InvalidFile, path,
              fmt::format("has {} columns, and the model has {} key points", table.shape[1], vertices.size()),
              kLayouts);
}

Result<KeyPointTracks> extract_tracks(Motion& motion, std::span<const Index> vertices,
                                      std::span<const Index> frames) {
  KeyPointTracks tracks{
      motion.name(), static_cast<Index>(frames.size()), static_cast<Index>(vertices.size()), {}};
  std::vector<double> x(std::size_t{3} * motion.topology().vertex_count());
  for (const Index frame : frames) {
    FOLDPROOF_TRY(motion.read_frame(frame, x));
    for (const Index v : vertices) {
      tracks.positions.insert(tracks.positions.end(), &x[3 * std::size_t{v}], &x[3 * std::size_t{v}] + 3);
    }
  }
  return tracks;
}

}  // namespace foldproof
