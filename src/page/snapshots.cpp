#include "page/snapshots.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/try.h"

namespace foldproof {
namespace {

constexpr std::size_t kWorstSteps = 4;
// The same for one panel as for two, so that pictures align in rows.
constexpr Index kWidth = 1280, kHeight = 560;
// A second, closer panel is drawn if most collisions are within this share of the scene.
constexpr double kSmallPart = 0.2;

// Bits of a triangle's mark. With both, the first decides the color.
constexpr std::uint8_t kCollides = 1, kCrossesAtStart = 2;

/// View directions around the mesh, slightly from above and below.
std::vector<Vec3> directions_around() {
  std::vector<Vec3> directions;
  for (int k = 0; k < 8; ++k) {
    const double angle = k * std::numbers::pi / 4;
    for (const double height : {0.35, -0.35})
      directions.emplace_back(std::sin(angle), height, std::cos(angle));
  }
  return directions;
}

struct ColoredMesh {
  const Topology& topology;
  std::span<const double> positions;
  std::vector<Color> colors;

  Panel from(const View& view) const {
    return {.meshes = {{.topology = &topology, .positions = positions, .face_colors = colors}}, .view = view};
  }
};

/// The number of red or pink pixels.
Result<std::size_t> marked_in(const ColoredMesh& shown, const View& view) {
  const Panel panel = shown.from(view);
  const auto image =
      FOLDPROOF_TRY(draw_picture(std::span(&panel, 1), {.width = 200, .height = 175, .samples = 1}));
  return static_cast<std::size_t>(std::count_if(image.pixels.begin(), image.pixels.end(),
                                                [](Color c) { return 2 * c.red > 3 * c.green; }));
}

/// The direction from which most marked pixels are visible; nearly the front if nothing is marked.
Result<Vec3> best_direction(const ColoredMesh& shown, const std::vector<std::uint8_t>& marks) {
  Vec3 best{0.4, 0.3, 1};
  if (std::all_of(marks.begin(), marks.end(), [](std::uint8_t mark) { return mark == 0; })) return best;
  std::size_t max_marked = 0;
  for (const Vec3& direction : directions_around()) {
    const auto marked = FOLDPROOF_TRY(marked_in(shown, {.from = direction}));
    if (marked <= max_marked) continue;
    max_marked = marked;
    best = direction;
  }
  return best;
}

/// The region of most marked triangles, if it is a small part of the mesh.
std::optional<View::Focus> focus_on(const ColoredMesh& shown, const std::vector<std::uint8_t>& marks) {
  const auto at = [&](Index v) { return Eigen::Map<const Vec3>(&shown.positions[3 * std::size_t{v}]); };
  std::vector<Vec3> centroids;
  for (std::size_t t = 0; t < marks.size(); ++t) {
    const Triangle& c = shown.topology.triangles()[t];
    if (marks[t]) centroids.push_back((at(c[0]) + at(c[1]) + at(c[2])) / 3);
  }
  if (centroids.empty()) return std::nullopt;
  const auto half = static_cast<std::ptrdiff_t>(centroids.size() / 2);
  Vec3 median;
  for (int axis = 0; axis < 3; ++axis) {
    std::nth_element(centroids.begin(), centroids.begin() + half, centroids.end(),
                     [&](const Vec3& a, const Vec3& b) { return a[axis] < b[axis]; });
    median[axis] = centroids[static_cast<std::size_t>(half)][axis];
  }
  // The median may lie between two clusters; the triangle nearest to it lies in one of them.
  const auto distance_from = [](const Vec3& from) {
    return
        [from](const Vec3& a, const Vec3& b) { return (a - from).squaredNorm() < (b - from).squaredNorm(); };
  };
  const Vec3 center = *std::min_element(centroids.begin(), centroids.end(), distance_from(median));
  std::nth_element(centroids.begin(), centroids.begin() + half, centroids.end(), distance_from(center));
  const Eigen::Map<const Eigen::Matrix3Xd> x(shown.positions.data(), 3,
                                             static_cast<Eigen::Index>(shown.positions.size() / 3));
  const double size = (x.rowwise().maxCoeff() - x.rowwise().minCoeff()).norm();
  const double radius =
      std::max(0.05 * size, 2 * (centroids[static_cast<std::size_t>(half)] - center).norm());
  if (!(radius < kSmallPart * size)) return std::nullopt;
  return View::Focus{center, radius};
}

}  // namespace

Result<Snapshots> Snapshots::open(Motions motions, Index substeps) {
  auto joined = FOLDPROOF_TRY(join(motions, "pictures"));
  return Snapshots(motions, substeps, std::move(joined));
}

void Snapshots::start(const CheckedStep& pose) {
  start_ = StoredStep{};
  start_->index = pose.index;
  start_->collisions = pose.collisions;
  joined_.pose(pose, 0, start_->positions);
  mark_faces(motions_, pose, start_->marks);
  for (std::uint8_t& mark : start_->marks) mark = mark ? kCrossesAtStart : 0;
}

void Snapshots::add(const CheckedStep& step) {
  if (steps_++ == 0) {
    all_.index = step.index;
    joined_.pose(step, 0, all_.positions);
    all_.marks.assign(joined_.topology.triangles().size(), 0);
  }
  if (step.collisions.sum() == 0) return;
  mark_faces(motions_, step, marks_);
  for (std::size_t t = 0; t < marks_.size(); ++t) all_.marks[t] |= marks_[t];
  all_.collisions.vertex_face += step.collisions.vertex_face;
  all_.collisions.edge_edge += step.collisions.edge_edge;
  const auto next = std::find_if(worst_.begin(), worst_.end(), [&](const StoredStep& stored) {
    return step.collisions.sum() > stored.collisions.sum();
  });
  if (next == worst_.end() && worst_.size() == kWorstSteps) return;
  const auto stored = worst_.insert(next, {step.index, step.collisions, step.earliest_toi, {}, marks_});
  joined_.pose(step, step.earliest_toi, stored->positions);
  if (worst_.size() > kWorstSteps) worst_.pop_back();
}

std::string Snapshots::caption(const StoredStep& stored) const {
  if (stored.index.frame == stored.index.next_frame) {
    return fmt::format(
        "Frame {}, the only one: {} vertex-face and {} edge-edge pairs are in contact; red are triangles "
        "with "
        "a contact.",
        stored.index.frame, stored.collisions.vertex_face, stored.collisions.edge_edge);
  }
  std::string where = fmt::format("Frames {} to {}", stored.index.frame, stored.index.next_frame);
  if (substeps_ > 1) where += fmt::format(", part {} of {}", stored.index.substep + 1, substeps_);
  return fmt::format(
      "{}: {} vertex-face and {} edge-edge pairs collide. The pose is that of the first contact, "
      "{:.4g} of the way; red are triangles that collide during the step{}.",
      where, stored.collisions.vertex_face, stored.collisions.edge_edge, stored.toi,
      starts_crossing() ? fmt::format(", pink those that cross in frame {}", start_->index.frame) : "");
}

std::string Snapshots::caption_of_start() const {
  const std::uint64_t pairs = start_->collisions.sum();
  return fmt::format("Frame {} starts with {} of triangles; pink are triangles that cross.",
                     start_->index.frame,
                     pairs == 1 ? "1 crossing pair" : fmt::format("{} crossing pairs", pairs));
}

std::string Snapshots::caption_of_all(bool stopped) const {
  const std::string pose = fmt::format("The pose is that of frame {}.", all_.index.frame);
  if (!worst_.empty()) {
    return fmt::format("All {} steps together: red are triangles that collide in any of them{}. {}", steps_,
                       starts_crossing() ? ", pink those that cross in the pose that is shown" : "", pose);
  }
  if (stopped) return fmt::format("Nothing collides in the {} steps that were checked. {}", steps_, pose);
  if (start_) return "Nothing collides. " + pose;
  return "No step has a contact; crossings from the start were not tested. " + pose;
}

Result<std::string> Snapshots::draw(const StoredStep& stored) const {
  ColoredMesh shown{joined_.topology, stored.positions, {}};
  std::vector<std::uint8_t> marks = stored.marks;
  for (std::size_t t = 0; start_ && t < marks.size(); ++t) marks[t] |= start_->marks[t];
  for (const std::uint8_t mark : marks) {
    shown.colors.push_back(mark & kCollides         ? colors::kRed
                           : mark & kCrossesAtStart ? colors::kPink
                                                    : colors::kClay);
  }
  const auto direction = FOLDPROOF_TRY(best_direction(shown, stored.marks));
  std::vector<Panel> panels{shown.from({.from = direction})};
  if (const auto focus = focus_on(shown, stored.marks))
    panels.push_back(shown.from({.from = direction, .focus = focus}));
  const auto count = static_cast<Index>(panels.size());
  const auto image = FOLDPROOF_TRY(
      draw_picture(panels, {.width = kWidth, .height = kHeight, .columns = count, .same_scale = false}));
  return png_bytes(image);
}

Result<std::vector<Snapshot>> Snapshots::draw(const CheckTotals& totals) const {
  std::vector<Snapshot> snapshots;
  const auto add = [&](std::optional<std::uint64_t> step, const StoredStep& stored,
                       std::string caption) -> Result<void> {
    auto png = FOLDPROOF_TRY(draw(stored));
    snapshots.push_back({step, std::move(caption), std::move(png)});
    return {};
  };
  if (starts_crossing()) {
    FOLDPROOF_TRY(add(std::nullopt, *start_, caption_of_start()));
    if (worst_.empty()) return snapshots;
  }
  for (const StoredStep& stored : worst_) {
    FOLDPROOF_TRY(add(stored.index.number, stored, caption(stored)));
  }
  FOLDPROOF_TRY(add(std::nullopt, all_, caption_of_all(totals.cancelled)));
  return snapshots;
}

}  // namespace foldproof
