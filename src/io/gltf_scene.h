/// Nodes, meshes, skins and animations of a glTF file, with checked references.
#pragma once

#include <Eigen/Geometry>

#include "foldproof/mesh.h"
#include "io/gltf_document.h"

namespace foldproof::io {

struct GltfNode {
  std::string name;
  std::optional<Eigen::Matrix4d> matrix;  ///< If given, replaces the three below.
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d scale = Eigen::Vector3d::Ones();
  std::optional<std::size_t> parent, mesh, skin;
  std::vector<std::size_t> children;
  std::vector<double> weights;  ///< Of its mesh's morph targets.
};

/// Vertices shared by primitives of one mesh.
struct GltfVertexSet {
  GltfAccessor position;
  std::vector<GltfAccessor> targets;
  std::vector<std::array<GltfAccessor, 2>> influences;  ///< Joints and weights, four a vertex each.
};

struct GltfPrimitive {
  std::size_t vertex_set = 0;
  std::optional<GltfAccessor> indices;
  std::uint64_t mode = 4;  ///< 0 points; 1 lines, 2 loop, 3 strip; 4 triangles, 5 strip, 6 fan.
  bool has_faces() const { return mode >= 4; }
  std::optional<std::size_t> material;
};

struct GltfMesh {
  std::string name;
  std::vector<GltfVertexSet> vertex_sets;
  std::vector<GltfPrimitive> primitives;
  std::vector<double> weights;
  std::size_t targets = 0;  ///< Of all vertices of faces; others may have fewer, and no influences.
};

struct GltfSkin {
  std::vector<std::size_t> joints;
  std::optional<GltfAccessor> inverse_bind;
};

enum class GltfPath : std::uint8_t { Translation, Rotation, Scale, Weights };
enum class GltfInterpolation : std::uint8_t { Linear, Step, CubicSpline };

struct GltfChannel {
  std::size_t node = 0;
  GltfPath path = GltfPath::Translation;
  GltfInterpolation interpolation = GltfInterpolation::Linear;
  std::size_t times_index = 0;  ///< The accessor of the times, which channels may share.
  GltfAccessor times, values;
};

struct GltfScene {
  std::vector<GltfNode> nodes;
  std::vector<std::size_t> parents_first;  ///< All nodes, each after its parent.
  std::vector<std::size_t> mesh_nodes;     ///< Nodes of the scene that have a mesh, depth first.
  std::vector<GltfMesh> meshes;
  std::vector<GltfSkin> skins;
  std::vector<std::string> materials;  ///< Names.
  std::vector<GltfChannel> channels;   ///< At most one per path of a node.
  std::size_t clip = 0;                ///< Index of the animation of these, if there is any.
  double duration = 0;                 ///< Time of the last key of any channel, seconds.
  std::vector<std::string> notes;      ///< On what was left out of it, as in MotionInfo.
  std::vector<std::string> clips;      ///< As in MotionInfo.
  std::string taken_as, unchecked;     ///< The same, where there are several clips.
};

/// `clip`: ReadOptions::clip. Error: the document's first error; there is no such clip.
Result<GltfScene> read_gltf_scene(GltfDocument& document, const std::string& clip);

/// Interpolates the `out.size()` numbers of a channel at a time, without normalization. A time that differs
/// from a key's by no more than rounding takes the key (is_time_of_key).
void sample_channel(const GltfChannel& channel, double time, std::span<double> out);

}  // namespace foldproof::io
