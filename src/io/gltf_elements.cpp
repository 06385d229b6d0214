#include "io/gltf_elements.h"

#include <fmt/format.h>

#include "base/try.h"

namespace foldproof::io {
namespace {

enum Mode : std::uint64_t { Points = 0, Lines = 1, LineStrip = 3, Triangles = 4, Strip = 5 };

/// The corners of the primitive that form triangle `i`. A strip flips the winding of every other triangle.
std::array<std::uint64_t, 3> triangle_corners(std::uint64_t mode, std::uint64_t i) {
  if (mode == Triangles) return {3 * i, 3 * i + 1, 3 * i + 2};
  if (mode == Strip) return {i, i + 1 + i % 2, i + 2 - i % 2};
  return {i + 1, i + 2, 0};
}

/// The same numbers, but for the sign of zero, give the same keys.
std::array<std::uint64_t, 3> key_of(const GltfAccessor& accessor, std::uint64_t v) {
  return {AlikeVertices::key(accessor.get(v, 0)), AlikeVertices::key(accessor.get(v, 1)),
          AlikeVertices::key(accessor.get(v, 2))};
}

/// Joints and weights in their order, without those that have no weight.
std::array<std::uint64_t, 8> key_of(const std::array<GltfAccessor, 2>& influences, std::uint64_t v) {
  const auto& [joints, weights] = influences;
  std::array<std::uint64_t, 8> key{};
  std::size_t n = 0;
  for (int c = 0; c < 4; ++c) {
    const double weight = weights.get(v, c);
    if (weight == 0) continue;
    key[n++] = static_cast<std::uint64_t>(joints.get(v, c));
    key[n++] = AlikeVertices::key(weight);
  }
  return key;
}

bool is_zero(const GltfAccessor& accessor) {
  return accessor.base.bytes == nullptr && accessor.replaced.count == 0;
}

}  // namespace

/// The corners of a primitive.
struct GltfElements::Corners {
  const GltfPrimitive& primitive;
  std::uint64_t count, vertices;
  Index first_vertex;
  const std::string& where;

  /// kNoIndex if it does not exist.
  Index vertex(std::uint64_t corner) const {
    const std::uint64_t v = index(corner);
    return v < vertices ? first_vertex + static_cast<Index>(v) : kNoIndex;
  }
  tl::unexpected<Error> missing(const char* element, std::uint64_t i, std::uint64_t corner) const {
    return fail(ErrorCode::InvalidFile, where,
                fmt::format("{} {} refers to vertex {}, but there are {} (counting from 0)", element, i,
                            index(corner), vertices),
                "export the file again");
  }
  tl::unexpected<Error> not_whole(const char* elements) const {
    return fail(ErrorCode::InvalidFile, where,
                fmt::format("has {} corners, which are not whole {}", count, elements),
                "export the file again");
  }

