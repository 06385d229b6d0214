// Prints: unsewn: the panels touch from the start; sewn: they fall by 0.73 of the way until they meet
// Two panels that are sewn along a seam and still collide elsewhere.
#include "foldproof/filters.h"

#include <cmath>
#include <cstdio>

#include "foldproof/solver.h"

int main() {
  using namespace foldproof;
  // Panels of 8 x 8 cells, one lying, one standing. Vertices of both lie at the seam, x = 1.
  constexpr Index kCells = 8, kRow = kCells + 1, kPanel = kRow * kRow;
  std::vector<double> standing, folded;
  std::vector<Triangle> faces;
  for (Index panel = 0; panel < 2; ++panel) {
    for (Index i = 0; i < kRow; ++i) {
      for (Index k = 0; k < kRow; ++k) {
        const double across = double(i) / kCells, along = double(k) / kCells;
        standing.insert(standing.end(), {panel == 0 ? across : 1, along, panel * across});
        // The second panel falls onto the first, and its far end goes through it.
        folded.insert(folded.end(), {panel == 0 ? across : 1 - 0.9 * across, along,
                                     panel * 0.3 * across * (1.7 - 2 * across)});
        if (i == 0 || k == 0) continue;
        const Index d = panel * kPanel + i * kRow + k;
        faces.push_back({d - kRow - 1, d - kRow, d});
        faces.push_back({d - kRow - 1, d, d - 1});
      }
    }
  }
  const auto made = CollisionMesh::make(standing, {}, faces);
  if (!made) return std::puts(made.error().line().c_str()), 1;
  const auto mesh = std::make_shared<const CollisionMesh>(*made);

  std::vector<std::array<ObjectVertex, 2>> seam;  // all of one object, 0
  for (Index k = 0; k < kRow; ++k) seam.push_back({{{0, kCells * kRow + k}, {0, kPanel + k}}});
  const std::vector<Object> objects{mesh->hierarchy()};
  const auto filter = ignore_sewn(objects, seam);
  if (!filter) return std::puts(filter.error().line().c_str()), 1;

  ContactChecker unsewn(mesh), sewn(mesh, {}, *filter);
  const bool touch = unsewn.collision_free_step_size(standing, folded)->limit == StepSize::Limit::Start;
  const StepSize size = sewn.collision_free_step_size(standing, folded).value();
  std::printf("unsewn: the panels %s from the start; sewn: they fall by %.2f of the way until they meet\n",
              touch ? "touch" : "are free", size.share);
}
