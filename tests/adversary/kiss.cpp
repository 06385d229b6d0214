#include "adversary/kiss.h"

#include <Eigen/Geometry>
#include <utility>

namespace foldproof::adversary {
namespace {

// Integer directions of integer length, with two that are across.
struct Direction {
  int n[3], u[3], v[3], length;
};
constexpr Direction kDirections[] = {
    {{0, 0, 1}, {1, 0, 0}, {0, 1, 0}, 1},   {{1, 2, 2}, {2, -1, 0}, {0, 1, -1}, 3},
    {{2, 3, 6}, {3, -2, 0}, {0, 2, -1}, 7}, {{0, 3, 4}, {1, 0, 0}, {0, 4, -3}, 5},
    {{4, 4, 7}, {1, -1, 0}, {7, 0, -4}, 9}, {{1, 4, 8}, {4, -1, 0}, {0, 2, -1}, 9}};

Vec3 vec(const int (&x)[3]) { return {double(x[0]), double(x[1]), double(x[2])}; }

class Maker {
 public:
  explicit Maker(Source& source)
      : source_(source),
        direction_(kDirections[source.pick(std::size(kDirections))]),
        wide_(std::ldexp(1, source.whole(3, 34))),
        high_(std::ldexp(1, source.whole(3, 34))) {}

  Kiss make() {
    Kiss kiss;
    if (source_.one_in(6)) {
      in_one_plane(kiss);
      return kiss;
    }
    const double off = source_.one_in(2) ? 0 : std::floor(wide_ * source_.spread(1e-8, 2)) + 1;
    kiss.thickness = off * direction_.length;
    kiss.across = vec(direction_.n);
    const Vec3 apart = off * kiss.across;
    if (source_.one_in(2)) {
      vertex_and_face(kiss, apart);
    } else {
      edge_and_edge(kiss, apart);
    }
    if (source_.one_in(2)) std::swap(kiss.objects[0], kiss.objects[1]);
    return kiss;
  }

 private:
  // A multiple of four in the plane.
  Vec3 in_plane(double size) {
    const auto number = [&] { return 4 * std::round(source_.real(-size, size)); };
    const double a = number(), b = number();
    return a * vec(direction_.u) + b * vec(direction_.v);
  }
  // Beyond the plane, on the side of n or against it.
  Vec3 beyond(double side) {
    return in_plane(wide_ * source_.spread(1e-3, 1)) +
           side * std::ceil(high_ * source_.spread(1e-4, 1)) * vec(direction_.n);
  }
  void add_triangle(Mesh& mesh, const Vec3& a, const Vec3& b, const Vec3& c) {
    const auto v = static_cast<Index>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), {a, b, c});
    mesh.triangles.push_back({v, v + 1, v + 2});
  }
  // More triangles on the far side, with a corner in common or not.
  void add_company(Mesh& mesh, const Vec3& common, double side) {
    for (int k = source_.whole(0, 6); k > 0; --k)
      add_triangle(mesh, source_.one_in(2) ? common : Vec3(common + beyond(side)), common + beyond(side),
                   common + beyond(side));
  }

  void vertex_and_face(Kiss& kiss, const Vec3& apart) {
    const Vec3 a = in_plane(wide_), b = in_plane(wide_), c = in_plane(wide_ * source_.spread(1e-6, 1));
    const Vec3 foot = a / 2 + b / 4 + c / 4;
    add_triangle(kiss.objects[0], a, b, c);
    add_company(kiss.objects[0], a, -1);
    add_triangle(kiss.objects[1], foot + apart, foot + apart + beyond(1), foot + apart + beyond(1));
    add_company(kiss.objects[1], foot + apart, 1);
  }

  void edge_and_edge(Kiss& kiss, const Vec3& apart) {
    const Vec3 a = in_plane(wide_), b = in_plane(wide_ * source_.spread(1e-6, 1));
    add_triangle(kiss.objects[0], a, -a, beyond(-1));
    add_company(kiss.objects[0], a, -1);
    add_triangle(kiss.objects[1], b + apart, -b + apart, apart + beyond(1));
    add_company(kiss.objects[1], b + apart, 1);
  }

  // The corner of one triangle is beside the side of another, on this side or that, by so little that doubles
  // do not tell: two sides of a triangle, integers without a common factor, make an area of one unit.
  void in_one_plane(Kiss& kiss) {
    kiss.across = vec(direction_.u);
    double far[2] = {1, 0}, near[2] = {0, 1};
    for (const double most = std::ldexp(1, source_.whole(4, 36)); std::max(far[0], far[1]) < most;) {
      const double times = source_.whole(1, 5);
      for (int k = 0; k < 2; ++k) near[k] = std::exchange(far[k], times * far[k] + near[k]);
    }
    const auto at = [&](double along, double away) -> Vec3 {
      return (along * far[0] - away * far[1]) * vec(direction_.u) +
             (along * far[1] + away * far[0]) * vec(direction_.v);
    };
    const Vec3 corner = near[0] * vec(direction_.u) + near[1] * vec(direction_.v);
    const auto along = [&] { return double(source_.whole(-3, 3)); };
    const double side = source_.sign();
    add_triangle(kiss.objects[0], at(0, 0), at(1, 0), at(along(), side * source_.whole(1, 3)));
    add_triangle(kiss.objects[1], corner, corner + at(along(), -side * source_.whole(1, 3)),
                 corner + at(along(), -side * source_.whole(1, 3)));
  }

  Source& source_;
  const Direction& direction_;
  double wide_, high_;
};

}  // namespace

Kiss make_kiss(Source& source) { return Maker(source).make(); }

Kiss make_tiny_kiss(Source& source) {
  const double side = std::ldexp(source.real(1, 2), -source.whole(255, 275)), up = source.real(1, 2);
  Kiss kiss;
  kiss.objects[0].vertices = {Vec3::Zero(), Vec3(side, 0, 0), Vec3(0, side * source.real(0.1, 2), 0)};
  kiss.objects[1].vertices = {Vec3(0, 0, up), Vec3(1, 0, 2 * up), Vec3(0, 1, 2 * up)};
  for (Mesh& mesh : kiss.objects) mesh.triangles = {{0, 1, 2}};
  kiss.thickness = up * (1 + (source.one_in(4) ? 0 : source.spread(1e-9, 0.3)));
  return kiss;
}

}  // namespace foldproof::adversary
