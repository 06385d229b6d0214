#include "io/gltf_parts.h"

#include <fmt/format.h>

#include <algorithm>

namespace foldproof::io {
namespace {

/// Weights that joint_parts() may read. Accessors may share bytes, so the size of the file does not limit
/// them.
constexpr std::uint64_t kMaxWeights = std::uint64_t{1} << 32;

/// The name of a node or of its mesh, else of its nearest ancestor that has one; or empty.
std::string name_near(const GltfScene& scene, std::size_t i) {
  for (std::optional<std::size_t> at = i; at; at = scene.nodes[*at].parent) {
    const GltfNode& node = scene.nodes[*at];
    if (!node.name.empty()) return node.name;
    if (node.mesh && !scene.meshes[*node.mesh].name.empty()) return scene.meshes[*node.mesh].name;
  }
  return "";
}

std::string node_name(const GltfScene& scene, std::size_t i) {
  const std::string name = name_near(scene, i);
  return name.empty() ? fmt::format("node {}", i) : name;
}

std::string material_name(const GltfScene& scene, const std::optional<std::size_t>& i) {
  if (!i) return "no material";
  const bool has_name = *i < scene.materials.size() && !scene.materials[*i].empty();
  return has_name ? scene.materials[*i] : fmt::format("material {}", *i);
}

/// Finds the joint that moves most of an element.
class JointFinder {
 public:
  explicit JointFinder(std::size_t joints) : sums_(joints) {}

  Index find(std::span<const Index> corners, const GltfVertexSet& vertices, Index first_vertex) {
    for (const Index v : corners) add(vertices, v - first_vertex);
    Index best = 0;  // that of vertices without weights
    for (const Index joint : seen_) {
      if (sums_[joint] > sums_[best] || (sums_[joint] == sums_[best] && joint < best)) best = joint;
    }
    for (const Index joint : seen_) sums_[joint] = 0;
    seen_.clear();
    return best;
  }

 private:
  void add(const GltfVertexSet& vertices, std::uint64_t vertex) {
    for (const auto& [ids, weights] : vertices.influences) {
      for (int c = 0; c < 4; ++c) {
        const double weight = weights.get(vertex, c);
        const auto joint = static_cast<std::size_t>(ids.get(vertex, c));
        if (!(weight > 0) || joint >= sums_.size()) continue;
        sums_[joint] += weight;
        seen_.push_back(static_cast<Index>(joint));
      }
    }
  }

  std::vector<double> sums_;  // per joint
  std::vector<Index> seen_;   // joints with a sum
};

/// Precondition: all runs are of one node, which has a skin.
ObjectParts joint_parts(const GltfScene& scene, std::span<const GltfRun> runs, const MeshElements& elements) {
  const GltfNode& node = scene.nodes[runs.front().node];
  const GltfMesh& mesh = scene.meshes[*node.mesh];
  const auto vertices_of = [&](Index run) -> const GltfVertexSet& {
    return mesh.vertex_sets[runs[run].primitive->vertex_set];
  };
  std::uint64_t weights = 0;
  for (const Index run : elements.values) weights += 12 * vertices_of(run).influences.size();
  if (weights > kMaxWeights) return {};
  std::vector<std::string> names;
  for (const std::size_t joint : scene.skins[*node.skin].joints) {
    names.push_back(name_near(scene, joint));
    if (names.back().empty()) names.back() = node_name(scene, runs.front().node);
  }
  std::vector<Index> of_element;
  of_element.reserve(elements.values.size());
  JointFinder finder(names.size());
  const auto add = [&](std::span<const Index> corners) {
    const Index run = elements.values[of_element.size()];
    of_element.push_back(finder.find(corners, vertices_of(run), runs[run].first_vertex));
  };
  for (const Triangle& face : elements.faces) add(face);
  for (const Edge& line : elements.lines) add(line);
  for (const Index& point : elements.points) add({&point, 1});
  return parts_by_name(names, of_element);
}

}  // namespace

ObjectParts gltf_parts(const GltfScene& scene, std::span<const GltfRun> runs, const MeshElements& elements) {
  std::vector<std::string> nodes, materials;
  for (const GltfRun& run : runs) {
    nodes.push_back(node_name(scene, run.node));
    materials.push_back(material_name(scene, run.primitive->material));
  }
  for (const auto* names : {&nodes, &materials}) {
    ObjectParts parts = parts_by_name(*names, elements.values);
    if (!parts.names.empty()) return parts;
  }
  const bool one =
      std::ranges::all_of(runs, [&](const GltfRun& run) { return run.node == runs.front().node; });
  return one && scene.nodes[runs.front().node].skin ? joint_parts(scene, runs, elements) : ObjectParts();
}

}  // namespace foldproof::io
