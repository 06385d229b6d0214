/// Pictures: triangle meshes drawn into PNG files, without a display.
///
/// A rasteriser with a depth buffer and nothing else: no window, no graphics driver, the same bytes every
/// time. It is here to show results, at some tens of milliseconds a picture; it is not a viewer.
#pragma once

#include <optional>
#include <vector>

#include "foldproof/io.h"

namespace foldproof {

/// sRGB, as files and screens have it.
struct Colour {
  std::uint8_t red = 0, green = 0, blue = 0;
  friend bool operator==(const Colour&, const Colour&) = default;
};

/// Colours that stay apart for the colour-blind (Okabe and Ito 2008, "Color Universal Design"), and clay.
namespace colours {
inline constexpr Colour kWhite{255, 255, 255}, kClay{196, 192, 186}, kRed{213, 44, 0}, kBlue{0, 114, 178},
    kSky{86, 180, 233}, kGreen{0, 158, 115}, kYellow{240, 228, 66}, kOrange{230, 159, 0},
    kPink{204, 121, 167};
}  // namespace colours

enum class ColourMap {
  Error,  ///< From pale grey over yellow and red to dark purple: 0 looks like a mesh without colours.
  Level   ///< From dark blue over green to pale yellow.
};

/// The colour for a value in [0,1]; others are cut to it, and what is no number gets 0's. Lightness runs
/// evenly from end to end (in Oklab, Ottosson 2020), so the order is there for the colour-blind and in grey
/// prints, too.
Colour map_colour(ColourMap map, double value);

/// A mesh in a picture. It refers to the caller's data, which must outlive the call that draws it.
struct PictureMesh {
  const Topology* topology = nullptr;
  std::span<const double> positions;            ///< vertex_count x 3, row-major, mesh units; finite.
  Colour colour = colours::kClay;               ///< Where there are no others.
  std::span<const Colour> face_colours = {};    ///< None, or one per triangle.
  std::span<const Colour> vertex_colours = {};  ///< None, or one per vertex; not together with face_colours.
  bool smooth = true;  ///< Normals blend over vertices; false: every triangle looks flat.
};

/// Small balls, drawn all in one size.
struct PicturePoints {
  std::vector<Vec3> positions;  ///< Mesh units; finite.
  Colour colour = colours::kRed;
  double size = 0.012;  ///< Radius as a share of the panel's largest extent, in (0, 1].
};

/// Where the eye is. The camera is fitted so that everything in the panel is seen.
struct View {
  Vec3 from{0, 0, 1};       ///< From the middle of things to the eye; any length.
  Vec3 up{0, 1, 0};         ///< What points up in the picture; not along `from`.
  bool perspective = true;  ///< A slight one; false: parallel lines stay parallel.
  /// Show only what is around here.
  struct Focus {
    Vec3 centre;
    double radius;  ///< Mesh units, > 0.
  };
  std::optional<Focus> focus = {};
};

/// "front" (the eye looks along -z), "back", "side" (along -x), "top" (along -y), or the direction x,y,z from
/// the middle of things to the eye. y points up, seen from the top -z.
Result<View> parse_view(const std::string& text);

/// One of the pictures in a picture.
struct Panel {
  std::vector<PictureMesh> meshes = {};
  std::vector<PicturePoints> points = {};
  View view = {};
};

struct PictureSettings {
  Index width = 1200, height = 900;  ///< Pixels, 1 to 16384 each, 2^26 together.
  Index samples = 3;                 ///< Anti-aliasing: samples^2 per pixel, 1 to 8.
  Colour background = colours::kWhite;
  Index columns = 0;       ///< Of panels, which fill rows from the top left. 0: so that panels are squarest.
  bool same_scale = true;  ///< All panels show the same length equally long, where they have no focus.
};

struct Image {
  Index width = 0, height = 0;
  std::vector<Colour> pixels;  ///< Rows from the top.
};

/// Draws panels side by side. Both sides of a triangle look alike; a triangle seen straight on has exactly
/// its colour, others are darker. Triangles that are hidden by none of the samples of a pixel may not be seen
/// at all. The same for any number of threads; uses the caller's oneTBB arena. Cost: 0.1 to 0.2 s of one core
/// for 70,000 triangles at 1,200 x 900. Error: sizes beyond their range or that do not fit, no panels,
/// numbers that are not finite, a view without a direction.
Result<Image> draw_picture(std::span<const Panel> panels, const PictureSettings& settings = {});

/// The bytes of a PNG (8-bit RGB, sRGB). Error: no pixels, or far too many.
Result<std::string> png_bytes(const Image& image);

/// A PNG file that appears whole or not at all. Error: it cannot be written.
Result<void> write_png(const std::string& path, const Image& image);

}  // namespace foldproof
