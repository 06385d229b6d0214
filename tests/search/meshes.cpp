#include "search/meshes.h"

#include <cmath>
#include <numbers>

#include "certificate/patches.h"
#include "oracle/data.h"

namespace foldproof::search {

using testing::PosedPatch;
using testing::Rng;
using testing::sheet;
using testing::uniform;

namespace {

// Vertices `columns` apart in a row become one: a sheet is closed to a tube.
SearchMesh as_mesh(const PosedPatch& patch, int closed_columns = 0) {
  std::vector<Triangle> triangles;
  std::vector<double> positions;
  const auto number = [&](Index v) {
    if (closed_columns == 0) return v;
    const Index row = static_cast<Index>(closed_columns) + 1;
    return v % row == row - 1 ? v - (row - 1) : v;
  };
  for (const auto& t : patch.patch.triangles) triangles.push_back({number(t[0]), number(t[1]), number(t[2])});
  for (const Vec3& p : patch.x) positions.insert(positions.end(), {p.x(), p.y(), p.z()});
  return {patch.name, Topology::make(static_cast<Index>(patch.x.size()), std::move(triangles)).value(),
          std::move(positions)};
}

}  // namespace

std::vector<SearchMesh> generated_meshes() {
  constexpr double kTurn = 2 * std::numbers::pi;
  Rng rng(71);
  std::vector<SearchMesh> all;
  all.push_back(
      as_mesh(sheet("flat_cloth", 16, 16, [](double u, double v) { return Vec3(u - 0.5, v - 0.5, 0); })));
  all.push_back(as_mesh(sheet("cylinder", 24, 16,
                              [](double u, double v) {
                                return Vec3(0.2 * std::cos(kTurn * u), 0.2 * std::sin(kTurn * u), v - 0.5);
                              }),
                        24));
  all.push_back(as_mesh(sheet("bumpy_sphere", 24, 16,
                              [](double u, double v) {
                                const double polar = kTurn / 2 * (0.04 + 0.92 * v);
                                const double r = 0.4 + 0.03 * std::sin(9 * kTurn * u) * std::sin(15 * polar);
                                return Vec3(r * std::sin(polar) * std::cos(kTurn * u),
                                            r * std::sin(polar) * std::sin(kTurn * u), r * std::cos(polar));
                              }),
                        24));
  all.push_back(as_mesh(sheet("crumpled_sheet", 20, 20, [&](double u, double v) {
    const double height = 0.04 * std::sin(23 * u + 3 * std::sin(11 * v)) + 0.03 * std::cos(19 * v - 7 * u);
    return Vec3(u - 0.5 + uniform(rng, -0.015, 0.015), v - 0.5 + uniform(rng, -0.015, 0.015),
                height + uniform(rng, -0.01, 0.01));
  })));
  all.push_back(as_mesh(sheet("hairpin", 32, 10, [](double u, double v) {
    // Up one side, round the bend, and down the other, close by.
    const double side = u < 0.5 ? -1 : 1, along = std::min(1.0, 12 * std::abs(u - 0.5));
    return Vec3(0.5 - 1.6 * std::abs(u - 0.5), v - 0.5, 0.02 * side * along);
  })));
  all.push_back(as_mesh(sheet("strip_with_a_half_turn", 40, 4, [](double u, double v) {
    const double around = 0.97 * kTurn * u, half = around / 2, across = 0.2 * (v - 0.5);
    const double r = 0.35 + across * std::cos(half);
    return Vec3(r * std::cos(around), r * std::sin(around), across * std::sin(half));
  })));
  all.push_back(as_mesh(sheet("slivers", 24, 12, [](double u, double v) {
    return Vec3(u * u * u - 0.5, v - 0.5, 0.02 * std::sin(15 * v));
  })));
  return all;
}

std::vector<SearchMesh> real_meshes() {
  const auto data = oracle::data_directory();
  std::vector<SearchMesh> all;
  if (!data) return all;
  const std::pair<const char*, const char*> files[] = {{"hand", "hand/hand-anim.obj"},
                                                       {"horse", "horse-gallop/horse-gallop.obj"},
                                                       {"samba", "samba/samba.obj"},
                                                       {"lion", "lion-poses/pose_00.obj"},
                                                       {"elephant", "elephant/elephant-gallop.obj"}};
  for (const auto& [name, file] : files) {
    const auto motion = oracle::open_motion({(*data / file).string()});
    SearchMesh mesh{name, motion->topology(), std::vector<double>(3 * motion->topology().vertex_count())};
    if (motion->read_frame(0, mesh.positions)) all.push_back(std::move(mesh));
  }
  return all;
}

}  // namespace foldproof::search
