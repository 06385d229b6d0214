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

/// The surroundings of a contact; none if they are not much smaller than the whole scene.
std::optional<View::Focus> focus_on(const Contact& contact, double size) {
  const double radius = std::max(0.6 * (contact.high - contact.low).norm(), 0.02 * size);
  if (!(radius < kSmallPart * size)) return std::nullopt;
  if (contact.frames.empty()) return View::Focus{contact.point, radius};
  return View::Focus{0.5 * (contact.low + contact.high), radius};
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

Result<std::string> ContactPictures::draw(const Contact& contact, const Format& format) {
  const bool crosses = !contact.frames.empty();
  FOLDPROOF_TRY(read(crosses ? contact.frames[contact.worst].time : contact.first_time));
  std::vector<std::vector<Color>> colors;
  std::vector<std::vector<std::uint8_t>> marked;
  for (const auto& motion : motions_) {
    colors.emplace_back(motion->topology().triangles().size(), colors::kClay);
    marked.emplace_back(colors.back().size(), 0);
  }
  for (std::size_t side = 0; side < 2; ++side) {
    const Contact::Side& s = contact.sides[side];
    for (const Index triangle : s.triangles) {
      colors[s.object][triangle] = kSideColors[side];
      marked[s.object][triangle] = 1;
    }
  }
  Panel whole{.meshes = meshes()};
  for (std::size_t i = 0; i < motions_.size(); ++i) whole.meshes[i].face_colors = colors[i];
  whole.view = crosses ? FOLDPROOF_TRY(view_of(whole.meshes, marked, contact.normal, up_))
               : contact.normal == Vec3::Zero() ? default_view(up_)
                                                : view_along(contact.normal, up_);
  std::vector<Panel> panels{whole};
  const double size = box_.sizes().maxCoeff();
  const auto focus = focus_on(contact, size);
  if (focus && format.near) {
    panels.push_back(whole);
    panels.back().view.focus = focus;
    if (crosses) {
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
