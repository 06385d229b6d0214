/// Where the vertices of a glTF scene are at a time.
#pragma once

#include "io/gltf_scene.h"

namespace foldproof::io {

/// A node that instantiates a vertex set.
struct GltfInstance {
  std::size_t node;
  std::size_t mesh, vertex_set;
  std::size_t first_vertex;
  std::size_t vertex_count;
};

/// Evaluates transforms, morph targets and skins.
class GltfPose {
 public:
  using Affine = Eigen::Matrix<double, 3, 4>;

  /// The scene must outlive it.
  explicit GltfPose(const GltfScene& scene);

  /// Seconds.
  void set_time(double time);
  /// Positions in the world of all vertices, in the order of instances(). `where`: for errors. Error: a
  /// vertex refers to a joint that does not exist.
  Result<void> positions(const std::string& where, std::span<double> out);
  /// Vertex sets of the scene's nodes, node by node.
  const std::vector<GltfInstance>& instances() const { return instances_; }
  /// Of vertex `v` of an instance, the map to the world of what its morph targets make.
  /// Precondition: positions() of this time succeeded.
  Affine to_world(const GltfInstance& instance, std::size_t v);

 private:
  void morph(const GltfInstance& instance, std::span<double> positions) const;
  Result<void> apply_skin(const GltfInstance& instance, std::size_t skin, const std::string& where,
                          std::span<double> positions);
  const std::vector<Affine>& joints_of(std::size_t skin);
  const GltfVertexSet& vertices_of(const GltfInstance& instance) const {
    return scene_.meshes[instance.mesh].vertex_sets[instance.vertex_set];
  }

  const GltfScene& scene_;
  std::vector<GltfInstance> instances_;
  std::vector<GltfNode> nodes_;  // at this time
  std::vector<Eigen::Matrix4d> world_;
  std::vector<std::vector<Affine>> joints_;  // per skin; empty until needed at this time
};

}  // namespace foldproof::io
