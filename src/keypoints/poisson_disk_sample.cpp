#include <algorithm>
#include <cmath>

#include "keypoints/choose.h"

namespace foldproof::internal {
namespace {

using Points = Eigen::Map<const Eigen::Matrix<double, 3, Eigen::Dynamic>>;
using Cell = Eigen::Array<std::int64_t, 3, 1>;

constexpr int kMaxTrials = 40;

struct Entry {
  std::uint64_t key;
  Index vertex;
  bool operator<(const Entry& other) const {
    return key != other.key ? key < other.key : vertex < other.vertex;
  }
};

// Vertices sorted into cubes with sides of one radius: all within the radius of a vertex are in 27 cubes.
class Grid {
 public:
  Grid(const Points& positions, const Eigen::Vector3d& corner, double radius)
      : positions_(positions), corner_(corner), radius_(radius) {
    entries_.reserve(positions.cols());
    for (Index v = 0; v < positions.cols(); ++v) entries_.push_back({key(cell_of(v)), v});
    std::sort(entries_.begin(), entries_.end());
  }

  // Drops every vertex within the radius of `v`, including `v`.
  void drop_around(Index v, std::vector<char>& dropped) const {
    const Cell center = cell_of(v);
    for (int dx = -1; dx <= 1; ++dx) {
      for (int dy = -1; dy <= 1; ++dy) {
        // Consecutive cells in z have consecutive keys.
        const std::uint64_t first = key(center + Cell(dx, dy, -1));
        auto entry = std::lower_bound(entries_.begin(), entries_.end(), Entry{first, 0});
        for (; entry != entries_.end() && entry->key <= first + 2; ++entry) {
          if ((positions_.col(entry->vertex) - positions_.col(v)).squaredNorm() <= radius_ * radius_) {
            dropped[entry->vertex] = 1;
          }
        }
      }
    }
  }

 private:
  // Counts from 1, so that no neighbor has a negative coordinate. The radius is at least 2^-20 of the size,
  // so 21 bits hold each coordinate.
  Cell cell_of(Index v) const {
    return ((positions_.col(v) - corner_).array() / radius_).floor().cast<std::int64_t>() + 1;
  }
  static std::uint64_t key(const Cell& c) {
    return static_cast<std::uint64_t>(c[0]) << 42 | static_cast<std::uint64_t>(c[1]) << 21 |
           static_cast<std::uint64_t>(c[2]);
  }

  const Points& positions_;
  Eigen::Vector3d corner_;
  double radius_;
  std::vector<Entry> entries_;
};

// Stops when more than `max_count` are kept.
std::vector<Index> sample(const Points& positions, const Eigen::Vector3d& corner, double radius,
                          Index max_count) {
  const Grid grid(positions, corner, radius);
  std::vector<char> dropped(positions.cols(), 0);
  std::vector<Index> kept;
  for (Index v = 0; v < positions.cols() && kept.size() <= max_count; ++v) {
    if (dropped[v]) continue;
    kept.push_back(v);
    grid.drop_around(v, dropped);
  }
  return kept;
}

}  // namespace

std::vector<Index> poisson_disk_sample(std::span<const double> positions, Index count) {
  const Points points(positions.data(), 3, static_cast<Eigen::Index>(positions.size() / 3));
  if (points.cols() == 0) return {};
  const Eigen::Vector3d corner = points.rowwise().minCoeff();
  const double size = (points.rowwise().maxCoeff() - corner).maxCoeff();
  if (!(size > 0) || count <= 1) return {0};

  double too_small = size * 0x1p-20, large_enough = 2 * size;  // A radius of 2 sizes keeps one vertex.
  std::vector<Index> best{0};
  for (int trial = 0; trial < kMaxTrials && best.size() < count; ++trial) {
    // Bisects the logarithm, because the count is about a power of the radius.
    const double radius = std::sqrt(too_small * large_enough);
    std::vector<Index> kept = sample(points, corner, radius, count);
    if (kept.size() > count) {
      too_small = radius;
      continue;
    }
    large_enough = radius;
    if (kept.size() > best.size()) best = std::move(kept);
    if (static_cast<double>(best.size()) >= 0.98 * count) break;  // near enough
  }
  return best;
}

}  // namespace foldproof::internal
