#include "io/gltf_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "base/try.h"
#include "io/gltf_clips.h"

namespace foldproof::io {
namespace {

using Json = GltfDocument::Json;

class SceneReader {
 public:
  explicit SceneReader(GltfDocument& document) : document_(document) {}

  Result<GltfScene> read(const std::string& clip) {
    read_nodes();
    for (const Json& material : document_.list("materials"))
      scene_.materials.push_back(document_.text(material, "name", ""));
    if (!failed()) order_nodes();
    if (!failed()) read_meshes();
    if (!failed()) read_skins();
    if (!failed()) check_mesh_nodes();
    std::vector<GltfClip> clips;
    if (!failed()) clips = read_animations();
    if (failed()) return tl::unexpected(*document_.error());
    FOLDPROOF_TRY(show_clip(std::move(clips), clip, document_.path(), scene_));
    split_animated_matrices();
    return std::move(scene_);
  }

 private:
  bool failed() const { return document_.error().has_value(); }

  void read_nodes() {
    const Json& nodes = document_.list("nodes");
    scene_.nodes.resize(nodes.size());
    for (std::size_t i = 0; i < nodes.size() && !failed(); ++i) {
      read_node(nodes[i], i, fmt::format("nodes[{}]", i));
    }
  }

  void read_node(const Json& json, std::size_t i, const std::string& json_path) {
    GltfNode& node = scene_.nodes[i];
    node.name = document_.text(json, "name", "");
    Eigen::Matrix4d matrix;  // glTF and Eigen both store columns
    if (document_.numbers(json, "matrix", {matrix.data(), 16}, json_path)) node.matrix = matrix;
    document_.numbers(json, "translation", {node.translation.data(), 3}, json_path);
    document_.numbers(json, "rotation", {node.rotation.coeffs().data(), 4}, json_path);
    document_.numbers(json, "scale", {node.scale.data(), 3}, json_path);
    node.mesh = document_.optional_index(json, "mesh", "meshes", json_path);
    node.skin = document_.optional_index(json, "skin", "skins", json_path);
    node.weights = read_weights(json, json_path);
    for (const Json& child : document_.list(json, "children", json_path)) {
      const std::size_t c = document_.checked_index(child, "nodes", json_path);
      if (failed()) return;
      if (scene_.nodes[c].parent) {
        document_.set_error(json_path, fmt::format("nodes[{}] has two parents", c));
        return;
      }
      scene_.nodes[c].parent = i;
      node.children.push_back(c);
    }
  }

  std::vector<double> read_weights(const Json& json, const std::string& json_path) {
    std::vector<double> weights(document_.list(json, "weights", json_path).size());
    if (!weights.empty()) document_.numbers(json, "weights", weights, json_path);
    return weights;
  }

  /// Nodes in depth-first order from `roots`. Every node has at most one parent, so none is visited twice.
  std::vector<std::size_t> depth_first(const std::vector<std::size_t>& roots) const {
    std::vector<std::size_t> order, stack(roots.rbegin(), roots.rend());
    while (!stack.empty()) {
      const std::size_t i = stack.back();
      stack.pop_back();
      order.push_back(i);
      const auto& children = scene_.nodes[i].children;
      stack.insert(stack.end(), children.rbegin(), children.rend());
    }
    return order;
  }

  /// Exporters also list nodes below others, which are shown once, where their parents put them. Call when
  /// parents_first is there.
  std::vector<std::size_t> without_descendants(const std::vector<std::size_t>& listed) const {
    std::vector<bool> is_listed(scene_.nodes.size()), is_below(scene_.nodes.size());
    for (const std::size_t i : listed) is_listed[i] = true;
    for (const std::size_t i : scene_.parents_first) {
      const auto parent = scene_.nodes[i].parent;
      is_below[i] = parent && (is_listed[*parent] || is_below[*parent]);
    }
    std::vector<std::size_t> kept;
    for (const std::size_t i : listed) {
      if (is_listed[i] && !is_below[i]) kept.push_back(i);
      is_listed[i] = false;  // may be listed twice
    }
    return kept;
  }

