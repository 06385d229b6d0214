#include "io/gltf_pose.h"

#include <fmt/format.h>

#include "base/try.h"

namespace foldproof::io {
namespace {

using Affine = GltfPose::Affine;

void transform(const Affine& matrix, std::span<double> positions) {
  for (std::size_t i = 0; i + 2 < positions.size(); i += 3) {
    Eigen::Map<Eigen::Vector3d> p(&positions[i]);
    p = (matrix.leftCols<3>() * p + matrix.col(3)).eval();
  }
}

/// Linear blend skinning. Weights are divided by their sum, since stored weights rarely sum to exactly 1. A
/// vertex without weights follows the first joint. `unknown`: a joint that does not exist.
Affine blend(const GltfVertexSet& vertices, std::size_t v, const std::vector<Affine>& joints,
             std::optional<std::size_t>& unknown) {
  Affine blend = Affine::Zero();
  double sum = 0;
  for (const auto& [ids, weights] : vertices.influences) {
    for (int c = 0; c < 4; ++c) {
      const double weight = weights.get(v, c);
      if (weight == 0) continue;
      const auto joint = static_cast<std::size_t>(ids.get(v, c));
      if (joint >= joints.size()) {
        unknown = joint;
        return joints[0];
      }
      blend += weight * joints[joint];
      sum += weight;
    }
  }
  return sum == 0 ? joints[0] : Affine(blend / sum);
}

}  // namespace

GltfPose::GltfPose(const GltfScene& scene) : scene_(scene) {
  std::size_t first = 0;
  for (const std::size_t node : scene.mesh_nodes) {
    const std::size_t mesh = *scene.nodes[node].mesh;
    const auto& sets = scene.meshes[mesh].vertex_sets;
    for (std::size_t s = 0; s < sets.size(); ++s) {
      const std::size_t count = sets[s].position.count();
      instances_.push_back({node, mesh, s, first, count});
      first += count;
    }
  }
}

void GltfPose::set_time(double time) {
  nodes_ = scene_.nodes;
  for (const GltfChannel& channel : scene_.channels) {
    GltfNode& node = nodes_[channel.node];
    switch (channel.path) {
      case GltfPath::Translation:
        sample_channel(channel, time, {node.translation.data(), 3});
        break;
      case GltfPath::Rotation:
        sample_channel(channel, time, {node.rotation.coeffs().data(), 4});
        break;
      case GltfPath::Scale:
        sample_channel(channel, time, {node.scale.data(), 3});
        break;
      case GltfPath::Weights:
        node.weights.resize(scene_.meshes[*node.mesh].targets);
        sample_channel(channel, time, node.weights);
        break;
    }
  }
  world_.resize(nodes_.size());
  for (const std::size_t i : scene_.parents_first) {
    const GltfNode& node = nodes_[i];
    const Eigen::Matrix4d local = node.matrix ? *node.matrix
                                              : (Eigen::Translation3d(node.translation) *
                                                 node.rotation.normalized() * Eigen::Scaling(node.scale))
                                                    .matrix();
    world_[i] = node.parent ? Eigen::Matrix4d(world_[*node.parent] * local) : local;
  }
  joints_.assign(scene_.skins.size(), {});
}

Result<void> GltfPose::positions(const std::string& where, std::span<double> out) {
  for (const GltfInstance& instance : instances_) {
    const auto positions = out.subspan(3 * instance.first_vertex, 3 * instance.vertex_count);
    morph(instance, positions);
    if (const auto skin = scene_.nodes[instance.node].skin) {
      FOLDPROOF_TRY(apply_skin(instance, *skin, where, positions));
    } else {
      transform(world_[instance.node].topRows<3>(), positions);
    }
  }
  return {};
}

GltfPose::Affine GltfPose::to_world(const GltfInstance& instance, std::size_t v) {
  const auto skin = scene_.nodes[instance.node].skin;
  if (!skin) return world_[instance.node].topRows<3>();
  std::optional<std::size_t> unknown;
  return blend(vertices_of(instance), v, joints_of(*skin), unknown);
}

void GltfPose::morph(const GltfInstance& instance, std::span<double> positions) const {
  const GltfVertexSet& set = vertices_of(instance);
  const std::size_t count = set.position.count();
  for (std::size_t v = 0; v < count; ++v) {
    // -0 becomes 0, so that vertices that differ in this alone stay equal to the last bit.
    for (int c = 0; c < 3; ++c) positions[3 * v + static_cast<std::size_t>(c)] = set.position.get(v, c) + 0.0;
  }
  const GltfNode& node = nodes_[instance.node];
  const std::vector<double>& weights =
      node.weights.empty() ? scene_.meshes[*node.mesh].weights : node.weights;
  // Lines and points may have fewer targets than the faces of their mesh.
  for (std::size_t t = 0; t < std::min(weights.size(), set.targets.size()); ++t) {
    if (weights[t] == 0) continue;
    const GltfAccessor& target = set.targets[t];
    // Without a buffer, only the replaced elements are nonzero.
    const bool sparse = target.base.bytes == nullptr;
    const std::uint64_t entries = sparse ? target.replaced.count : count;
    for (std::uint64_t e = 0; e < entries; ++e) {
      const std::uint64_t v = sparse ? target.replaced.integer(e, 0) : e;
      for (int c = 0; c < 3; ++c) {
        const double delta = sparse ? target.values.get(e, c) : target.get(v, c);
        positions[3 * v + static_cast<std::size_t>(c)] += weights[t] * delta;
      }
    }
  }
}

/// The joint matrices of a skin in this frame; many nodes may share a skin.
const std::vector<Affine>& GltfPose::joints_of(std::size_t index) {
  std::vector<Affine>& joints = joints_[index];
  if (!joints.empty()) return joints;
  const GltfSkin& skin = scene_.skins[index];
  for (std::size_t j = 0; j < skin.joints.size(); ++j) {
    Eigen::Matrix4d bind = Eigen::Matrix4d::Identity();
    for (int c = 0; skin.inverse_bind && c < 16; ++c) bind.data()[c] = skin.inverse_bind->get(j, c);
    joints.push_back((world_[skin.joints[j]] * bind).topRows<3>());
  }
  return joints;
}

Result<void> GltfPose::apply_skin(const GltfInstance& instance, std::size_t skin, const std::string& where,
                                  std::span<double> positions) {
  const std::vector<Affine>& joints = joints_of(skin);
  std::optional<std::size_t> unknown;
  for (std::size_t v = 0; v < positions.size() / 3; ++v) {
    const Affine matrix = blend(vertices_of(instance), v, joints, unknown);
    if (unknown) {
      return fail(ErrorCode::InvalidFile, fmt::format("{}, vertex {}", where, instance.first_vertex + v),
                  fmt::format("refers to joint {}, but the skin has {}", *unknown, joints.size()),
                  "export the file again");
    }
    transform(matrix, positions.subspan(3 * v, 3));
  }
  return {};
}

}  // namespace foldproof::io
