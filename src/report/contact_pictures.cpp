#include "report/contact_pictures.h"

#include <algorithm>
#include <cmath>

#include "base/try.h"

namespace foldproof {
namespace {

// A contact smaller than this share of the scene is shown from near, too.
constexpr double kSmallPart = 0.35;

Result<std::string> png_of(std::span<const Panel> panels, const ContactPictures::Format& format) {
  const auto image = FOLDPROOF_TRY(
      draw_picture(panels, {.width = format.width, .height = format.height, .background = std::nullopt}));
  return png_bytes(image);
}

std::string base64(std::string_view bytes) {
  constexpr const char* kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k)
      group = group << 8 | (k < count ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k) text += k <= count ? kDigits[group >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

// When its worst frame is, or the first impact if it crosses in no frame.
double time_shown(const Contact& contact) {
  return contact.frames.empty() ? contact.first_time : contact.frames[contact.worst].time;
}

}  // namespace

std::optional<View::Focus> focus_on(const Contact& contact, double size) {
  const double radius = std::max(0.6 * (contact.high - contact.low).norm(), 0.02 * size);
  if (!(radius < kSmallPart * size)) return std::nullopt;
  if (contact.frames.empty()) return View::Focus{contact.point, radius};
  return View::Focus{0.5 * (contact.low + contact.high), radius};
}

double thin_dot(const Contact& contact, double size) {
  return std::max(0.015 * (contact.high - contact.low).norm() / size, 1e-9);
}

ContactMarks marks_of(const Contact& contact, std::span<const PictureMesh> meshes) {
  ContactMarks marks;
  for (const PictureMesh& mesh : meshes) marks.emplace_back(mesh.topology->triangles().size(), 0);
  for (std::uint8_t side = 0; side < 2; ++side) {
    for (const Index triangle : contact.sides[side].triangles)
      marks[contact.sides[side].object][triangle] = static_cast<std::uint8_t>(side + 1);
  }
  return marks;
}

PicturePoints dots_along(const Contact& contact, double spacing) {
  PicturePoints dots{.positions = {}, .color = colors::kBlack};
  for (const std::vector<Vec3>& curve : contact.curves) {
    for (std::size_t i = 0; i + 1 < curve.size(); ++i) {
      const Vec3 way = curve[i + 1] - curve[i];
      const int parts = static_cast<int>(std::clamp(std::ceil(way.norm() / spacing), 1.0, 100.0));
      for (int k = 0; k < parts; ++k) dots.positions.emplace_back(curve[i] + double{1} * k / parts * way);
    }
  }
  return dots;
}

std::string data_url(std::string_view png) { return "data:image/png;base64," + base64(png); }

Result<ContactPictures> ContactPictures::open(Motions motions, const CheckSettings& settings) {
  const auto extent = FOLDPROOF_TRY(extent_of(motions));
  const auto frames = select_frames(settings.frames, motions[0]->frame_count());
  return ContactPictures({motions, {frames.begin(), frames.end()}, frames}, extent.up);
}

/// Reads the pose at a time, on the straight way between two frames.
Result<void> ContactPictures::read(const Frames& frames, double time) {
  const auto& [motions, times, numbers] = frames;
  const auto after = static_cast<std::size_t>(std::ranges::lower_bound(times, time) - times.begin());
  const std::size_t next = std::min(after, times.size() - 1);
  const std::size_t previous = next == 0 || times[next] <= time ? next : next - 1;
  const double t = next == previous ? 0 : (time - times[previous]) / (times[next] - times[previous]);
  pose_.resize(motions.size());
  box_.setEmpty();
  std::vector<double> end;
  for (std::size_t i = 0; i < motions.size(); ++i) {
    std::vector<double>& x = pose_[i];
    x.resize(std::size_t{motions[i]->topology().vertex_count()} * 3);
    FOLDPROOF_TRY(motions[i]->read_frame(numbers[previous], x));
    end.resize(x.size());
    if (t > 0) {
      FOLDPROOF_TRY(motions[i]->read_frame(numbers[next], end));
    }
    for (std::size_t k = 0; t > 0 && k < x.size(); ++k) x[k] = std::lerp(x[k], end[k], t);
    box_.extend(box_of(x));
  }
  return {};
}

std::vector<PictureMesh> ContactPictures::meshes() const {
  std::vector<PictureMesh> meshes;
  for (std::size_t i = 0; i < pose_.size(); ++i)
    meshes.push_back({.topology = &checked_.motions[i]->topology(), .positions = pose_[i]});
  return meshes;
}

Result<View> ContactPictures::view(const Contact& contact, Up up) {
  FOLDPROOF_TRY(read(checked_, time_shown(contact)));
  const auto shown = meshes();
  if (!contact.frames.empty())
    return view_of(shown, marks_of(contact, shown), contact.curves, contact.normal, up);
  return contact.normal == Vec3::Zero() ? default_view(up) : view_along(contact.normal, up);
}

Result<std::string> ContactPictures::draw(const Contact& contact, const Format& format) {
  const View direction = FOLDPROOF_TRY(view(contact, up_));  // reads the pose
  return draw_pose(contact, direction, true, format);
}

Result<std::string> ContactPictures::draw_in(Motions others, std::span<const double> times,
                                             const Contact& contact, const Format& format) {
  const View direction = FOLDPROOF_TRY(view(contact, up_));
  Frames frames{others, {times.begin(), times.end()}, {}};
  for (Index k = 0; k < times.size(); ++k) frames.numbers.push_back(k);
  FOLDPROOF_TRY(read(frames, time_shown(contact)));
  return draw_pose(contact, direction, false, format);
}

Result<std::string> ContactPictures::draw_pose(const Contact& contact, const View& direction,
                                               bool shows_curves, const Format& format) const {
  Panel whole{.meshes = meshes(), .view = direction};
  const ContactMarks marks = marks_of(contact, whole.meshes);
  std::vector<std::vector<Color>> colors;
  for (std::size_t i = 0; i < marks.size(); ++i) {
    colors.emplace_back(marks[i].size(), colors::kClay);
    for (std::size_t t = 0; t < marks[i].size(); ++t)
      if (marks[i][t]) colors[i][t] = kSideColors[marks[i][t] - 1];
  }
  for (std::size_t i = 0; i < marks.size(); ++i) whole.meshes[i].face_colors = colors[i];
  std::vector<Panel> panels{whole};
  const double size = box_.sizes().maxCoeff();
  const auto focus = focus_on(contact, size);
  if (focus && format.near) {
    panels.push_back(whole);
    panels.back().view.focus = focus;
    if (shows_curves && !contact.frames.empty()) {
      const double radius = focus->radius / 150;
      panels.back().points.push_back(dots_along(contact, radius));
      panels.back().points.back().size = std::clamp(radius / size, 1e-9, 1.0);
    } else if (shows_curves) {
      panels.back().points.push_back({.positions = {contact.point}, .size = 0.006});  // where they touch
    }
  }
  return png_of(panels, format);
}

Result<std::string> ContactPictures::draw_first_frame(const Format& format) {
  FOLDPROOF_TRY(read(checked_, checked_.times.front()));
  const Panel panel{.meshes = meshes(), .view = default_view(up_)};
  return png_of(std::span(&panel, 1), format);
}

}  // namespace foldproof
