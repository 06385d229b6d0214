// The rasteriser: what is seen at each sample first, then its light, then the mean of each pixel's samples.
#include <algorithm>
#include <cmath>
#include <limits>

#include "picture/scene.h"

namespace foldproof::picture {
namespace {

/// How much of its colour a surface shows; 1 straight on. The light comes from the eye's upper left.
float brightness(const Eigen::Vector3f& normal) {
  static const Eigen::Vector3f towards = Eigen::Vector3f(-0.45F, 0.55F, 1).normalized();
  constexpr float kEverywhere = 0.22F, kDirect = 0.78F;
  const float straight_on = kEverywhere + kDirect * towards.z();
  return (kEverywhere + kDirect * std::max(0.0F, normal.dot(towards))) / straight_on;
}

/// Twice the signed area of a triangle of places, positive where it turns from x to y.
double turn(const Spot& a, const Spot& b, double x, double y) {
  return (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x);
}

/// A side of a triangle: not negative on the inside, and that far outside that rounding leaves no gap between
/// triangles with a common side.
struct Side {
  static constexpr double kOverlap = 1e-6;  // samples
  double dx, dy, constant;
  Side(const Spot& from, const Spot& to, double sign) {
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
        nearness_(std::size_t{width_} * height_, -std::numeric_limits<float>::infinity()),
        seen_(nearness_.size(), kNoIndex) {}

  void see_face(Index number) {
    const Triangle& corners = scene_.faces[number].corners;
    const Spot &a = scene_.spots[corners[0]], &b = scene_.spots[corners[1]], &c = scene_.spots[corners[2]];
    const double area = turn(a, b, c.x, c.y);
    if (!(area != 0)) return;
    const double sign = area > 0 ? 1 : -1;
    const Side of_a(b, c, sign), of_b(c, a, sign), of_c(a, b, sign);
    const Range columns = range(std::min({a.x, b.x, c.x}), std::max({a.x, b.x, c.x}), 0, width_);
    const Range lines = range(std::min({a.y, b.y, c.y}), std::max({a.y, b.y, c.y}), top_, height_);
    for (Index line = lines.begin; line < lines.end; ++line) {
      const double y = top_ + line + 0.5;
      const double row_a = of_a.row(y), row_b = of_b.row(y), row_c = of_c.row(y);
      for (Index column = columns.begin; column < columns.end; ++column) {
        const double x = column + 0.5;
        const double share_a = row_a + of_a.dx * x, share_b = row_b + of_b.dx * x,
                     share_c = row_c + of_c.dx * x;
        if (share_a < 0 || share_b < 0 || share_c < 0) continue;
        see(line, column,
            (share_a * a.nearness + share_b * b.nearness + share_c * c.nearness) /
                (share_a + share_b + share_c),
            number);
      }
    }
  }

  void see_ball(Index number) {
    const Ball& ball = scene_.balls[number];
    const Range columns = range(ball.spot.x - ball.radius, ball.spot.x + ball.radius, 0, width_);
    const Range lines = range(ball.spot.y - ball.radius, ball.spot.y + ball.radius, top_, height_);
    for (Index line = lines.begin; line < lines.end; ++line) {
      for (Index column = columns.begin; column < columns.end; ++column) {
        const Eigen::Vector3f normal = ball_normal(ball, column + 0.5, top_ + line + 0.5);
        if (normal.z() < 0) continue;
        see(line, column, scene_.camera.nearer(ball.spot, ball.length * normal.z()),
            static_cast<Index>(scene_.faces.size()) + number);
      }
    }
  }

  Light light(Index line, Index column, const Light& background) const {
    const Index number = seen_[std::size_t{line} * width_ + column];
    if (number == kNoIndex) return background;
    const double x = column + 0.5, y = top_ + line + 0.5;
    if (number < scene_.faces.size()) return light_of_face(scene_.faces[number], x, y);
    const Ball& ball = scene_.balls[number - scene_.faces.size()];
    return ball.light * brightness(ball_normal(ball, x, y));
  }

 private:
  struct Range {
    Index begin, end;
  };

  /// Samples with their middle in [least, most], counted from `first`.
  static Range range(double least, double most, Index first, Index count) {
    const double begin = std::clamp(std::ceil(least - 0.5) - first, 0.0, double{1} * count);
    const double end = std::clamp(std::floor(most - 0.5) + 1 - first, 0.0, double{1} * count);
    return {static_cast<Index>(begin), static_cast<Index>(end)};
  }

  void see(Index line, Index column, double nearness, Index number) {
    const std::size_t sample = std::size_t{line} * width_ + column;
    const auto value = static_cast<float>(nearness);
    if (value <= nearness_[sample]) return;
    nearness_[sample] = value;
    seen_[sample] = number;
  }

  /// z is negative outside.
  static Eigen::Vector3f ball_normal(const Ball& ball, double x, double y) {
    const double across = (x - ball.spot.x) / ball.radius, up = (ball.spot.y - y) / ball.radius;
    const double rest = 1 - across * across - up * up;
    return Eigen::Vector3d(across, up, rest < 0 ? -1 : std::sqrt(rest)).cast<float>();
  }

  Light light_of_face(const Face& face, double x, double y) const {
    const Spot &a = scene_.spots[face.corners[0]], &b = scene_.spots[face.corners[1]],
               &c = scene_.spots[face.corners[2]];
    const double area = turn(a, b, c.x, c.y);
    const double sign = area > 0 ? 1 : -1;
    std::array<double, 3> share{turn(b, c, x, y), turn(c, a, x, y), turn(a, b, x, y)};
    for (int k = 0; k < 3; ++k) {
      share[k] = std::max(sign * share[k], 1e-12);  // on the rim it may be outside by Side::kOverlap
      // What is affine in space is not in the picture.
      if (scene_.camera.perspective()) share[k] *= scene_.spots[face.corners[k]].nearness;
    }
    const double sum = share[0] + share[1] + share[2];
    Light light = Light::Zero();
    Eigen::Vector3f normal = Eigen::Vector3f::Zero();
    for (int k = 0; k < 3; ++k) {
      const auto part = static_cast<float>(share[k] / sum);
      light += part * scene_.lights[face.lights[k]];
      normal += part * scene_.normals[face.normals[k]];
    }
    // y runs down, so a triangle that turns to the left has its normal towards the eye here.
    if (area > 0) normal = -normal;
    normal.normalize();
    // Where normals blend, that of a triangle seen from the side may point away.
    if (normal.z() < 0) normal = Eigen::Vector3f(normal.x(), normal.y(), 0).normalized();
    return light * brightness(normal);
  }

  const Scene& scene_;
  Index top_;             // first line of samples
  Index width_, height_;  // samples
  std::vector<float> nearness_;
  std::vector<Index> seen_;  // face, or faces + ball, or kNoIndex
};

}  // namespace

void draw_rows(const Scene& scene, Index samples, Colour background, std::array<Index, 2> rows,
               std::span<const Index> faces, std::span<const Index> balls, Image& image) {
  Rows drawn(scene, samples, rows);
  for (const Index face : faces) drawn.see_face(face);
  for (const Index ball : balls) drawn.see_ball(ball);
  const Light behind = to_light(background);
  const float share = 1.0F / static_cast<float>(samples * samples);
  for (Index row = rows[0]; row < rows[1]; ++row) {
    Colour* pixels = &image.pixels[std::size_t{scene.area.y + row} * image.width + scene.area.x];
    for (Index column = 0; column < scene.area.width; ++column) {
      Light sum = Light::Zero();
      for (Index line = 0; line < samples; ++line) {
        for (Index k = 0; k < samples; ++k)
          sum += drawn.light((row - rows[0]) * samples + line, column * samples + k, behind);
      }
      pixels[column] = to_colour(sum * share);
    }
  }
}

}  // namespace foldproof::picture