  void order_nodes() {
    std::vector<std::size_t> roots;
    for (std::size_t i = 0; i < scene_.nodes.size(); ++i) {
      if (!scene_.nodes[i].parent) roots.push_back(i);
    }
    scene_.parents_first = depth_first(roots);
    if (scene_.parents_first.size() != scene_.nodes.size()) {
      document_.set_error("nodes", "a node is its own ancestor");
      return;
    }
    std::vector<std::size_t> scene_nodes = scene_.parents_first;
    if (const auto index = document_.optional_index(document_.json(), "scene", "scenes", "file")) {
      const std::string json_path = fmt::format("scenes[{}]", *index);
      roots.clear();
      for (const Json& root : document_.list(document_.list("scenes")[*index], "nodes", json_path)) {
        roots.push_back(document_.checked_index(root, "nodes", json_path));
        if (failed()) return;
      }
      scene_nodes = depth_first(without_descendants(roots));
    }
    for (const std::size_t i : scene_nodes) {
      if (scene_.nodes[i].mesh) scene_.mesh_nodes.push_back(i);
    }
  }

  void read_meshes() {
    const Json& meshes = document_.list("meshes");
    for (std::size_t i = 0; i < meshes.size() && !failed(); ++i) {
      const std::string json_path = fmt::format("meshes[{}]", i);
      GltfMesh mesh;
      mesh.name = document_.text(meshes[i], "name", "");
      std::map<std::vector<std::size_t>, std::size_t> sets;
      std::size_t number = 0;
      for (const Json& primitive : document_.list(meshes[i], "primitives", json_path)) {
        read_primitive(primitive, fmt::format("{}.primitives[{}]", json_path, number++), mesh, sets);
        if (failed()) return;
      }
      mesh.weights = read_weights(meshes[i], json_path);
      scene_.meshes.push_back(std::move(mesh));
    }
  }

  void read_primitive(const Json& json, const std::string& json_path, GltfMesh& mesh,
                      std::map<std::vector<std::size_t>, std::size_t>& sets) {
    GltfPrimitive primitive;
    primitive.mode = document_.optional_count(json, "mode", json_path).value_or(4);
    if (primitive.mode > 6) document_.set_error(json_path, "'mode' is not known");
    const auto attributes = json.find("attributes");
    if (attributes == json.end() || !attributes->contains("POSITION")) {
      if (primitive.has_faces()) document_.set_error(json_path, "has no positions");
      return;
    }
    // Primitives that name the same accessors share their vertices: meshes are often split by material only.
    const std::vector<std::size_t> key = vertex_key(*attributes, json, json_path);
    if (failed()) return;
    const auto [found, is_new] = sets.emplace(key, mesh.vertex_sets.size());
    if (is_new) mesh.vertex_sets.push_back(read_vertex_set(*attributes, json, json_path));
    if (failed()) return;
    primitive.vertex_set = found->second;
    if (const auto indices = document_.optional_index(json, "indices", "accessors", json_path)) {
      primitive.indices = document_.accessor(*indices, "SCALAR", json_path);
      if (failed()) return;
      if (!primitive.indices->base.is_unsigned() || primitive.indices->base.bytes == nullptr) {
        document_.set_error(json_path, "indices are not unsigned integers in a buffer");
      }
      if (primitive.indices->base.normalized) document_.set_error(json_path, "indices are normalized");
    }
    primitive.material = document_.optional_count(json, "material", json_path);
    const std::size_t targets = mesh.vertex_sets[primitive.vertex_set].targets.size();
    const bool after_faces = std::ranges::any_of(mesh.primitives, &GltfPrimitive::has_faces);
    if (primitive.has_faces() && after_faces && targets != mesh.targets)
      document_.set_error(json_path, "has another number of morph targets than the primitive before");
    if (primitive.has_faces() || mesh.primitives.empty()) mesh.targets = targets;
    mesh.primitives.push_back(std::move(primitive));
  }

