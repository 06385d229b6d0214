// Prints: 2 triangles, 5 edges; vertex 7 is refused: yes
// A topology is made once from triangles; edges come with it.
#include <cstdio>

#include "foldproof/mesh.h"

int main() {
  const auto square = foldproof::Topology::make(4, {{0, 1, 2}, {0, 2, 3}});
  const auto refused = foldproof::Topology::make(4, {{0, 1, 7}});
  if (!square) return std::puts(square.error().line().c_str()), 1;
  std::printf("%zu triangles, %zu edges; vertex 7 is refused: %s\n", square->triangles().size(),
              square->edges().size(), refused ? "no" : "yes");
}
