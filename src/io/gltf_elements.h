/// The faces, lines and points of a glTF scene.
#pragma once

#include "io/gltf_scene.h"
#include "io/seams.h"

namespace foldproof::io {

/// A primitive of a node.
struct GltfRun {
  std::size_t node;
  const GltfPrimitive* primitive;
  Index first_vertex;  ///< Of the primitive's vertex set.
};

/// Collects elements, primitive by primitive.
class GltfElements {
 public:
  /// `vertices`: of the run's vertex set. `where`: for errors. Error: an index is out of range, or corners do
  /// not make whole elements.
  Result<void> add(const GltfRun& run, std::uint64_t vertices, const std::string& where);

  std::span<const GltfRun> runs() const { return runs_; }
  /// Values are indices of runs.
  MeshElements finish();

 private:
  struct Corners;
  Result<void> add_faces(const Corners& corners);
  Result<void> add_lines(const Corners& corners);
  Result<void> add_points(const Corners& corners);
  void add_point(Index v);

  std::vector<GltfRun> runs_;
  MeshElements elements_;
  std::vector<Index> line_runs_, point_runs_;  // those of faces are in the elements
};

/// How many corners a primitive has: the indices, or else the vertices of its set.
std::uint64_t corner_count(const GltfPrimitive& primitive, std::uint64_t vertices);

/// Of every vertex of a mesh, whose vertex sets come one after the other, the first that is at the same place
/// in every frame by construction: with the same position, influences and morph displacements. Empty where
/// these are more than 2^30, which a small file can describe.
std::vector<Index> gltf_seams(const GltfMesh& mesh);

/// The surface of each face, by its material.
std::vector<Index> gltf_surfaces(const GltfScene& scene, std::span<const GltfRun> runs,
                                 std::span<const Index> run_of_face);

}  // namespace foldproof::io
