/// Parts of a glTF scene.
#pragma once

#include "io/gltf_elements.h"
#include "io/parts.h"

namespace foldproof::io {

/// Parts by the names of nodes; where there is only one, by materials; where there is only one, and the node
/// has a skin, by joints: each element belongs to the joint with the largest sum of weights of its vertices.
/// Precondition: the elements' values are indices of runs, and their vertices those of the file.
ObjectParts gltf_parts(const GltfScene& scene, std::span<const GltfRun> runs, const MeshElements& elements);

}  // namespace foldproof::io
