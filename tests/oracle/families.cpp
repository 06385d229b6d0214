#include "oracle/families.h"

#include <array>
#include <cmath>

namespace foldproof::oracle {
namespace {

int integer(Rng& rng, int lo, int hi) { return std::uniform_int_distribution<int>(lo, hi)(rng); }
bool chance(Rng& rng, double probability) { return uniform(rng, 0, 1) < probability; }

Vec3 uniform_vector(Rng& rng, double size) {
  return {uniform(rng, -size, size), uniform(rng, -size, size), uniform(rng, -size, size)};
}
Vec3 integer_vector(Rng& rng, int size) {
  return {double(integer(rng, -size, size)), double(integer(rng, -size, size)),
          double(integer(rng, -size, size))};
}

// A pair at the moment of contact is spanned by two directions u and w. Vertex and face: corners 0, 4u, 4w
// and the vertex at i u + j w. Two edges: 0 to 4u and 0 to 4w, each shifted so that its point at i (or j)
// fourths is the origin. With integers 0 <= i, j (and i + j <= 4 for a face) the features touch.
FourPoints pose(Kind kind, const Vec3& u, const Vec3& w, double i, double j) {
  if (kind == Kind::VertexFace) return {i * u + j * w, Vec3::Zero(), 4 * u, 4 * w};
  return {-i * u, (4 - i) * u, -j * w, (4 - j) * w};
}

// The step that is in `contact` at time `when` (0, 1/2 or 1 where exactness matters) and moves by `motion` in
// all.
Case through(const FourPoints& contact, const FourPoints& motion, double when) {
  Case result;
  for (int k = 0; k < 4; ++k) {
    result.x0[k] = contact[k] - when * motion[k];
    result.x1[k] = contact[k] + (1 - when) * motion[k];
  }
  return result;
}

void shift_first(Kind kind, FourPoints& x, const Vec3& by) {
  x[0] += by;
  if (kind == Kind::EdgeEdge) x[1] += by;
}

struct Uv {
  double i, j;
};

// Fourths at which a pair meets: inside, or (for a miss, most often) outside.
Uv uniform_place(Kind kind, Rng& rng, double inside) {
  const bool hit = chance(rng, inside);
  while (true) {
    const Uv p = {uniform(rng, -4, 8), uniform(rng, -4, 8)};
    const bool in =
        p.i >= 0 && p.j >= 0 && (kind == Kind::VertexFace ? p.i + p.j <= 4 : p.i <= 4 && p.j <= 4);
    if (in == hit) return p;
  }
}
Uv integer_place(Kind kind, Rng& rng, double inside) {
  const bool hit = chance(rng, inside);
  while (true) {
    const Uv p = {double(integer(rng, -1, 5)), double(integer(rng, -1, 5))};
    const bool in =
        p.i >= 0 && p.j >= 0 && (kind == Kind::VertexFace ? p.i + p.j <= 4 : p.i <= 4 && p.j <= 4);
    if (in == hit) return p;
  }
}
// On the border of the feature: an edge or corner of the face, an end of an edge.
Uv border_place(Kind kind, Rng& rng) {
  const double along = integer(rng, 0, 4);
  if (kind == Kind::EdgeEdge) {
    const double end = integer(rng, 0, 1) * 4;
    return chance(rng, 0.5) ? Uv{end, along} : Uv{along, end};
  }
  switch (integer(rng, 0, 2)) {
    case 0:
      return {along, 0};
    case 1:
      return {0, along};
    default:
      return {along, 4 - along};
  }
}

FourPoints integer_motion(Rng& rng, int size) {
  FourPoints motion;
  for (Vec3& m : motion) m = 2 * integer_vector(rng, size);  // Even, so that half of it is on the grid.
  return motion;
}
FourPoints uniform_motion(Rng& rng, double size) {
  FourPoints motion;
  for (Vec3& m : motion) m = uniform_vector(rng, size);
  return motion;
}
double exact_time(Rng& rng) { return integer(rng, 0, 2) / 2.0; }

Case random_case(Kind kind, Rng& rng) {
  const Uv p = uniform_place(kind, rng, 0.5);
  const FourPoints contact = pose(kind, uniform_vector(rng, 1), uniform_vector(rng, 1), p.i, p.j);
  Case result = through(contact, uniform_motion(rng, 3), uniform(rng, 0, 1));
  const Vec3 center = uniform_vector(rng, 2);
  for (int k = 0; k < 4; ++k) {
    result.x0[k] += center;
    result.x1[k] += center;
  }
  return result;
}

Case grid_case(Kind kind, Rng& rng) {
  const Uv p = integer_place(kind, rng, 0.4);
  const FourPoints contact = pose(kind, integer_vector(rng, 2), integer_vector(rng, 2), p.i, p.j);
  return through(contact, integer_motion(rng, 4), exact_time(rng));
}

Case degenerate_case(Kind kind, Rng& rng) {
  Vec3 u = integer_vector(rng, 2), w = integer_vector(rng, 2);
  switch (integer(rng, 0, 3)) {
    case 0:
      u = Vec3::Zero();
      break;
    case 1:
      w = Vec3::Zero();
      break;
    case 2:
      u = w;
      break;
    default:
      w = integer(rng, -2, 2) * u;
      break;
  }
  FourPoints contact = pose(kind, u, w, integer(rng, 0, 4), integer(rng, 0, 4));
  if (chance(rng, 0.5)) shift_first(kind, contact, integer_vector(rng, 1));
  // Degenerate during the whole step: the corners of a face (or the ends of an edge) move together.
  FourPoints motion = integer_motion(rng, 4);
  const std::size_t face = 2;
  if (kind == Kind::VertexFace) motion[1] = motion[2];
  motion[3] = motion[face];
  if (kind == Kind::EdgeEdge) motion[1] = motion[0];
  return through(contact, motion, exact_time(rng));
}

Case touching_case(Kind kind, Rng& rng) {
  const Uv p = border_place(kind, rng);
  FourPoints contact = pose(kind, integer_vector(rng, 3), integer_vector(rng, 3), p.i, p.j);
  if (chance(rng, 0.55)) shift_first(kind, contact, integer_vector(rng, 2));
  // At the very start or end, or passing along the border in between.
  return through(contact, integer_motion(rng, 5), exact_time(rng));
}

Case coplanar_case(Kind kind, Rng& rng) {
  const Vec3 e0 = integer_vector(rng, 2), e1 = chance(rng, 0.2) ? Vec3(2 * e0) : integer_vector(rng, 2);
  const auto in_plane = [&](int size) {
    return Vec3(integer(rng, -size, size) * e0 + integer(rng, -size, size) * e1);
  };
  FourPoints contact = pose(kind, in_plane(2), in_plane(2), integer(rng, -1, 5), integer(rng, -1, 5));
  shift_first(kind, contact, in_plane(9));
  FourPoints motion;
  for (Vec3& m : motion) m = 2 * in_plane(6);
  return through(contact, motion, exact_time(rng));
}

Case sliding_case(Kind kind, Rng& rng) {
  const Vec3 u = integer_vector(rng, 3), w = integer_vector(rng, 3);
  FourPoints contact = pose(kind, u, w, integer(rng, 0, 2), integer(rng, 0, 2));
  if (chance(rng, 0.4)) shift_first(kind, contact, std::ldexp(1.0, -integer(rng, 1, 40)) * u.cross(w));
  // The second feature moves as a rigid body, the first slides along its plane.
  const Vec3 common = 2 * integer_vector(rng, 3),
             along = 2 * (integer(rng, -3, 3) * u + integer(rng, -3, 3) * w);
  FourPoints motion = {common + along, common, common, common};
  if (kind == Kind::EdgeEdge) motion[1] = motion[0];
  return through(contact, motion, exact_time(rng));
}

Case parallel_case(Kind kind, Rng& rng) {
  const int edges = kind == Kind::EdgeEdge ? 1 : 0;
  const Vec3 u = integer_vector(rng, 3),
             w = kind == Kind::EdgeEdge ? Vec3(integer(rng, -2, 2) * u) : integer_vector(rng, 3);
  FourPoints contact = pose(kind, u, w, integer(rng, -1 - edges, 5 + edges), integer(rng, 0, 3));
  if (chance(rng, 0.2)) shift_first(kind, contact, integer_vector(rng, 1));
  // Edges stay parallel; a vertex moves parallel to an edge of a face that spins around that edge.
  const Vec3 a = 2 * integer_vector(rng, 3), b = 2 * integer_vector(rng, 3);
  FourPoints motion = {a, b, b, b};
  if (kind == Kind::EdgeEdge) motion[1] = a;
  if (kind == Kind::VertexFace) {
    motion[0] = b + 2 * integer(rng, -2, 2) * u;
    motion[3] = a;
  }
  return through(contact, motion, exact_time(rng));
}

Case shared_plane_case(Kind kind, Rng& rng) {
  const auto flat = [&](int size) { return Vec3(integer(rng, -size, size), integer(rng, -size, size), 0); };
  FourPoints contact = pose(kind, flat(2), flat(2), integer(rng, -1, 5), integer(rng, -1, 5));
  if (chance(rng, 0.5)) shift_first(kind, contact, flat(2));
  FourPoints motion = integer_motion(rng, 4);
  if (chance(rng, 0.3)) {
    for (Vec3& m : motion) m[2] = motion[0].z();  // Stays in one plane, which moves.
  }
  return through(contact, motion, integer(rng, 0, 1));
}

Case scaled(Case c, double factor) {
  for (int k = 0; k < 4; ++k) {
    c.x0[k] *= factor;
    c.x1[k] *= factor;
  }
  return c;
}
Case huge_case(Kind kind, Rng& rng) {
  return scaled(random_case(kind, rng), std::ldexp(1.0, integer(rng, 300, 1000)));
}
Case tiny_case(Kind kind, Rng& rng) {
  return scaled(random_case(kind, rng), std::ldexp(1.0, -integer(rng, 300, 1060)));
}

Case far_case(Kind kind, Rng& rng) {
  const double distance = std::ldexp(1.0, integer(rng, 10, 45));
  const Vec3 center = uniform_vector(rng, distance),
             drift = chance(rng, 0.5) ? uniform_vector(rng, distance) : Vec3::Zero();
  Case c = random_case(kind, rng);
  for (int k = 0; k < 4; ++k) {
    c.x0[k] += center;
    c.x1[k] += center + drift;
  }
  return c;
}

Case fast_case(Kind kind, Rng& rng) {
  const Uv p = uniform_place(kind, rng, 0.5);
  const FourPoints contact = pose(kind, uniform_vector(rng, 1), uniform_vector(rng, 1), p.i, p.j);
  FourPoints motion = uniform_motion(rng, 1);
  shift_first(kind, motion, uniform_vector(rng, std::ldexp(1.0, integer(rng, 8, 24))));
  return through(contact, motion, uniform(rng, 0, 1));
}

// The second feature stands in the plane z = 0; the first stops a controlled distance above or below it, or
// passes its border a controlled distance inside or outside.
Case near_miss_case(Kind kind, Rng& rng) {
  const Vec3 u(1 + uniform(rng, 0, 1), uniform(rng, -0.5, 0.5), 0),
      w(uniform(rng, -0.5, 0.5), 1 + uniform(rng, 0, 1), 0);
  const double gap = std::ldexp(uniform(rng, -1, 1), -integer(rng, 1, 50));
  const Vec3 fall(uniform(rng, -1, 1), uniform(rng, -1, 1), uniform(rng, -3, -1));
  FourPoints motion = {fall, Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
  if (kind == Kind::EdgeEdge) motion[1] = fall;
  FourPoints contact;
  if (chance(rng, 0.5)) {
    const double i = uniform(rng, 0.1, 3.5),
                 j = kind == Kind::EdgeEdge ? uniform(rng, 0.1, 3.9) : uniform(rng, 0.1, 3.9 - i);
    contact = pose(kind, u, w, i, j);
    shift_first(kind, contact, Vec3(0, 0, gap));
    return through(contact, motion, 1);
  }
  contact = pose(kind, u, w, uniform(rng, 0.1, 3.9), gap);
  return through(contact, motion, uniform(rng, 0.1, 0.9));
}

Case mixed_scale_case(Kind kind, Rng& rng) {
  const Uv p = uniform_place(kind, rng, 0.55);
  const Vec3 u = uniform_vector(rng, std::ldexp(1.0, integer(rng, -20, 20)));
  const Vec3 w = uniform_vector(rng, std::ldexp(1.0, integer(rng, -20, 20)));
  FourPoints motion;
  for (Vec3& m : motion) m = uniform_vector(rng, std::ldexp(1.0, integer(rng, -20, 20)));
  return through(pose(kind, u, w, p.i, p.j), motion, uniform(rng, 0, 1));
}

constexpr std::array<Family, 14> kFamilies = {{
    {"random", random_case, false},
    {"grid", grid_case, true},
    {"degenerate", degenerate_case, true},
    {"touching", touching_case, true},
    {"coplanar", coplanar_case, true},
    {"sliding", sliding_case, false},
    {"parallel", parallel_case, true},
    {"shared_plane", shared_plane_case, true},
    {"huge", huge_case, false},
    {"tiny", tiny_case, false},
    {"far", far_case, false},
    {"fast", fast_case, false},
    {"near_miss", near_miss_case, false},
    {"mixed_scale", mixed_scale_case, false},
}};

}  // namespace

std::span<const Family> families() { return kFamilies; }

}  // namespace foldproof::oracle
