/// Which axis of a motion points up, and from where it is best seen. page/src/shared/upright.ts has the same
/// rules for the page; tests/picture/upright.json holds cases for both.
#pragma once

#include "picture/picture.h"

namespace foldproof {

/// The box around positions (n x 3, row-major).
Eigen::AlignedBox3d box_of(std::span<const double> x);

/// Guesses the axis that points up from the boxes of some poses: z if the motion stands on a ground across z,
/// and on none across y; else y. It stands on a ground if its lowest point moves by at most 5 % of the
/// motion's size, a third of what it moves along the other axis, while something does move along this one.
Up guess_up(std::span<const Eigen::AlignedBox3d> poses);

/// What is known of motions before they are drawn.
struct MotionExtent {
  Up up = Up::Y;            ///< glTF says that y points up; a guess for other files.
  Eigen::AlignedBox3d box;  ///< Around 32 frames at most, evenly distributed, with the first and the last.
};
/// Precondition: at least one motion, of equally many frames. Error: a frame that cannot be read.
Result<MotionExtent> extent_of(std::span<const std::unique_ptr<Motion>> motions);

/// Turns a view of a scene with y up into the same view of a scene with `up`.
View upright(const View& view, Up up);
/// From the front, slightly from the right and from above.
View default_view(Up up);
/// Looks along a normal, but from at most 60 degrees above or below, where the picture would not be upright.
View view_along(const Vec3& normal, Up up);

/// Per mesh and triangle: 1 or 2 on one or the other side of a contact, 0 elsewhere.
using ContactMarks = std::vector<std::vector<std::uint8_t>>;

/// A view of a contact from the side: of the directions across its normal and around the meshes, that in
/// which most of both sides and of the curves between them is seen. `normal`: may be zero. Cost: that of 16
/// pictures of 200 x 175 pixels.
Result<View> view_of(std::span<const PictureMesh> meshes, const ContactMarks& marks,
                     std::span<const std::vector<Vec3>> curves, const Vec3& normal, Up up);

}  // namespace foldproof
