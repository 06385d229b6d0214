#include "model/limits.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>

#include "certificate/patch.h"

namespace foldproof::internal {

Result<void> require_byte_order(const std::string& path) {
  if (std::endian::native == std::endian::little) return {};
  return fail(ErrorCode::UnsupportedFormat, path,
              "models are little-endian, and this processor is big-endian",
              "use another machine, such as x86-64 or 64-bit ARM");
}

Result<void> require_few_loose_vertices(const Topology& topology, const std::string& where) {
  const std::uint64_t vertices = topology.vertex_count(), triangles = topology.triangles().size();
  if (vertices <= (1u << 20) + 64 * triangles) return {};
  return fail(ErrorCode::LimitExceeded, where,
              fmt::format("has {} vertices, but only {} triangles", vertices, triangles),
              "remove vertices that no triangle uses");
}

Result<void> require_few_neighbors(const Hierarchy& hierarchy, const std::string& where) {
  struct VertexUse {
    Index last_leaf = kNoIndex;
    std::uint64_t leaves = 0;
  };
  std::vector<VertexUse> uses(hierarchy.vertex_ids().size());
  for (Index leaf = 0; leaf < hierarchy.leaf_count(); ++leaf) {
    for (Index t = hierarchy.leaves()[leaf].triangles; t < hierarchy.leaves()[leaf + 1].triangles; ++t) {
      for (const Index v : hierarchy.triangles()[t]) {
        if (uses[v].last_leaf != leaf) ++uses[v].leaves;
        uses[v].last_leaf = leaf;
      }
    }
  }
  // Slots of models number all pairs.
  const auto is_few = [](const VertexUse& use) { return use.leaves <= PatchSlots::kMaxLeavesAtVertex; };
  std::uint64_t pairs = 0;
  for (const VertexUse& use : uses) pairs += use.leaves * use.leaves;
  if (std::ranges::all_of(uses, is_few) &&
      pairs <= (1u << 26) + 64 * std::uint64_t{hierarchy.triangles().size()})
    return {};
  return fail(ErrorCode::LimitExceeded, where, "has vertices in which far too many triangles meet",
              "split the mesh there");
}

}  // namespace foldproof::internal
