#include "contacts/scenes.h"

#include <cmath>
#include <map>
#include <numbers>

#include "mesh/grid.h"

namespace foldproof::oracle {

Mesh unit_sphere(Index divisions) {
  Mesh mesh;
  std::map<std::array<long, 3>, Index> known;
  const auto vertex = [&](const Vec3& on_octahedron) {
    const std::array<long, 3> key{std::lround(on_octahedron.x() * divisions),
                                  std::lround(on_octahedron.y() * divisions),
                                  std::lround(on_octahedron.z() * divisions)};
    const auto [at, is_new] = known.try_emplace(key, mesh.vertex_count);
    if (is_new) {
      const Vec3 p = on_octahedron.normalized();
      mesh.positions.insert(mesh.positions.end(), {p.x(), p.y(), p.z()});
      ++mesh.vertex_count;
    }
    return at->second;
  };
  for (int octant = 0; octant < 8; ++octant) {
    Vec3 x(octant & 1 ? -1 : 1, 0, 0), y(0, octant & 2 ? -1 : 1, 0);
    const Vec3 z(0, 0, octant & 4 ? -1 : 1);
    if (x.x() * y.y() * z.z() < 0) std::swap(x, y);
    const auto at = [&](Index i, Index k) {
      return vertex((double(divisions - i - k) * x + double(i) * y + double(k) * z) / double(divisions));
    };
    for (Index i = 0; i < divisions; ++i) {
      for (Index k = 0; i + k < divisions; ++k) {
        mesh.triangles.push_back({at(i, k), at(i + 1, k), at(i, k + 1)});
        if (i + k + 1 < divisions) mesh.triangles.push_back({at(i + 1, k), at(i + 1, k + 1), at(i, k + 1)});
      }
    }
  }
  return mesh;
}

Mesh torus(double large, double small, Index around, Index across) {
  Mesh mesh;
  mesh.vertex_count = around * across;
  for (Index i = 0; i < around; ++i) {
    for (Index k = 0; k < across; ++k) {
      const double u = 2 * std::numbers::pi * i / around, v = 2 * std::numbers::pi * k / across;
      const double r = large + small * std::cos(v);
      mesh.positions.insert(mesh.positions.end(), {r * std::cos(u), r * std::sin(u), small * std::sin(v)});
      const auto at = [&](Index a, Index b) { return a % around * across + b % across; };
      mesh.triangles.push_back({at(i, k), at(i + 1, k), at(i + 1, k + 1)});
      mesh.triangles.push_back({at(i, k), at(i + 1, k + 1), at(i, k + 1)});
    }
  }
  return mesh;
}

Mesh square(Index size) {
  const testing::Grid grid{size, size};
  return {.vertex_count = grid.vertex_count(),
          .triangles = grid.triangles(),
          .lines = {},
          .points = {},
          .positions = grid.positions([](double u, double v) { return Vec3(2 * u - 1, 2 * v - 1, 0); })};
}

Mesh scene_mesh(std::vector<Vec3> vertices, std::vector<Triangle> triangles) {
  Mesh mesh;
  mesh.vertex_count = static_cast<Index>(vertices.size());
  mesh.triangles = std::move(triangles);
  for (const Vec3& v : vertices) mesh.positions.insert(mesh.positions.end(), v.begin(), v.end());
  return mesh;
}

Mesh box(const Vec3& middle, const Vec3& half, int n) {
  std::map<std::array<int, 3>, Index> known;
  std::vector<Vec3> vertices;
  std::vector<Triangle> triangles;
  const auto vertex = [&](std::array<int, 3> at) {
    const auto [place, is_new] = known.try_emplace(at, static_cast<Index>(vertices.size()));
    if (is_new) {
      Vec3 p = middle;
      for (std::size_t k = 0; k < 3; ++k) p[k] += half[k] * (2.0 * at[k] / n - 1);
      vertices.push_back(p);
    }
    return place->second;
  };
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const int end : {0, n}) {
      for (int i = 0; i < n; ++i) {
        for (int k = 0; k < n; ++k) {
          const auto at = [&](int u, int w) {
            std::array<int, 3> out{};
            out[axis] = end;
            out[(axis + 1) % 3] = i + u;
            out[(axis + 2) % 3] = k + w;
            return vertex(out);
          };
          Triangle s{at(0, 0), at(1, 0), at(1, 1)}, t{at(0, 0), at(1, 1), at(0, 1)};
          if (end == 0) std::swap(s[0], s[1]), std::swap(t[0], t[1]);
          triangles.push_back(s);
          triangles.push_back(t);
        }
      }
    }
  }
  return scene_mesh(vertices, triangles);
}

Pose placed(const Mesh& mesh, double scale, const Vec3& shift) {
  Pose x = mesh.positions;
  for (std::size_t i = 0; i < x.size(); ++i) x[i] = scale * x[i] + shift[static_cast<int>(i % 3)];
  return x;
}

Mesh together(const Mesh& a, const Mesh& b) {
  Mesh both = a;
  both.vertex_count += b.vertex_count;
  for (Triangle t : b.triangles) {
    for (Index& v : t) v += a.vertex_count;
    both.triangles.push_back(t);
  }
  both.positions.insert(both.positions.end(), b.positions.begin(), b.positions.end());
  return both;
}

Found contacts_of(const Animation& animation, const StepSettings& settings) {
  Found found;
  StepChecker checker(hierarchies(animation, 16));
  std::vector<const Topology*> topologies;
  for (const Topology& topology : animation.topologies) topologies.push_back(&topology);
  auto finder = ContactFinder::make(topologies).value();
  const auto note_frame = [&] {
    EXPECT_TRUE(finder.is_known());
    found.crossings.emplace_back(finder.crossings().begin(), finder.crossings().end());
    const auto of_crossings = finder.crossing_contacts();
    found.crossing_contacts.emplace_back(of_crossings.begin(), of_crossings.end());
  };
  const auto take = [&](std::vector<Contact> ended) {
    for (Contact& contact : ended) found.contacts.push_back(std::move(contact));
  };
  StaticResult first;
  EXPECT_TRUE(checker.check_static(spans(animation.poses[0]), settings, first));
  finder.start(0, spans(animation.poses[0]), first);
  note_frame();
  for (std::size_t k = 1; k < animation.poses.size(); ++k) {
    const auto x0 = spans(animation.poses[k - 1]), x1 = spans(animation.poses[k]);
    StepResult& step = found.steps.emplace_back();
    EXPECT_TRUE(checker.check(x0, x1, settings, step));
    finder.step(double(k - 1), double(k), x0, x1, step);
    const auto vf = finder.vertex_face_contacts(), ee = finder.edge_edge_contacts();
    found.vertex_face.emplace_back(vf.begin(), vf.end());
    found.edge_edge.emplace_back(ee.begin(), ee.end());
    note_frame();
    take(finder.take_ended());
  }
  take(finder.finish());
  EXPECT_EQ(finder.open_count(), 0u);
  for (auto* all : {&found.vertex_face, &found.edge_edge, &found.crossing_contacts}) {
    for (auto& numbers : *all) {
      for (Index& number : numbers) number = finder.joined_number(number);
    }
  }
  std::sort(found.contacts.begin(), found.contacts.end(),
            [](const Contact& a, const Contact& b) { return a.number < b.number; });
  return found;
}

}  // namespace foldproof::oracle