 private:
  std::uint64_t index(std::uint64_t corner) const {
    return primitive.indices ? static_cast<std::uint64_t>(primitive.indices->get(corner, 0)) : corner;
  }
};

std::uint64_t corner_count(const GltfPrimitive& primitive, std::uint64_t vertices) {
  return primitive.indices ? primitive.indices->count() : vertices;
}

Result<void> GltfElements::add(const GltfRun& run, std::uint64_t vertices, const std::string& where) {
  runs_.push_back(run);
  const Corners corners{*run.primitive, corner_count(*run.primitive, vertices), vertices, run.first_vertex,
                        where};
  const std::uint64_t mode = run.primitive->mode;
  if (mode >= Triangles) return add_faces(corners);
  return mode == Points || corners.count < 2 ? add_points(corners) : add_lines(corners);
}

Result<void> GltfElements::add_faces(const Corners& corners) {
  const std::uint64_t mode = corners.primitive.mode;
  if (mode == Triangles ? corners.count % 3 != 0 : corners.count < 3) return corners.not_whole("triangles");
  const std::uint64_t count = mode == Triangles ? corners.count / 3 : corners.count - 2;
  for (std::uint64_t i = 0; i < count; ++i) {
    const auto at = triangle_corners(mode, i);
    const Triangle triangle{corners.vertex(at[0]), corners.vertex(at[1]), corners.vertex(at[2])};
    if (const auto bad = std::ranges::find(triangle, kNoIndex); bad != triangle.end())
      return corners.missing("triangle", i, at[static_cast<std::size_t>(bad - triangle.begin())]);
    elements_.faces.push_back(triangle);
    elements_.values.push_back(static_cast<Index>(runs_.size() - 1));
  }
  return {};
}

Result<void> GltfElements::add_lines(const Corners& corners) {
  const std::uint64_t mode = corners.primitive.mode, step = mode == Lines ? 2 : 1;
  if (mode == Lines && corners.count % 2 != 0) return corners.not_whole("lines");
  const std::uint64_t count = mode == LineStrip ? corners.count - 1 : corners.count / step;
  for (std::uint64_t i = 0; i < count; ++i) {
    const std::array<std::uint64_t, 2> at{i * step, (i * step + 1) % corners.count};
    const Index a = corners.vertex(at[0]), b = corners.vertex(at[1]);
    if (a == kNoIndex || b == kNoIndex) return corners.missing("line", i, a == kNoIndex ? at[0] : at[1]);
    if (a == b) {
      add_point(a);
      continue;
    }
    elements_.lines.push_back({std::min(a, b), std::max(a, b)});
    line_runs_.push_back(static_cast<Index>(runs_.size() - 1));
  }
  return {};
}

Result<void> GltfElements::add_points(const Corners& corners) {
  for (std::uint64_t i = 0; i < corners.count; ++i) {
    const Index v = corners.vertex(i);
    if (v == kNoIndex) return corners.missing("point", i, i);
    add_point(v);
  }
  return {};
}

void GltfElements::add_point(Index v) {
  elements_.points.push_back(v);
  point_runs_.push_back(static_cast<Index>(runs_.size() - 1));
}

MeshElements GltfElements::finish() {
  elements_.values.insert(elements_.values.end(), line_runs_.begin(), line_runs_.end());
  elements_.values.insert(elements_.values.end(), point_runs_.begin(), point_runs_.end());
  return std::move(elements_);
}

// All that evaluating a vertex reads is compared, and what it skips is not. So evaluation does the same with
// the same numbers.
std::vector<Index> gltf_seams(const GltfMesh& mesh) {
  // Accessors may share bytes, so the size of the file does not limit what has to be compared.
  constexpr std::uint64_t kMaxCompared = std::uint64_t{1} << 30;
  std::vector<Index> begin;
  Index count = 0;
  std::size_t influences = 0;
  for (const GltfVertexSet& set : mesh.vertex_sets) {
    begin.push_back(count);
    count += static_cast<Index>(set.position.count());
    influences = std::max(influences, set.influences.size());
  }
  AlikeVertices alike(count);
  if (std::uint64_t{count} * (1 + mesh.targets + influences) > kMaxCompared) return {};
  // The set of a vertex, and its number there.
  const auto place = [&](Index v) {
    const auto set =
        static_cast<std::size_t>(std::upper_bound(begin.begin(), begin.end(), v) - begin.begin()) - 1;
    return std::pair(&mesh.vertex_sets[set], std::uint64_t{v - begin[set]});
  };
  alike.compare<3>([&](Index v) {
    const auto [set, i] = place(v);
    return key_of(set->position, i);
  });
  const auto sets_have = [&](auto is_there) { return std::ranges::any_of(mesh.vertex_sets, is_there); };
  for (std::size_t t = 0; t < mesh.targets; ++t) {
    if (!sets_have([&](const auto& set) { return t < set.targets.size() && !is_zero(set.targets[t]); }))
      continue;
    alike.compare<3>([&](Index v) {
      const auto [set, i] = place(v);
      return t < set->targets.size() ? key_of(set->targets[t], i) : std::array<std::uint64_t, 3>{};
    });
  }
  for (std::size_t k = 0; k < influences; ++k) {
    alike.compare<8>([&](Index v) {
      const auto [set, i] = place(v);
      return k < set->influences.size() ? key_of(set->influences[k], i) : std::array<std::uint64_t, 8>{};
    });
  }
  return alike.first();
}

std::vector<Index> gltf_surfaces(const GltfScene& scene, std::span<const GltfRun> runs,
                                 std::span<const Index> run_of_face) {
  // Materials by name; those without one are different.
  std::vector<std::string> names{"\xff"};  // no material
  for (std::size_t i = 0; i < scene.materials.size(); ++i)
    names.push_back(scene.materials[i].empty() ? fmt::format("\xff{}", i) : scene.materials[i]);
  const std::vector<Index> surfaces = surfaces_by_name(names);
  std::vector<Index> of_face;
  of_face.reserve(run_of_face.size());
  for (const Index run : run_of_face) {
    const auto& material = runs[run].primitive->material;
    of_face.push_back(surfaces[material && *material < scene.materials.size() ? *material + 1 : 0]);
  }
  return of_face;
}

}  // namespace foldproof::io
