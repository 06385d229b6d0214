// Whether mesh files that are frames by their names look like bodies instead.
#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <limits>

#include "base/try.h"
#include "io/readers.h"

namespace foldproof::io {
namespace {

/// In diagonals of the box. Of twelve real motions and five sets of poses, each has a step of less than 0.04;
/// bodies that do not overlap much, if they are no thin layers, are farther apart than this.
constexpr double kFar = 0.25;
/// The same where some vertices stay in place, as those of a ground do.
constexpr double kVeryFar = 0.5;
/// Files round coordinates.
constexpr double kInPlace = 1e-3;

struct Pose {
  std::vector<Vec3> vertices;
  double size = 0;  // the diagonal of their box
};

Result<Pose> read_pose(Motion& motion, Index frame) {
  std::vector<double> x(3 * std::size_t{motion.topology().vertex_count()});
  FOLDPROOF_TRY(motion.read_frame(frame, x));
  Pose pose;
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (std::size_t i = 0; i < x.size(); i += 3) {
    const Vec3& v = pose.vertices.emplace_back(Vec3::load(&x[i]));
    low = low.cwiseMin(v), high = high.cwiseMax(v);
  }
  pose.size = (high - low).norm();
  return pose;
}

/// How far the means of the vertices are apart, in diagonals, if that speaks against frames; else 0.
double far_apart(const Pose& a, const Pose& b) {
  const double size = std::max(a.size, b.size);
  Vec3 sum;
  double smallest = std::numeric_limits<double>::infinity();
  for (std::size_t v = 0; v < a.vertices.size(); ++v) {
    const Vec3 move = b.vertices[v] - a.vertices[v];
    sum += move;
    smallest = std::min(smallest, move.norm());
  }
  const double apart = (sum / static_cast<double>(a.vertices.size())).norm() / size;
  if (!(apart >= kFar) || !std::isfinite(apart)) return 0;  // without a size there is nothing to compare
  const bool some_stay = smallest <= kInPlace * size;
  return some_stay && apart <= kVeryFar ? 0 : apart;
}

std::string file_name(const std::string& path) { return std::filesystem::path(path).filename().string(); }

}  // namespace

Result<void> require_frames(Motion& motion, std::span<const std::string> files) {
  auto before = read_pose(motion, 0);
  double first = 0;  // how far the first two are apart
  for (Index k = 1; before && k < motion.frame_count(); ++k) {
    auto pose = read_pose(motion, k);
    if (!pose) return {};
    const double apart = far_apart(*before, *pose);
    if (apart == 0) return {};
    if (k == 1) first = apart;
    before = std::move(pose);
  }
  if (!before || first == 0) return {};
  return fail(ErrorCode::Ambiguous, motion.name(),
              fmt::format("may be {0} frames of one mesh or {0} bodies: {1} is {2:.2g} times its size away "
                          "from {3}",
                          motion.frame_count(), file_name(files[1]), first, file_name(files[0])),
              "say which it is: --sequence or --separate");
}

}  // namespace foldproof::io
