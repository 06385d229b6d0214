#include "page/snapshots.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace foldproof {
namespace {

constexpr std::size_t kWorstSteps = 4;
// The same for one panel as for two, so that pictures stand in rows.
constexpr Index kWidth = 1280, kHeight = 560;
// A closer look is worth it when collisions keep to less than this share of the whole.
constexpr double kSmallPart = 0.2;

// What is known of a triangle in a picture. The first is drawn where both are.
constexpr std::uint8_t kCollides = 1, kCrossesAtStart = 2;

/// Directions to eyes around the mesh, a little from above and below.
std::vector<Vec3> directions_around() {
  std::vector<Vec3> directions;
  for (int k = 0; k < 8; ++k) {
    const double angle = k * std::numbers::pi / 4;
    for (const double height : {0.35, -0.35})
      directions.emplace_back(std::sin(angle), height, std::cos(angle));
  }
  return directions;
}

struct Shown {
  const Topology& topology;
  std::span<const double> positions;
  std::vector<Colour> colours;

  Panel from(const View& view) const {
    return {.meshes = {{.topology = &topology, .positions = positions, .face_colours = colours}},
            .view = view};
  }
};

/// Pixels that show red or pink.
Result<std::size_t> marked_in(const Shown& shown, const View& view) {
  const Panel panel = shown.from(view);
  const auto image = draw_picture(std::span(&panel, 1), {.width = 200, .height = 175, .samples = 1});
  if (!image) return tl::unexpected(image.error());
  return static_cast<std::size_t>(std::count_if(image->pixels.begin(), image->pixels.end(),
                                                [](Colour c) { return 2 * c.red > 3 * c.green; }));
}

/// From where most of what is marked is seen; nearly the front where there is nothing.
Result<Vec3> best_direction(const Shown& shown, const std::vector<std::uint8_t>& marks) {
  Vec3 best{0.4, 0.3, 1};
  if (std::all_of(marks.begin(), marks.end(), [](std::uint8_t mark) { return mark == 0; })) return best;
  std::size_t most = 0;
  for (const Vec3& direction : directions_around()) {
    const auto marked = marked_in(shown, {.from = direction});
    if (!marked) return tl::unexpected(marked.error());
    if (*marked <= most) continue;
    most = *marked;
    best = direction;
  }
  return best;
}

/// Where most of the marked triangles are, when they keep to a small part of the whole.
std::optional<View::Focus> focus_on(const Shown& shown, const std::vector<std::uint8_t>& marks) {
  const auto at = [&](Index v) { return Eigen::Map<const Vec3>(&shown.positions[3 * std::size_t{v}]); };
  std::vector<Vec3> middles;
  for (std::size_t t = 0; t < marks.size(); ++t) {
    const Triangle& c = shown.topology.triangles()[t];
    if (marks[t]) middles.push_back((at(c[0]) + at(c[1]) + at(c[2])) / 3);
  }
  if (middles.empty()) return std::nullopt;
  const auto half = static_cast<std::ptrdiff_t>(middles.size() / 2);
  Vec3 median;
  for (int axis = 0; axis < 3; ++axis) {
    std::nth_element(middles.begin(), middles.begin() + half, middles.end(),
                     [&](const Vec3& a, const Vec3& b) { return a[axis] < b[axis]; });
    median[axis] = middles[static_cast<std::size_t>(half)][axis];
  }
  // Of two places the median may be between: the nearest triangle is in one of them.
  const auto distance_from = [](const Vec3& from) {
    return
        [from](const Vec3& a, const Vec3& b) { return (a - from).squaredNorm() < (b - from).squaredNorm(); };
  };
  const Vec3 centre = *std::min_element(middles.begin(), middles.end(), distance_from(median));
  std::nth_element(middles.begin(), middles.begin() + half, middles.end(), distance_from(centre));
  const Eigen::Map<const Eigen::Matrix3Xd> x(shown.positions.data(), 3,
                                             static_cast<Eigen::Index>(shown.positions.size() / 3));
  const double size = (x.rowwise().maxCoeff() - x.rowwise().minCoeff()).norm();
  const double radius = std::max(0.05 * size, 2 * (middles[static_cast<std::size_t>(half)] - centre).norm());
  if (!(radius < kSmallPart * size)) return std::nullopt;
  return View::Focus{centre, radius};
}

}  // namespace

Result<Snapshots> Snapshots::open(Motions motions, Index substeps) {
  auto joined = join(motions, "pictures");
  if (!joined) return tl::unexpected(joined.error());
  return Snapshots(motions, substeps, std::move(*joined));
}

void Snapshots::start(const CheckedStep& pose) {
  start_ = Kept{};
  start_->place = pose.place;
  start_->collisions = pose.collisions;
  joined_.pose(pose, 0, start_->positions);
  mark_faces(motions_, pose, start_->marks);
  for (std::uint8_t& mark : start_->marks) mark = mark ? kCrossesAtStart : 0;
}

