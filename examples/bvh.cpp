// Prints: a strip of 200 triangles: 31 nodes, 16 leaves of 14 triangles at most
// The tree over a mesh's triangles is built once and serves every query on that mesh.
#include <algorithm>
#include <cstdio>

#include "foldproof/bvh.h"

int main() {
  using namespace foldproof;
  std::vector<double> x;
  std::vector<Triangle> triangles;
  for (Index k = 0; k < 202; ++k) {
    x.insert(x.end(), {0.5 * k, k % 2 ? 1.0 : 0.0, 0});
    if (k >= 2) triangles.push_back({k - 2, k - 1, k});
  }
  const auto tree = Hierarchy::build(Topology::make(202, triangles).value(), x);
  if (!tree) return std::puts(tree.error().line().c_str()), 1;
  Index largest = 0;
  for (Index leaf = 0; leaf < tree->leaf_count(); ++leaf)
    largest = std::max(largest, tree->leaves()[leaf + 1].triangles - tree->leaves()[leaf].triangles);
  std::printf("a strip of 200 triangles: %zu nodes, %u leaves of %u triangles at most\n",
              tree->nodes().size(), tree->leaf_count(), largest);
}
