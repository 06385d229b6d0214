/// Renders triangle meshes to PNG files, without a display.
///
/// A software rasterizer with a depth buffer, for pictures of results: no window, no graphics driver, and the
/// same bytes every time.
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "foldproof/io.h"

namespace foldproof {

/// An sRGB color.
struct Color {
  std::uint8_t red = 0, green = 0, blue = 0;
  friend bool operator==(const Color&, const Color&) = default;
};

/// Colors that remain distinguishable with color vision deficiency (Okabe and Ito 2008, "Color Universal
/// Design"), and clay.
namespace colors {
inline constexpr Color kWhite{255, 255, 255}, kBlack{0, 0, 0}, kClay{196, 192, 186}, kRed{213, 44, 0},
    kBlue{0, 114, 178}, kSky{86, 180, 233}, kGreen{0, 158, 115}, kYellow{240, 228, 66}, kOrange{230, 159, 0},
    kPink{204, 121, 167};
}  // namespace colors

/// A mesh in a picture. It refers to the caller's data, which must outlive the call of draw_picture.
struct PictureMesh {
  const Topology* topology = nullptr;
  std::span<const double> positions;        ///< vertex_count x 3, row-major, mesh units; finite.
  Color color = colors::kClay;              ///< If there are none of the following.
  std::span<const Color> face_colors = {};  ///< None, or one per triangle.
  /// Normals are interpolated, except across edges where the surface turns by more than 60 degrees; false:
  /// flat shading.
  bool smooth = true;
};

/// Points, drawn as small spheres of one size.
struct PicturePoints {
  std::vector<Vec3> positions;  ///< Mesh units; finite.
  Color color = colors::kRed;
  double size = 0.012;  ///< Radius as a share of the panel's largest extent, in (0, 1].
};

/// The axis of the mesh that points up in pictures.
enum class Up : std::uint8_t { Y, Z };

/// The direction of the view. The camera is fitted so that everything in the panel is visible.
struct View {
  Vec3 from{0, 0, 1};       ///< From the content's center to the eye; any length.
  Vec3 up{0, 1, 0};         ///< Points up in the picture; not along `from`.
  bool perspective = true;  ///< A weak perspective; false: orthographic.
  /// Shows only the surroundings of a point.
  struct Focus {
    Vec3 center;
    double radius;  ///< Mesh units, > 0.
  };
  std::optional<Focus> focus = {};
  /// What the camera is fitted to, mesh units, such as the box of a whole motion; none: the panel's content.
  /// It must contain that.
  std::optional<Eigen::AlignedBox3d> fit = {};
};

/// Parses "front" (with y up, the eye looks along -z), "back", "side" (along -x), "top" (along -y), or the
/// direction x,y,z from the content's center to the eye. In views from the top, the back of the scene is up.
Result<View> parse_view(const std::string& text, Up up = Up::Y);

/// One of the views in a picture.
struct Panel {
  std::vector<PictureMesh> meshes = {};
  std::vector<PicturePoints> points = {};
  View view = {};
};

struct PictureSettings {
  Index width = 1200, height = 900;                  ///< Pixels, 1 to 16384 each, 2^26 together.
  Index samples = 3;                                 ///< Antialiasing: samples^2 per pixel, 1 to 8.
  std::optional<Color> background = colors::kWhite;  ///< None: transparent.
};

struct Image {
  Index width = 0, height = 0;
  std::vector<Color> pixels;             ///< Rows from the top.
  std::vector<std::uint8_t> alpha = {};  ///< Opacity of each pixel; or empty: all are opaque.
};

/// Draws panels side by side in a row, each with a scale of its own. Shading is two-sided: a triangle that
/// faces the eye has exactly its color, others are darker. Triangles smaller than the distance of samples may
/// be invisible. The same bytes for any number of threads; uses the caller's oneTBB arena. Cost: 0.1 to 0.2 s
/// of one core for 70,000 triangles at 1,200 x 900. Error: sizes out of range or inconsistent, no panels,
/// numbers that are not finite, a view without a direction.
Result<Image> draw_picture(std::span<const Panel> panels, const PictureSettings& settings = {});

/// Encodes a PNG (8-bit RGB or RGBA, sRGB). Error: no pixels, or too many.
Result<std::string> png_bytes(const Image& image);

/// A PNG file that appears whole or not at all. Error: it cannot be written.
Result<void> write_png(const std::string& path, const Image& image);

}  // namespace foldproof
