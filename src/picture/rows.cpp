// The rasterizer: finds the visible surface at each sample, shades it, and averages the samples of a pixel.
#include <algorithm>
#include <cmath>
#include <limits>

#include "picture/scene.h"

namespace foldproof::picture {
namespace {

/// Shading relative to a surface that faces the eye. The light comes from the eye's upper left, and wraps
/// around, so that shapes show in its shadow, too.
float brightness(const Eigen::Vector3f& normal) {
  static const Eigen::Vector3f light = Eigen::Vector3f(-0.45F, 0.55F, 1).normalized();
  const auto shade = [](float toward_light) {
    constexpr float kAmbient = 0.15F, kDirect = 0.85F;
    const float half = 0.5F + 0.5F * toward_light;
    return kAmbient + kDirect * half * half;
  };
  return shade(normal.dot(light)) / shade(light.z());
}

/// Twice the signed area of a triangle on screen, positive if it turns from x to y.
double signed_area2(const ScreenPoint& a, const ScreenPoint& b, double x, double y) {
  return (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x);
}

/// The edge function of a triangle: not negative inside, and in a margin outside, so that rounding leaves no
/// gap between triangles with a common edge.
struct EdgeFunction {
  static constexpr double kOverlap = 1e-6;  // samples
  double dx, dy, constant;
  EdgeFunction(const ScreenPoint& from, const ScreenPoint& to, double sign) {
    dx = sign * (from.y - to.y);
    dy = sign * (to.x - from.x);
    constant = kOverlap * (std::abs(dx) + std::abs(dy)) - (dx * from.x + dy * from.y);
  }
  double row(double y) const { return constant + dy * y; }
};

class Rows {
 public:
  Rows(const Scene& scene, Index samples, std::array<Index, 2> rows)
      : scene_(scene),
        top_(rows[0] * samples),
        width_(scene.area.width * samples),
        height_((rows[1] - rows[0]) * samples),
        depth_(std::size_t{width_} * height_, -std::numeric_limits<float>::infinity()),
        visible_(depth_.size(), kNoIndex) {}

  void draw_face(Index number) {
    const Triangle& corners = scene_.faces[number].vertices;
    const ScreenPoint &a = scene_.vertices[corners[0]], &b = scene_.vertices[corners[1]],
                      &c = scene_.vertices[corners[2]];
    const double area = signed_area2(a, b, c.x, c.y);
    if (!(area != 0)) return;
    const double sign = area > 0 ? 1 : -1;
    const EdgeFunction edge_a(b, c, sign), edge_b(c, a, sign), edge_c(a, b, sign);
    const Range columns = range(std::min({a.x, b.x, c.x}), std::max({a.x, b.x, c.x}), 0, width_);
    const Range lines = range(std::min({a.y, b.y, c.y}), std::max({a.y, b.y, c.y}), top_, height_);
    for (Index line = lines.begin; line < lines.end; ++line) {
      const double y = top_ + line + 0.5;
      const double row_a = edge_a.row(y), row_b = edge_b.row(y), row_c = edge_c.row(y);
      for (Index column = columns.begin; column < columns.end; ++column) {
        const double x = column + 0.5;
        const double weight_a = row_a + edge_a.dx * x, weight_b = row_b + edge_b.dx * x,
                     weight_c = row_c + edge_c.dx * x;
        if (weight_a < 0 || weight_b < 0 || weight_c < 0) continue;
        write_sample(
            line, column,
            (weight_a * a.reversed_depth + weight_b * b.reversed_depth + weight_c * c.reversed_depth) /
                (weight_a + weight_b + weight_c),
            number);
      }
    }
  }

  void draw_sphere(Index number) {
    const Sphere& sphere = scene_.spheres[number];
    const Range columns = range(sphere.center.x - sphere.radius, sphere.center.x + sphere.radius, 0, width_);
    const Range lines =
        range(sphere.center.y - sphere.radius, sphere.center.y + sphere.radius, top_, height_);
    for (Index line = lines.begin; line < lines.end; ++line) {
      for (Index column = columns.begin; column < columns.end; ++column) {
        const Eigen::Vector3f normal = sphere_normal(sphere, column + 0.5, top_ + line + 0.5);
        if (normal.z() < 0) continue;
        write_sample(line, column, scene_.camera.nearer(sphere.center, sphere.world_radius * normal.z()),
                     static_cast<Index>(scene_.faces.size()) + number);
      }
    }
  }

