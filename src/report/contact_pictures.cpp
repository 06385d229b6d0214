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
  return ContactPictures(motions, select_frames(settings.frames, motions[0]->frame_count()), extent.up);
}

/// Reads the pose at a time in frames, on the straight way between two that were checked.
Result<void> ContactPictures::read(double time) {
  const auto after = std::lower_bound(frames_.begin(), frames_.end(), time);
  const Index next = after == frames_.end() ? frames_.back() : *after;
  const Index previous = after == frames_.begin() || next <= time ? next : *std::prev(after);
  const double t = next == previous ? 0 : (time - previous) / (next - previous);
  pose_.resize(motions_.size());
  box_.setEmpty();
  std::vector<double> end;
  for (std::size_t i = 0; i < motions_.size(); ++i) {
    std::vector<double>& x = pose_[i];
    x.resize(std::size_t{motions_[i]->topology().vertex_count()} * 3);
    FOLDPROOF_TRY(motions_[i]->read_frame(previous, x));
    end.resize(x.size());
    if (t > 0) {
      FOLDPROOF_TRY(motions_[i]->read_frame(next, end));
    }
    for (std::size_t k = 0; t > 0 && k < x.size(); ++k) x[k] = std::lerp(x[k], end[k], t);
    box_.extend(box_of(x));
  }
  return {};
}

std::vector<PictureMesh> ContactPictures::meshes() const {
  std::vector<PictureMesh> meshes;
  for (std::size_t i = 0; i < motions_.size(); ++i)
    meshes.push_back({.topology = &motions_[i]->topology(), .positions = pose_[i]});
  return meshes;
}

Result<View> ContactPictures::view(const Contact& contact, Up up) {
  const bool crosses = !contact.frames.empty();
  FOLDPROOF_TRY(read(crosses ? contact.frames[contact.worst].time : contact.first_time));
  const auto shown = meshes();
  if (crosses) return view_of(shown, marks_of(contact, shown), contact.curves, contact.normal, up);
  return contact.normal == Vec3::Zero() ? default_view(up) : view_along(contact.normal, up);
}

Result<std::string> ContactPictures::draw(const Contact& contact, const Format& format) {
  const View direction = FOLDPROOF_TRY(view(contact, up_));  // reads the pose
  Panel whole{.meshes = meshes(), .view = direction};
  const ContactMarks marks = marks_of(contact, whole.meshes);
  std::vector<std::vector<Color>> colors;
  for (std::size_t i = 0; i < motions_.size(); ++i) {
    colors.emplace_back(marks[i].size(), colors::kClay);
    for (std::size_t t = 0; t < marks[i].size(); ++t)
      if (marks[i][t]) colors[i][t] = kSideColors[marks[i][t] - 1];
  }
  for (std::size_t i = 0; i < motions_.size(); ++i) whole.meshes[i].face_colors = colors[i];
  std::vector<Panel> panels{whole};
  const double size = box_.sizes().maxCoeff();
  const auto focus = focus_on(contact, size);
  if (focus && format.near) {
    panels.push_back(whole);
    panels.back().view.focus = focus;
    if (!contact.frames.empty()) {
      const double radius = focus->radius / 150;
      panels.back().points.push_back(dots_along(contact, radius));
      panels.back().points.back().size = std::clamp(radius / size, 1e-9, 1.0);
    } else {
      panels.back().points.push_back({.positions = {contact.point}, .size = 0.006});  // where they touch
    }
  }
  return png_of(panels, format);
}

Result<std::string> ContactPictures::draw_first_frame(const Format& format) {
  FOLDPROOF_TRY(read(frames_.front()));
  const Panel panel{.meshes = meshes(), .view = default_view(up_)};
  return png_of(std::span(&panel, 1), format);
}

}  // namespace foldproof