  std::vector<std::size_t> vertex_key(const Json& attributes, const Json& json,
                                      const std::string& json_path) {
    std::vector<std::size_t> key{document_.index(attributes, "POSITION", "accessors", json_path)};
    for (const Json& target : document_.list(json, "targets", json_path)) {
      key.push_back(
          target.contains("POSITION") ? document_.index(target, "POSITION", "accessors", json_path) + 1 : 0);
    }
    key.push_back(key.size());  // separates targets from joints
    for (std::size_t set = 0; attributes.contains(fmt::format("JOINTS_{}", set)); ++set) {
      key.push_back(
          document_.index(attributes, fmt::format("JOINTS_{}", set).c_str(), "accessors", json_path));
      key.push_back(
          document_.index(attributes, fmt::format("WEIGHTS_{}", set).c_str(), "accessors", json_path));
    }
    return key;
  }

  GltfVertexSet read_vertex_set(const Json& attributes, const Json& json, const std::string& json_path) {
    GltfVertexSet set;
    const auto read = [&](const Json& from, const std::string& key, std::string_view type) {
      return document_.accessor(document_.index(from, key.c_str(), "accessors", json_path), type, json_path);
    };
    set.position = read(attributes, "POSITION", "VEC3");
    const std::uint64_t count = set.position.count();
    // An accessor without a buffer is all zero, and nothing checks its count against the file.
    if (set.position.base.bytes == nullptr || count == 0)
      document_.set_error(json_path, "positions are not in a buffer");
    const auto check_count = [&](const GltfAccessor& accessor) {
      if (accessor.count() != count)
        document_.set_error(json_path, "accessors of its vertices differ in count");
    };
    for (const Json& target : document_.list(json, "targets", json_path)) {
      GltfAccessor accessor;
      accessor.base.count = count;
      if (target.contains("POSITION")) accessor = read(target, "POSITION", "VEC3");
      check_count(accessor);
      set.targets.push_back(std::move(accessor));
    }
    for (std::size_t i = 0; attributes.contains(fmt::format("JOINTS_{}", i)) && !failed(); ++i) {
      std::array<GltfAccessor, 2> influence{read(attributes, fmt::format("JOINTS_{}", i), "VEC4"),
                                            read(attributes, fmt::format("WEIGHTS_{}", i), "VEC4")};
      check_count(influence[0]);
      check_count(influence[1]);
      if (!influence[0].base.is_unsigned())
        document_.set_error(json_path, "joints are not unsigned integers");
      if (influence[0].base.normalized) document_.set_error(json_path, "joints are normalized");
      set.influences.push_back(std::move(influence));
    }
    return set;
  }

  void read_skins() {
    const Json& skins = document_.list("skins");
    for (std::size_t i = 0; i < skins.size() && !failed(); ++i) {
      const std::string json_path = fmt::format("skins[{}]", i);
      GltfSkin skin;
      for (const Json& joint : document_.list(skins[i], "joints", json_path)) {
        skin.joints.push_back(document_.checked_index(joint, "nodes", json_path));
      }
      if (const auto index =
              document_.optional_index(skins[i], "inverseBindMatrices", "accessors", json_path)) {
        skin.inverse_bind = document_.accessor(*index, "MAT4", json_path);
        if (skin.inverse_bind->count() < skin.joints.size()) {
          document_.set_error(json_path, "has fewer inverse bind matrices than joints");
        }
      }
      if (skin.joints.empty()) document_.set_error(json_path, "has no joints");
      scene_.skins.push_back(std::move(skin));
    }
  }

  void check_mesh_nodes() {
    std::vector<bool> bindable;  // per mesh, whether all vertices of its faces have joints
    for (const GltfMesh& mesh : scene_.meshes) {
      bindable.push_back(std::ranges::none_of(mesh.primitives, [&](const GltfPrimitive& primitive) {
        return primitive.has_faces() && mesh.vertex_sets[primitive.vertex_set].influences.empty();
      }));
    }
    for (const std::size_t i : scene_.mesh_nodes) {
      const GltfNode& node = scene_.nodes[i];
      const GltfMesh& mesh = scene_.meshes[*node.mesh];
      const std::string json_path = fmt::format("nodes[{}]", i);
      for (const auto* weights : {&node.weights, &mesh.weights}) {
        if (!weights->empty() && weights->size() != mesh.targets) {
          document_.set_error(json_path, fmt::format("{} weights are given for {} morph targets",
                                                     weights->size(), mesh.targets));
        }
      }
      if (node.skin && !bindable[*node.mesh])
        document_.set_error(json_path, "has a skin, but its mesh has no joints");
    }
  }

