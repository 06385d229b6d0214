/// Parts of a glTF scene.
#pragma once

#include "io/gltf_scene.h"
#include "io/parts.h"

namespace foldproof::io {

/// The triangles of a primitive of a node, which follow those of the one before.
struct GltfTriangles {
  std::size_t node;
  const GltfPrimitive* primitive;
  std::size_t triangles;
  Index first_vertex;  ///< Of the primitive's vertex set.
};

/// Parts by the names of nodes; where there is only one, by materials; where there is only one, and the node
/// has a skin, by joints: each triangle belongs to the joint with the largest sum of weights of its vertices.
ObjectParts gltf_parts(const GltfScene& scene, std::span<const GltfTriangles> runs,
                       std::span<const Triangle> triangles);

}  // namespace foldproof::io
