/// Pictures of contacts, for the HTML report and for sweeps.
#pragma once

#include "picture/upright.h"
#include "report/report.h"

namespace foldproof {

/// The colors of a contact's sides.
inline constexpr std::array<Color, 2> kSideColors{colors::kRed, colors::kBlue};

/// The size of dots on curves, as a share of a scene ...
inline constexpr double kDot = 0.0025;
/// ... and that of dots which do not bury a contact in a scene of this size.
double thin_dot(const Contact& contact, double size);
/// The curves of a contact as black dots, one at every `spacing`.
PicturePoints dots_along(const Contact& contact, double spacing);

/// The surroundings of a contact; none if they are not much smaller than the whole scene.
std::optional<View::Focus> focus_on(const Contact& contact, double size);

/// Which triangles of each mesh are of a contact's sides.
ContactMarks marks_of(const Contact& contact, std::span<const PictureMesh> meshes);

/// Reads a checked motion again and draws it on a transparent ground, which goes with light and dark pages.
class ContactPictures {
 public:
  /// Keeps a reference to both. Error: a frame that cannot be read.
  static Result<ContactPictures> open(Motions motions, const CheckSettings& settings);

  /// Pixels, and whether small contacts are shown a second time, from near.
  struct Format {
    Index width, height;
    bool near;
  };
  /// A PNG of a contact in its worst frame, or at its first impact if nothing crosses in a frame. Its
  /// sides have kSideColors. Cost: half a second for 70,000 triangles.
  Result<std::string> draw(const Contact& contact, const Format& format);
  /// The same without curves, of other motions of the same objects: the same triangles, from the same side,
  /// at the same time. `times`: of each of their frames, ascending, in frames of what was checked; not empty.
  Result<std::string> draw_in(Motions others, std::span<const double> times, const Contact& contact,
                              const Format& format);
  /// The direction from which draw() looks at a contact, if `up` points up.
  Result<View> view(const Contact& contact, Up up);
  Up up() const { return up_; }
  /// A PNG of the first frame.
  Result<std::string> draw_first_frame(const Format& format);

 private:
  struct Frames {
    Motions motions;
    std::vector<double> times;
    std::vector<Index> numbers;
  };
  ContactPictures(Frames checked, Up up) : checked_(std::move(checked)), up_(up) {}
  Result<void> read(const Frames& frames, double time);
  std::vector<PictureMesh> meshes() const;
  Result<std::string> draw_pose(const Contact& contact, const View& direction, bool shows_curves,
                                const Format& format) const;

  Frames checked_;
  Up up_;
  std::vector<std::vector<double>> pose_;  // per object
  Eigen::AlignedBox3d box_;                // around the pose
};

/// A PNG as the address of an <img>.
std::string data_url(std::string_view png);

}  // namespace foldproof