  std::vector<GltfClip> read_animations() {
    const Json& animations = document_.list("animations");
    std::vector<GltfClip> clips;
    for (std::size_t i = 0; i < animations.size() && !failed(); ++i) {
      const std::string json_path = fmt::format("animations[{}]", i);
      const std::string name = document_.text(animations[i], "name", "");
      GltfClip clip{name, read_animation(animations[i], json_path)};
      for (const GltfChannel& channel : clip.channels)
        clip.duration = std::max(clip.duration, channel.times.get(channel.times.count() - 1, 0));
      clips.push_back(std::move(clip));
    }
    return clips;
  }

  /// The specification forbids to animate a node that has a matrix. Viewers split it, and so what is not
  /// animated stays.
  void split_animated_matrices() {
    std::size_t split = 0, sheared = 0;
    for (const GltfChannel& channel : scene_.channels) {
      GltfNode& node = scene_.nodes[channel.node];
      if (channel.path == GltfPath::Weights || !node.matrix) continue;
      ++split;
      sheared += !split_matrix(node);
    }
    if (split == 0) return;
    scene_.notes.push_back(fmt::format(
        "{} {} a matrix and {} animated, which glTF forbids: {} split into translation, rotation and scale, "
        "as viewers do{}",
        split, split == 1 ? "node has" : "nodes have", split == 1 ? "is" : "are",
        split == 1 ? "it was" : "they were", sheared == 0 ? "" : ", which leaves out a shear"));
  }

  /// False where the three do not make up the matrix.
  static bool split_matrix(GltfNode& node) {
    const Eigen::Matrix3d linear = node.matrix->topLeftCorner<3, 3>();
    node.translation = node.matrix->topRightCorner<3, 1>();
    node.scale = linear.colwise().norm().transpose();
    if (linear.determinant() < 0) node.scale.x() = -node.scale.x();
    Eigen::Matrix3d rotation = linear;
    for (int k = 0; k < 3; ++k) {
      if (node.scale[k] != 0) rotation.col(k) /= node.scale[k];
    }
    for (int k = 0; k < 3; ++k) {  // a flat axis
      if (node.scale[k] == 0) rotation.col(k) = rotation.col((k + 1) % 3).cross(rotation.col((k + 2) % 3));
    }
    node.rotation = rotation.determinant() > 0 ? Eigen::Quaterniond(rotation).normalized()
                                               : Eigen::Quaterniond::Identity();
    node.matrix.reset();
    const Eigen::Matrix3d made = node.rotation.toRotationMatrix() * node.scale.asDiagonal();
    return (made - linear).norm() <= 1e-6 * linear.norm();
  }

  std::vector<GltfChannel> read_animation(const Json& json, const std::string& json_path) {
    std::vector<GltfChannel> channels;
    const Json& samplers = document_.list(json, "samplers", json_path);
    std::size_t number = 0;
    for (const Json& entry : document_.list(json, "channels", json_path)) {
      const std::string where = fmt::format("{}.channels[{}]", json_path, number++);
      const auto target = entry.find("target");
      const std::uint64_t sampler = document_.count(entry, "sampler", where);
      if (target == entry.end() || sampler >= samplers.size()) {
        document_.set_error(where, "has no target, or a sampler that does not exist");
      }
      if (failed()) return {};
      const std::string path = document_.text(*target, "path", "");
      if (path == "pointer") {
        check_pointer(*target, where);
        continue;
      }
      const auto node = document_.optional_index(*target, "node", "nodes", where);
      if (!node) continue;  // by the specification, a channel without a node has no effect
      GltfChannel channel;
      channel.node = *node;
      if (path == "weights" && !scene_.nodes[*node].mesh) continue;
      read_sampler(samplers[sampler], path, where, channel);
      if (failed()) return {};
      channels.push_back(std::move(channel));
    }
    return channels;
  }