void Snapshots::look(const CheckedStep& step) {
  if (steps_++ == 0) {
    all_.place = step.place;
    joined_.pose(step, 0, all_.positions);
    all_.marks.assign(joined_.topology.triangles().size(), 0);
  }
  if (step.collisions.sum() == 0) return;
  mark_faces(motions_, step, marks_);
  for (std::size_t t = 0; t < marks_.size(); ++t) all_.marks[t] |= marks_[t];
  all_.collisions.vertex_face += step.collisions.vertex_face;
  all_.collisions.edge_edge += step.collisions.edge_edge;
  const auto place = std::find_if(worst_.begin(), worst_.end(), [&](const Kept& kept) {
    return step.collisions.sum() > kept.collisions.sum();
  });
  if (place == worst_.end() && worst_.size() == kWorstSteps) return;
  const auto kept = worst_.insert(place, {step.place, step.collisions, step.earliest_toi, {}, marks_});
  joined_.pose(step, step.earliest_toi, kept->positions);
  if (worst_.size() > kWorstSteps) worst_.pop_back();
}

std::string Snapshots::caption(const Kept& kept) const {
  if (kept.place.frame == kept.place.next_frame) {
    return fmt::format(
        "Frame {}, which stands alone: {} vertex-face and {} edge-edge pairs are in contact; red are "
        "triangles "
        "with a contact.",
        kept.place.frame, kept.collisions.vertex_face, kept.collisions.edge_edge);
  }
  std::string where = fmt::format("Frames {} to {}", kept.place.frame, kept.place.next_frame);
  if (substeps_ > 1) where += fmt::format(", part {} of {}", kept.place.substep + 1, substeps_);
  return fmt::format(
      "{}: {} vertex-face and {} edge-edge pairs collide. The pose is that of the first contact, "
      "{:.4g} of the way; red are triangles that collide during the step{}.",
      where, kept.collisions.vertex_face, kept.collisions.edge_edge, kept.toi,
      starts_crossing() ? fmt::format(", pink those that cross in frame {}", start_->place.frame) : "");
}

std::string Snapshots::caption_of_start() const {
  const std::uint64_t pairs = start_->collisions.sum();
  return fmt::format("Frame {} starts with {} of triangles; pink are triangles that cross.",
                     start_->place.frame,
                     pairs == 1 ? "1 crossing pair" : fmt::format("{} crossing pairs", pairs));
}

std::string Snapshots::caption_of_all(bool stopped) const {
  const std::string pose = fmt::format("The pose is that of frame {}.", all_.place.frame);
  if (!worst_.empty()) {
    return fmt::format("All {} steps together: red are triangles that collide in any of them{}. {}", steps_,
                       starts_crossing() ? ", pink those that cross in the pose that is shown" : "", pose);
  }
  if (stopped) return fmt::format("Nothing collides in the {} steps that were checked. {}", steps_, pose);
  if (start_) return "Nothing collides. " + pose;
  return "No step has a contact; what crosses from the start was not asked. " + pose;
}

Result<std::string> Snapshots::draw(const Kept& kept) const {
  Shown shown{joined_.topology, kept.positions, {}};
  std::vector<std::uint8_t> marks = kept.marks;
  for (std::size_t t = 0; start_ && t < marks.size(); ++t) marks[t] |= start_->marks[t];
  for (const std::uint8_t mark : marks) {
    shown.colours.push_back(mark & kCollides         ? colours::kRed
                            : mark & kCrossesAtStart ? colours::kPink
                                                     : colours::kClay);
  }
  const auto direction = best_direction(shown, kept.marks);
  if (!direction) return tl::unexpected(direction.error());
  std::vector<Panel> panels{shown.from({.from = *direction})};
  if (const auto focus = focus_on(shown, kept.marks))
    panels.push_back(shown.from({.from = *direction, .focus = focus}));
  const auto count = static_cast<Index>(panels.size());
  const auto image =
      draw_picture(panels, {.width = kWidth, .height = kHeight, .columns = count, .same_scale = false});
  if (!image) return tl::unexpected(image.error());
  return png_bytes(*image);
}

Result<std::vector<Snapshot>> Snapshots::draw(const CheckTotals& totals) const {
  std::vector<Snapshot> snapshots;
  const auto add = [&](std::optional<std::uint64_t> step, const Kept& kept,
                       std::string caption) -> Result<void> {
    auto png = draw(kept);
    if (!png) return tl::unexpected(png.error());
    snapshots.push_back({step, std::move(caption), std::move(*png)});
    return {};
  };
  if (starts_crossing()) {
    if (const auto done = add(std::nullopt, *start_, caption_of_start()); !done)
      return tl::unexpected(done.error());
    if (worst_.empty()) return snapshots;
  }
  for (const Kept& kept : worst_) {
    if (const auto done = add(kept.place.number, kept, caption(kept)); !done)
      return tl::unexpected(done.error());
  }
  if (const auto done = add(std::nullopt, all_, caption_of_all(totals.cancelled)); !done)
    return tl::unexpected(done.error());
  return snapshots;
}

}  // namespace foldproof