  /// None: the background.
  std::optional<LinearColor> color(Index line, Index column) const {
    const Index number = visible_[std::size_t{line} * width_ + column];
    if (number == kNoIndex) return std::nullopt;
    const double x = column + 0.5, y = top_ + line + 0.5;
    if (number < scene_.faces.size()) return color_of_face(scene_.faces[number], x, y);
    const Sphere& sphere = scene_.spheres[number - scene_.faces.size()];
    return LinearColor(sphere.color * brightness(sphere_normal(sphere, x, y)));
  }

 private:
  struct Range {
    Index begin, end;
  };

  /// The samples with their center in [min, max], relative to `first`.
  static Range range(double min, double max, Index first, Index count) {
    const double begin = std::clamp(std::ceil(min - 0.5) - first, 0.0, double{1} * count);
    const double end = std::clamp(std::floor(max - 0.5) + 1 - first, 0.0, double{1} * count);
    return {static_cast<Index>(begin), static_cast<Index>(end)};
  }

  /// Depth test and write.
  void write_sample(Index line, Index column, double reversed_depth, Index number) {
    const std::size_t sample = std::size_t{line} * width_ + column;
    const auto depth = static_cast<float>(reversed_depth);
    if (depth <= depth_[sample]) return;
    depth_[sample] = depth;
    visible_[sample] = number;
  }

  /// z is negative outside.
  static Eigen::Vector3f sphere_normal(const Sphere& sphere, double x, double y) {
    const double across = (x - sphere.center.x) / sphere.radius, up = (sphere.center.y - y) / sphere.radius;
    const double square = 1 - across * across - up * up;
    return Eigen::Vector3d(across, up, square < 0 ? -1 : std::sqrt(square)).cast<float>();
  }

  LinearColor color_of_face(const Face& face, double x, double y) const {
    const ScreenPoint &a = scene_.vertices[face.vertices[0]], &b = scene_.vertices[face.vertices[1]],
                      &c = scene_.vertices[face.vertices[2]];
    const double area = signed_area2(a, b, c.x, c.y);
    const double sign = area > 0 ? 1 : -1;
    const std::array<double, 3> weight{signed_area2(b, c, x, y), signed_area2(c, a, x, y),
                                       signed_area2(a, b, x, y)};
    Eigen::Vector3f normal = Eigen::Vector3f::Zero();
    for (int k = 0; k < 3; ++k) {
      // A sample at the edge may be outside by EdgeFunction::kOverlap.
      normal += static_cast<float>(std::max(sign * weight[k], 1e-12)) * scene_.normals[face.normals[k]];
    }
    // y points down, so a counterclockwise triangle, whose normal points to the eye, has a negative area.
    if (area > 0) normal = -normal;
    normal.normalize();
    // Near the silhouette, interpolated normals may point away from the eye.
    if (normal.z() < 0) normal = Eigen::Vector3f(normal.x(), normal.y(), 0).normalized();
    return scene_.colors[face.color] * brightness(normal);
  }

  const Scene& scene_;
  Index top_;             // the first line of samples
  Index width_, height_;  // samples
  std::vector<float> depth_;
  std::vector<Index> visible_;  // face, or number of faces + sphere, or kNoIndex
};

}  // namespace

void draw_rows(const Scene& scene, Index samples, std::optional<Color> background, std::array<Index, 2> rows,
               std::span<const Index> faces, std::span<const Index> spheres, Image& image) {
  Rows drawn(scene, samples, rows);
  for (const Index face : faces) drawn.draw_face(face);
  for (const Index sphere : spheres) drawn.draw_sphere(sphere);
  const LinearColor behind = to_linear(background.value_or(Color{}));  // black adds nothing
  const auto count = static_cast<float>(samples * samples);
  for (Index row = rows[0]; row < rows[1]; ++row) {
    const std::size_t first = std::size_t{scene.area.y + row} * image.width + scene.area.x;
    for (Index column = 0; column < scene.area.width; ++column) {
      LinearColor sum = LinearColor::Zero();
      float covered = 0;
      for (Index line = 0; line < samples; ++line) {
        for (Index k = 0; k < samples; ++k) {
          const auto color = drawn.color((row - rows[0]) * samples + line, column * samples + k);
          covered += color ? 1.0F : 0.0F;
          sum += color.value_or(behind);
        }
      }
      const float weight = background ? count : std::max(covered, 1.0F);
      image.pixels[first + column] = to_color(sum / weight);
      if (!background)
        image.alpha[first + column] = static_cast<std::uint8_t>(std::lround(255 * covered / count));
    }
  }
}

}  // namespace foldproof::picture