  /// KHR_animation_pointer can drive whatever has a place in the JSON. Only looks can be left out.
  void check_pointer(const Json& target, const std::string& json_path) {
    static const Json::json_pointer kPointer("/extensions/KHR_animation_pointer/pointer");
    const std::string* pointer =
        target.contains(kPointer) ? target[kPointer].get_ptr<const std::string*>() : nullptr;
    for (const char* looks : {"/materials/", "/cameras/", "/extensions/KHR_lights_punctual/"}) {
      if (pointer != nullptr && pointer->starts_with(looks)) return;
    }
    document_.set_error(json_path, "'KHR_animation_pointer' is not read",
                        "bake the animation to node transforms");
  }

  void read_sampler(const Json& json, const std::string& path, const std::string& json_path,
                    GltfChannel& channel) {
    static const std::map<std::string, GltfPath> kPaths{{"translation", GltfPath::Translation},
                                                        {"rotation", GltfPath::Rotation},
                                                        {"scale", GltfPath::Scale},
                                                        {"weights", GltfPath::Weights}};
    static const std::map<std::string, GltfInterpolation> kInterpolations{
        {"LINEAR", GltfInterpolation::Linear},
        {"STEP", GltfInterpolation::Step},
        {"CUBICSPLINE", GltfInterpolation::CubicSpline}};
    const auto known_path = kPaths.find(path);
    const auto interpolation = kInterpolations.find(document_.text(json, "interpolation", "LINEAR"));
    if (known_path == kPaths.end() || interpolation == kInterpolations.end()) {
      document_.set_error(json_path, "its path or interpolation is not known");
      return;
    }
    channel.path = known_path->second;
    channel.interpolation = interpolation->second;
    const bool rotation = channel.path == GltfPath::Rotation, weights = channel.path == GltfPath::Weights;
    channel.times_index = document_.index(json, "input", "accessors", json_path);
    channel.times = document_.accessor(channel.times_index, "SCALAR", json_path);
    channel.values = document_.accessor(document_.index(json, "output", "accessors", json_path),
                                        weights ? "SCALAR" : (rotation ? "VEC4" : "VEC3"), json_path);
    if (failed()) return;
    const GltfNode& node = scene_.nodes[channel.node];
    const std::uint64_t values_per_key = (channel.interpolation == GltfInterpolation::CubicSpline ? 3 : 1) *
                                         (weights ? scene_.meshes[*node.mesh].targets : 1);
    if (channel.times.base.bytes == nullptr || channel.times.count() == 0 ||
        channel.values.count() != channel.times.count() * values_per_key) {
      document_.set_error(json_path, fmt::format("has {} times for {} values", channel.times.count(),
                                                 channel.values.count()));
      return;
    }
    check_times(channel.times_index, channel.times);
  }

  void check_times(std::size_t index, const GltfAccessor& times) {
    if (!checked_times_.insert(index).second) return;
    if (!document_.within_budget(times.count(), fmt::format("accessors[{}]", index))) return;
    for (std::uint64_t i = 0; i < times.count(); ++i) {
      const double time = times.get(i, 0);
      if (!std::isfinite(time) || time < 0 || (i > 0 && time <= times.get(i - 1, 0))) {
        document_.set_error(
            fmt::format("accessors[{}]", index),
            fmt::format("time {} of an animation is not finite, negative or not ascending", i));
        return;
      }
    }
  }

  GltfDocument& document_;
  GltfScene scene_;
  std::set<std::size_t> checked_times_;  // many channels share one list of times
};

}  // namespace

Result<GltfScene> read_gltf_scene(GltfDocument& document, const std::string& clip) {
  return SceneReader(document).read(clip);
}

}  // namespace foldproof::io
