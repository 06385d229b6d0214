/// Makes the motions that `./dev demo` checks: a bending cylinder, computed, and an armadillo from CGAL's
/// demo data, posed with CGAL's surface-mesh deformation. Both are generated data, made to collide.
#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_deformation.h>
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "foldproof/eigen.h"
#include "foldproof/io.h"

namespace foldproof {
namespace {

using std::numbers::pi;
using Frames = std::vector<std::vector<double>>;

/// 0 to 1 with no jerk at either end.
double ease(double t) { return t * t * (3 - 2 * t); }

// --- The cylinder
// -------------------------------------------------------------------------------------------------

constexpr Index kAround = 80, kAlong = 126, kCylinderFrames = 33;
constexpr double kRadius = 0.5, kLength = 10;
constexpr double kFullBend = 1.15 * pi;  // Past a half turn the two legs close in on each other.

std::vector<Triangle> cylinder_triangles() {
  const Index rings = kAlong + 1, first_cap = rings * kAround, last_cap = first_cap + 1;
  std::vector<Triangle> triangles;
  for (Index i = 0; i < kAround; ++i) {
    const Index j = (i + 1) % kAround;
    for (Index ring = 0; ring < kAlong; ++ring) {
      const Index low = ring * kAround, high = low + kAround;
      triangles.push_back({low + i, low + j, high + j});
      triangles.push_back({low + i, high + j, high + i});
    }
    triangles.push_back({j, i, first_cap});
    triangles.push_back({kAlong * kAround + i, kAlong * kAround + j, last_cap});
  }
  return triangles;
}

/// How far the axis has turned at arc length s: all in the middle third, evenly.
double turned(double s, double bend) {
  return bend * std::clamp((s - kLength / 3) / (kLength / 3), 0.0, 1.0);
}

std::vector<double> cylinder_frame(double bend) {
  std::vector<double> positions;
  const auto add = [&](double x, double y, double z) { positions.insert(positions.end(), {x, y, z}); };
  std::vector<std::array<double, 2>> axis;
  double x = 0, y = 0;
  const double ds = kLength / kAlong;
  for (Index ring = 0; ring <= kAlong; ++ring) {
    axis.push_back({x, y});
    const double angle = turned((ring + 0.5) * ds, bend);
    x += ds * std::cos(angle);
    y += ds * std::sin(angle);
  }
  for (Index ring = 0; ring <= kAlong; ++ring) {
    const double angle = turned(ring * ds, bend);
    for (Index i = 0; i < kAround; ++i) {
      const double around = 2 * pi * i / kAround, side = kRadius * std::cos(around);
      add(axis[ring][0] - side * std::sin(angle), axis[ring][1] + side * std::cos(angle),
          kRadius * std::sin(around));
    }
  }
  add(axis.front()[0], axis.front()[1], 0);
  add(axis.back()[0], axis.back()[1], 0);
  return positions;
}

Result<std::unique_ptr<Motion>> cylinder() {
  auto topology = Topology::make((kAlong + 1) * kAround + 2, cylinder_triangles());
  if (!topology) return tl::unexpected(topology.error());
  Frames frames;
  for (Index k = 0; k < kCylinderFrames; ++k) {
    frames.push_back(cylinder_frame(kFullBend * ease(k / (kCylinderFrames - 1.0))));
  }
  return memory_motion("bending cylinder", std::move(*topology), std::move(frames));
}

// --- The armadillo
// ------------------------------------------------------------------------------------------------

using Point = CGAL::Simple_cartesian<double>::Point_3;
using Mesh = CGAL::Surface_mesh<Point>;
using Deformation = CGAL::Surface_mesh_deformation<Mesh>;

constexpr Index kArmadilloFrames = 25;
constexpr int kIterations = 12;

/// Vertices within `radius` of `center` are led around an axis through `pivot`, up to `angle`.
struct Limb {
  Vec3 center;
  double radius;
  Vec3 pivot, axis;
  double angle;
};

// Places read off the mesh: x to its left and right, y up, -z where it looks.
const Limb kLimbs[] = {
    {{-52, 75, -42}, 16, {-30, 58, -2}, {0.1, -1, 0}, 1.3},  // hands swing in and meet before the snout
    {{52, 75, -42}, 16, {30, 58, -2}, {0.1, 1, 0}, 1.3},
    {{-35, -48, 12}, 22, {-25, 12, 12}, {-1, 0, 0.25}, 0.8},  // one leg swings back
    {{35, -48, 12}, 22, {25, 12, 12}, {1, 0, 0}, 0},          // the standing foot
    {{0, -8, 52}, 12, {0, 5, 32}, {0, 1, 0}, 0.9},            // the tail wags
};

bool in_torso(const Vec3& p) { return std::abs(p.x()) < 22 && p.y() > 35 && p.y() < 90 && p.z() > 0; }

Vec3 to_vec(const Point& p) { return {p.x(), p.y(), p.z()}; }

std::vector<double> positions_of(const Mesh& mesh) {
  std::vector<double> positions;
  for (const auto v : mesh.vertices()) {
    for (int k = 0; k < 3; ++k) positions.push_back(mesh.point(v)[k]);
  }
  return positions;
}

Result<Mesh> mesh_of(Motion& motion) {
  std::vector<double> positions(std::size_t{motion.topology().vertex_count()} * 3);
  if (const auto done = motion.read_frame(0, positions); !done) return tl::unexpected(done.error());
  Mesh mesh;
  for (std::size_t k = 0; k < positions.size(); k += 3) {
    mesh.add_vertex(Point(positions[k], positions[k + 1], positions[k + 2]));
  }
  for (const Triangle& t : motion.topology().triangles()) {
    const auto face =
        mesh.add_face(Mesh::Vertex_index(t[0]), Mesh::Vertex_index(t[1]), Mesh::Vertex_index(t[2]));
    if (face == Mesh::null_face()) {
      return fail(motion.name(), "is not a manifold mesh, and only such a mesh can be posed",
                  "use another mesh");
    }
  }
  return mesh;
}

Result<std::unique_ptr<Motion>> armadillo(const std::string& path) {
  const std::string arguments[] = {path};
  auto opened = open_motions(arguments);
  if (!opened) return tl::unexpected(opened.error());
  auto read = mesh_of(*opened->front());
  if (!read) return tl::unexpected(read.error());
  Mesh& mesh = *read;
  Deformation deformation(mesh);
  deformation.insert_roi_vertices(mesh.vertices().begin(), mesh.vertices().end());
  struct Handle {
    Mesh::Vertex_index vertex;
    Vec3 rest;
    const Limb* limb;
  };
  std::vector<Handle> handles;
  for (const auto v : mesh.vertices()) {
    const Vec3 p = to_vec(mesh.point(v));
    if (in_torso(p)) deformation.insert_control_vertex(v);
    for (const Limb& limb : kLimbs) {
      if ((p - limb.center).norm() > limb.radius) continue;
      deformation.insert_control_vertex(v);
      handles.push_back({v, p, &limb});
    }
  }
  if (!deformation.preprocess())
    return fail(path, "cannot be posed: the equations have no solution", "use another mesh");

  Frames frames;
  for (Index k = 0; k < kArmadilloFrames; ++k) {
    const double part = ease(k / (kArmadilloFrames - 1.0));
    for (const Handle& handle : handles) {
      const Eigen::AngleAxisd turn(part * handle.limb->angle, to_eigen(handle.limb->axis.normalized()));
      const Vec3 p = handle.limb->pivot + to_vec3(turn * to_eigen(handle.rest - handle.limb->pivot));
      deformation.set_target_position(handle.vertex, Point(p.x(), p.y(), p.z()));
    }
    deformation.deform(kIterations, 0);
    frames.push_back(positions_of(mesh));
    fmt::print("{}{}", k == 0 ? "  frames: " : " ", k + 1);
    std::fflush(stdout);
  }
  fmt::print("\n");
  return memory_motion("armadillo", opened->front()->topology(), std::move(frames));
}

int run(std::span<const std::string> arguments) {
  const bool is_cylinder = arguments.size() == 2 && arguments[0] == "cylinder";
  const bool is_armadillo = arguments.size() == 3 && arguments[0] == "armadillo";
  if (!is_cylinder && !is_armadillo) {
    fmt::print(stderr,
               "usage: demo_poses cylinder OUT.npz\n       demo_poses armadillo ARMADILLO.off OUT.npz\n");
    return 2;
  }
  auto motion = is_cylinder ? cylinder() : armadillo(arguments[1]);
  const auto done =
      motion ? write_npz(arguments.back(), **motion) : Result<void>(tl::unexpected(motion.error()));
  if (!done) {
    fmt::print(stderr, "demo_poses: {}\n", done.error().line());
    return 2;
  }
  return 0;
}

}  // namespace
}  // namespace foldproof

int main(int argc, char** argv) {
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  return foldproof::run(arguments);
}
