#include "adversary/touching_pairs.h"

namespace foldproof::adversary {
namespace {

using oracle::Kind;

// Integer directions of integer length, with two that are across.
struct Direction {
  int n[3], u[3], v[3], length;
};
constexpr Direction kDirections[] = {
    {{0, 0, 1}, {1, 0, 0}, {0, 1, 0}, 1},   {{1, 2, 2}, {2, -1, 0}, {0, 1, -1}, 3},
    {{2, 3, 6}, {3, -2, 0}, {0, 2, -1}, 7}, {{0, 3, 4}, {1, 0, 0}, {0, 4, -3}, 5},
    {{4, 4, 7}, {1, -1, 0}, {7, 0, -4}, 9}, {{1, 4, 8}, {4, -1, 0}, {0, 2, -1}, 9}};

Vec3 vec(const int (&x)[3]) { return {double(x[0]), double(x[1]), double(x[2])}; }

void add_triangle(Mesh& mesh, const Vec3& a, const Vec3& b, const Vec3& c) {
  const auto v = static_cast<Index>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), {a, b, c});
  mesh.triangles.push_back({v, v + 1, v + 2});
}

class Maker {
 public:
  explicit Maker(Source& source)
      : source_(source),
        direction_(kDirections[source.pick(std::size(kDirections))]),
        wide_(std::ldexp(1, source.whole(3, 34))),
        high_(std::ldexp(1, source.whole(3, 34))) {}

  Contact contact() {
    const double off = source_.one_in(2) ? 0 : std::floor(wide_ * source_.spread(1e-8, 2)) + 1;
    Contact made;
    made.thickness = off * direction_.length;
    made.across = vec(direction_.n);
    const Vec3 apart = off * made.across;
    if (source_.one_in(2)) {
      const Vec3 a = in_plane(wide_), b = in_plane(wide_), c = in_plane(wide_ * source_.spread(1e-6, 1));
      made.points = {a / 2 + b / 4 + c / 4 + apart, a, b, c};
    } else {
      const Vec3 a = in_plane(wide_), b = in_plane(wide_ * source_.spread(1e-6, 1));
      made.kind = Kind::EdgeEdge;
      made.points = {a + apart, -a + apart, b, -b};
    }
    return made;
  }

  // A line through the origin in the plane, long on both sides, and a corner beside the origin.
  std::array<std::array<Vec3, 3>, 2> flat_pair() {
    const auto number = [&] { return double(1 + source_.pick(65535)); };
    const Vec3 u = vec(direction_.u), v = vec(direction_.v);
    const Vec3 along = source_.sign() * number() * u + source_.sign() * number() * v, away = u - v;
    const Vec3 corner = std::ldexp(1, -source_.whole(30, 60)) *
                        (source_.sign() * number() * u + source_.sign() * number() * v);
    const auto beyond = [&](double side) -> Vec3 {
      return source_.whole(-3, 3) * along +
             side * source_.whole(1, 3) * std::abs(along.x() + along.y() + along.z()) * away;
    };
    const double side = source_.sign();
    return {{{-number() * along, number() * along, beyond(side)},
             {corner, corner + beyond(-side), corner + beyond(-side)}}};
  }

  TouchingObjects objects() {
    TouchingObjects made;
    auto& [first, second] = made.objects;
    if (source_.one_in(6)) {
      const auto [a, b] = flat_pair();
      add_triangle(first, a[0], a[1], a[2]);
      add_triangle(second, b[0], b[1], b[2]);
      made.across = vec(direction_.u);
      return made;
    }
    const Contact c = contact();
    made.thickness = c.thickness;
    made.across = c.across;
    const FourPoints& p = c.points;
    if (c.kind == Kind::VertexFace) {
      add_triangle(first, p[0], p[0] + beyond(1), p[0] + beyond(1));
      add_triangle(second, p[1], p[2], p[3]);
    } else {
      add_triangle(first, p[0], p[1], p[0] + beyond(1));
      add_triangle(second, p[2], p[3], p[2] + beyond(-1));
    }
    add_company(first, 1);
    add_company(second, -1);
    if (source_.one_in(2)) std::swap(first, second);
    return made;
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
  // More triangles on the far side, with the first corner in common or not.
  void add_company(Mesh& mesh, double side) {
    const Vec3 common = mesh.vertices[0];
    for (int k = source_.whole(0, 6); k > 0; --k)
      add_triangle(mesh, source_.one_in(2) ? common : Vec3(common + beyond(side)), common + beyond(side),
                   common + beyond(side));
  }

  Source& source_;
  const Direction& direction_;
  double wide_, high_;
};

}  // namespace

Contact make_contact(Source& source) { return Maker(source).contact(); }

Contact make_tiny_contact(Source& source) {
  const double side = std::ldexp(source.real(1, 2), -source.whole(255, 275)), up = source.real(1, 2);
  Contact made;
  made.points = {Vec3(0, 0, up), Vec3::Zero(), Vec3(side, 0, 0), Vec3(0, side * source.real(0.1, 2), 0)};
  made.thickness = up * (1 + (source.one_in(4) ? 0 : source.spread(1e-9, 0.3)));
  return made;
}

// The vertex is half a corner and a quarter of each of the others, exactly.
Contact make_thin_contact(Source& source) {
  const double x = std::ldexp(1.0, source.whole(0, 99)), unit = std::ldexp(4.0, -source.whole(480, 600));
  const auto digits = [&] { return unit * (1 + source.pick(4000)); };
  const double p = digits(), q = digits(), r = digits(), s = digits();
  Contact made;
  made.points = {Vec3::Zero(), Vec3(x, -(p + r) / 2, -(q + s) / 2), Vec3(-x, p, q), Vec3(-x, r, s)};
  made.across = Vec3(1, 0, 0);
  return made;
}

std::array<std::array<Vec3, 3>, 2> make_flat_pair(Source& source) { return Maker(source).flat_pair(); }

TouchingObjects make_touching_objects(Source& source) { return Maker(source).objects(); }

TouchingObjects make_tiny_touching_objects(Source& source) {
  const Contact c = make_tiny_contact(source);
  const double up = c.points[0].z();
  TouchingObjects touching;
  add_triangle(touching.objects[0], c.points[1], c.points[2], c.points[3]);
  add_triangle(touching.objects[1], c.points[0], Vec3(1, 0, 2 * up), Vec3(0, 1, 2 * up));
  touching.thickness = c.thickness;
  return touching;
}

}  // namespace foldproof::adversary
