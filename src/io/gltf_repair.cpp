#include "io/gltf_repair.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <map>

#include "base/try.h"
#include "io/glb.h"
#include "io/gltf_frames.h"
#include "io/gltf_pose.h"
#include "io/readers.h"

namespace foldproof::io {
namespace {

namespace fs = std::filesystem;
using Json = GltfDocument::Json;

constexpr std::uint64_t kMaxTargetWeights = std::uint64_t{1} << 26;  // of a node, in all frames: 256 MiB
constexpr int kFloatComponent = 5126, kIndexComponent = 5125;

/// What is added to the positions of an instance in a frame, before its node or joints move them.
struct Correction {
  std::vector<std::uint32_t> vertices;  // ascending, of the instance
  std::vector<float> values;            // three each
};

/// Frames of the source by number, and in each the instances that were moved.
using Corrections = std::map<Index, std::map<std::size_t, Correction>>;

/// Adds what moves a vertex from `x` to `y` in the world.
bool add_correction(const GltfPose::Affine& to_world, std::span<const double> x, std::span<const double> y,
                    std::size_t v, Correction& out) {
  const Eigen::Map<const Eigen::Vector3d> from(x.data()), to(y.data());
  const Eigen::Matrix3d linear = to_world.leftCols<3>();
  const Eigen::Vector3d moved = to - from, local = linear.fullPivLu().solve(moved);
  if (!((linear * local - moved).norm() <= 1e-6 * moved.norm())) return false;
  out.vertices.push_back(static_cast<std::uint32_t>(v));
  for (const double coordinate : local) out.values.push_back(static_cast<float>(coordinate));
  return true;
}

/// Adds to a glTF document. Its buffers become one.
class Builder {
 public:
  explicit Builder(const GltfDocument& document) : json(document.json()) {
    std::vector<std::size_t> begin;
    for (std::size_t i = 0; i < document_buffers(); ++i) {
      align();
      begin.push_back(bytes_.size());
      const auto buffer = document.buffer(i);
      bytes_.append(buffer.data(), buffer.size());
    }
    for (Json& view : list("bufferViews")) {
      const std::size_t buffer = view["buffer"];
      view["buffer"] = 0;
      view["byteOffset"] = view.value("byteOffset", std::size_t{0}) + begin[buffer];
    }
  }

  Json& list(const char* key) {
    if (!json.contains(key)) json[key] = Json::array();
    return json[key];
  }

  std::size_t scalars(const std::vector<float>& values) {
    Json accessor = {{"bufferView", view(values)},
                     {"componentType", kFloatComponent},
                     {"count", values.size()},
                     {"type", "SCALAR"}};
    const auto [least, most] = std::minmax_element(values.begin(), values.end());
    accessor["min"] = {*least};
    accessor["max"] = {*most};
    return add("accessors", accessor);
  }

  /// Vectors of which all are zero but those of a correction; null: none.
  std::size_t vectors(std::size_t count, const Correction* correction) {
    Json accessor = {{"componentType", kFloatComponent}, {"count", count}, {"type", "VEC3"}};
    std::array<float, 3> least{}, most{};
    if (correction != nullptr) {
      const auto& values = correction->values;
      for (std::size_t i = 0; i < values.size(); ++i) {
        least[i % 3] = std::min(least[i % 3], values[i]);
        most[i % 3] = std::max(most[i % 3], values[i]);
      }
      accessor["sparse"] = {
          {"count", correction->vertices.size()},
          {"indices", {{"bufferView", view(correction->vertices)}, {"componentType", kIndexComponent}}},
          {"values", {{"bufferView", view(values)}}}};
    }
    accessor["min"] = least;
    accessor["max"] = most;
    return add("accessors", accessor);
  }

  std::size_t add(const char* key, Json value) {
    list(key).push_back(std::move(value));
    return list(key).size() - 1;
  }

  Result<void> write(const std::string& path) {
    json["buffers"] = Json::array({{{"byteLength", bytes_.size()}}});
    return write_glb(path, json.dump(-1, ' ', false, Json::error_handler_t::replace), std::move(bytes_));
  }

  Json json;

 private:
  std::size_t document_buffers() { return list("buffers").size(); }
  void align() { bytes_.resize((bytes_.size() + 7) / 8 * 8); }

  template <class T>
  std::size_t view(const std::vector<T>& values) {
    static_assert(std::endian::native == std::endian::little, "glTF is little-endian");
    align();
    const std::size_t offset = bytes_.size(), length = values.size() * sizeof(T);
    bytes_.append(reinterpret_cast<const char*>(values.data()), length);
    return add("bufferViews", {{"buffer", 0}, {"byteOffset", offset}, {"byteLength", length}});
  }

  std::string bytes_;
};

class Repair {
 public:
  Repair(GltfDocument document, GltfScene scene, const ReadOptions& options)
      : document_(std::move(document)),
        scene_(std::move(scene)),
        frames_(options.fps, scene_.duration),
        pose_(scene_) {}

  /// Compares frames.
  Result<void> find(Motion& repaired, Index first_frame) {
    std::vector<double> x(3 * std::size_t{repaired.topology().vertex_count()}), y(x.size());
    for (Index k = 0; k < repaired.frame_count(); ++k) {
      const Index frame = first_frame + k;
      pose_.set_time(frames_.time(frame));
      FOLDPROOF_TRY(pose_.positions(fmt::format("{}, frame {}", document_.path(), frame), x));
      FOLDPROOF_TRY(repaired.read_frame(k, y));
      FOLDPROOF_TRY(compare(frame, x, y));
    }
    return {};
  }

  Result<void> write(const std::string& path, const GltfRepairNote& note, const ReadOptions& options) {
    Builder builder(document_);
    for (const std::size_t node : scene_.mesh_nodes) {
      std::vector<Index> frames;
      for (const auto& [frame, moved] : corrections_) {
        if (std::ranges::any_of(moved,
                                [&](const auto& each) { return pose_.instances()[each.first].node == node; }))
          frames.push_back(frame);
      }
      if (!frames.empty()) FOLDPROOF_TRY(add_to_node(builder, node, frames));
    }
    Json said = {{"verdict", note.verdict}, {"free", note.free}, {"fps", options.fps}};
    if (!scene_.clips.empty()) said["clip"] = scene_.clips[scene_.clip];
    if (scene_.duration > 0)
      said["proven_for"] = "straight lines from each frame, sampled at this rate, to the next";
    builder.json["asset"]["extras"]["foldproof"] = said;
    return builder.write(path);
  }

 private:
  Result<void> compare(Index frame, std::span<const double> x, std::span<const double> y) {
    for (std::size_t i = 0; i < pose_.instances().size(); ++i) {
      const GltfInstance& instance = pose_.instances()[i];
      Correction found;
      for (std::size_t v = 0; v < instance.vertex_count; ++v) {
        const std::size_t at = 3 * (instance.first_vertex + v);
        const auto from = x.subspan(at, 3), to = y.subspan(at, 3);
        if (std::equal(from.begin(), from.end(), to.begin())) continue;
        if (add_correction(pose_.to_world(instance, v), from, to, v, found)) continue;
        return fail(
            ErrorCode::UnsupportedFormat,
            fmt::format("{}, frame {}, vertex {}", document_.path(), frame, instance.first_vertex + v),
            "was moved, but its joints or its node flatten it, so no morph target can move it",
            "write .npz instead");
      }
      if (!found.vertices.empty()) corrections_[frame].emplace(i, std::move(found));
    }
    return {};
  }

  Result<void> add_to_node(Builder& builder, std::size_t node, const std::vector<Index>& frames) {
    Json& json = builder.list("nodes")[node];
    std::size_t number = *scene_.nodes[node].mesh;
    const GltfMesh& mesh = scene_.meshes[number];
    if (std::ranges::count_if(scene_.nodes, [&](const GltfNode& each) { return each.mesh == number; }) > 1) {
      number = builder.add("meshes", Json(builder.list("meshes")[number]));
      json["mesh"] = number;
    }
    add_targets(builder, builder.list("meshes")[number], node, mesh, frames);
    const bool still = scene_.clips.empty();
    for (Json* owner : {&json, &builder.list("meshes")[number]}) {
      if (owner == &json && !owner->contains("weights")) continue;
      Json& weights = (*owner)["weights"];
      if (weights.is_null()) weights = std::vector<double>(mesh.targets, 0);
      for (std::size_t k = 0; k < frames.size(); ++k) weights.push_back(still ? 1 : 0);
    }
    return still ? Result<void>{} : animate(builder, node, mesh.targets, frames);
  }

  /// A target for each frame, of all primitives.
  void add_targets(Builder& builder, Json& json, std::size_t node, const GltfMesh& mesh,
                   const std::vector<Index>& frames) {
    std::map<std::pair<std::size_t, Index>, std::size_t> made;  // by vertex set and frame
    std::size_t number = 0;
    for (Json& primitive : json["primitives"]) {
      if (!primitive["attributes"].contains("POSITION")) continue;  // the reader skips it, too
      const std::size_t set = mesh.primitives[number++].vertex_set;
      const std::size_t count = mesh.vertex_sets[set].position.count();
      Json& targets = primitive["targets"];
      if (targets.is_null()) targets = Json::array();
      while (targets.size() < mesh.targets)  // of lines and points, which may have fewer
        targets.push_back({{"POSITION", builder.vectors(count, nullptr)}});
      const Json like = targets.empty() ? Json::object() : targets[0];
      for (const Index frame : frames) {
        const auto [entry, is_new] = made.try_emplace({set, frame});
        if (is_new) entry->second = builder.vectors(count, correction_of(node, set, frame));
        Json target = {{"POSITION", entry->second}};
        for (const auto& [attribute, accessor] : like.items()) {  // all targets have the same attributes
          if (attribute != "POSITION") target[attribute] = builder.vectors(count, nullptr);
        }
        targets.push_back(std::move(target));
      }
    }
    Json& names = json["extras"]["targetNames"];
    if (names.is_null()) names = Json::array();
    if (names.size() != mesh.targets) return;
    for (const Index frame : frames) names.push_back(fmt::format("foldproof, frame {}", frame));
  }

  const Correction* correction_of(std::size_t node, std::size_t set, Index frame) const {
    for (const auto& [i, correction] : corrections_.at(frame)) {
      const GltfInstance& instance = pose_.instances()[i];
      if (instance.node == node && instance.vertex_set == set) return &correction;
    }
    return nullptr;
  }

  /// Gives the node's weights an animation in the clip, and as many as they are now in others.
  Result<void> animate(Builder& builder, std::size_t node, std::size_t targets,
                       const std::vector<Index>& frames) {
    Json& animations = builder.list("animations");
    for (std::size_t i = 0; i < animations.size(); ++i) {
      Json& animation = animations[i];
      Json channels = Json::array();
      for (Json& channel : animation["channels"]) {
        const Json& target = channel["target"];
        if (target.value("node", node + 1) == node && target.value("path", "") == "weights") {
          if (i == scene_.clip) continue;
          FOLDPROOF_TRY(widen(builder, animation, channel, targets, frames.size()));
        }
        channels.push_back(channel);
      }
      animation["channels"] = std::move(channels);
    }
    std::vector<float> times = key_times(node);
    if (times.size() * (targets + frames.size()) > kMaxTargetWeights)
      return fail(ErrorCode::LimitExceeded, document_.path(),
                  fmt::format("would have {} morph targets in {} frames, which are too many", frames.size(),
                              times.size()),
                  "repair fewer frames (--frames), or write .npz");
    std::vector<float> values;
    for (const float time : times) add_weights(values, node, targets, frames, static_cast<double>(time));
    Json& animation = builder.list("animations")[scene_.clip];
    animation["samplers"].push_back({{"input", builder.scalars(times)},
                                     {"output", builder.scalars(values)},
                                     {"interpolation", "LINEAR"}});
    animation["channels"].push_back(
        {{"sampler", animation["samplers"].size() - 1}, {"target", {{"node", node}, {"path", "weights"}}}});
    return {};
  }

  /// The times of frames, and of keys of the node's own weights.
  std::vector<float> key_times(std::size_t node) const {
    std::vector<float> times;
    for (Index k = 0; k < static_cast<Index>(frames_.count()); ++k)
      times.push_back(static_cast<float>(frames_.time(k)));
    if (const GltfChannel* own = channel_of(node)) {
      for (std::uint64_t i = 0; i < own->times.count(); ++i) {
        const double key = own->times.get(i, 0);
        if (!frames_.shows(key)) times.push_back(static_cast<float>(key));
      }
    }
    std::ranges::sort(times);
    times.erase(std::unique(times.begin(), times.end()), times.end());
    return times;
  }

  const GltfChannel* channel_of(std::size_t node) const {
    const auto found = std::ranges::find_if(scene_.channels, [&](const GltfChannel& channel) {
      return channel.node == node && channel.path == GltfPath::Weights;
    });
    return found == scene_.channels.end() ? nullptr : &*found;
  }

  /// At a time: the node's own weights, then those of frames, of which each is 1 at its frame and 0 at
  /// others.
  void add_weights(std::vector<float>& values, std::size_t node, std::size_t targets,
                   const std::vector<Index>& frames, double time) const {
    std::vector<double> own = scene_.nodes[node].weights;
    if (own.empty()) own = scene_.meshes[*scene_.nodes[node].mesh].weights;
    own.resize(targets);
    if (const GltfChannel* channel = channel_of(node)) sample_channel(*channel, time, own);
    for (const double weight : own) values.push_back(static_cast<float>(weight));
    for (const Index frame : frames) {
      const double at = frames_.time(frame);
      if (is_time_of_key(at, time)) {
        values.push_back(1);
        continue;
      }
      const double next = time < at ? (frame == 0 ? at : frames_.time(frame - 1.0))
                                    : (frame + 1.0 < frames_.count() ? frames_.time(frame + 1.0) : at);
      const double share = next == at ? 0 : 1 - (time - at) / (next - at);
      values.push_back(static_cast<float>(is_time_of_key(next, time) ? 0 : std::max(share, 0.0)));
    }
  }

  /// A sampler of its own for a channel of weights, with zeros for the targets that were added.
  Result<void> widen(Builder& builder, Json& animation, Json& channel, std::size_t targets,
                     std::size_t added) {
    Json sampler = animation["samplers"][channel["sampler"].get<std::size_t>()];
    const GltfAccessor old = document_.accessor(sampler["output"], "SCALAR", "animations");
    if (document_.error()) return tl::unexpected(*document_.error());
    std::vector<float> values;
    const std::uint64_t rows = targets == 0 ? 0 : old.count() / targets;
    for (std::uint64_t row = 0; row < rows; ++row) {
      for (std::uint64_t t = 0; t < targets; ++t)
        values.push_back(static_cast<float>(old.get(row * targets + t, 0)));
      values.resize(values.size() + added);
    }
    if (values.empty()) return {};
    sampler["output"] = builder.scalars(values);
    animation["samplers"].push_back(sampler);
    channel["sampler"] = animation["samplers"].size() - 1;
    return {};
  }

  GltfDocument document_;
  GltfScene scene_;
  GltfFrames frames_;
  GltfPose pose_;
  Corrections corrections_;
};

tl::unexpected<Error> other_json(const std::string& source) {
  return fail(ErrorCode::InvalidFile, source, "has images, extensions or extras of another form than glTF's",
              "export the file again, or write .npz");
}

}  // namespace

Result<void> require_gltf_can_be_repaired(const std::string& path, const std::string& source) try {
  if (extension_of(source) != ".glb" && extension_of(source) != ".gltf")
    return fail(ErrorCode::UnsupportedFormat, path, fmt::format("is GLB, and {} is no glTF file", source),
                "name it .npz, .obj or .ply");
  const auto document = FOLDPROOF_TRY(GltfDocument::read(source, {}));
  const Json& json = document.json();
  const auto directory = [](const std::string& file) {
    std::error_code code;
    return fs::weakly_canonical(fs::absolute(file, code).parent_path(), code);
  };
  for (const Json& name : json.value("extensionsUsed", Json::array())) {
    if (name == "KHR_draco_mesh_compression" || name == "EXT_meshopt_compression")
      return fail(ErrorCode::UnsupportedFormat, source,
                  fmt::format("is compressed ({}), so it cannot be written again", name.get<std::string>()),
                  "export it without compression, or write .npz");
  }
  for (const Json& image : json.value("images", Json::array())) {
    const std::string uri = image.value("uri", "data:");
    if (!uri.starts_with("data:") && directory(path) != directory(source))
      return fail(ErrorCode::UnsupportedFormat, path,
                  fmt::format("would not find the image '{}' of {}", uri.substr(0, 200), source),
                  "name a file in the same directory");
  }
  return {};
} catch (const Json::exception&) {
  return other_json(source);
}

Result<void> write_gltf_repair(const std::string& path, const std::string& source, const ReadOptions& options,
                               Motion& repaired, Index first_frame, const GltfRepairNote& note) try {
  auto document = FOLDPROOF_TRY(GltfDocument::read(source, {}));
  auto scene = FOLDPROOF_TRY(read_gltf_scene(document, options.clip));
  Repair repair(std::move(document), std::move(scene), options);
  FOLDPROOF_TRY(repair.find(repaired, first_frame));
  return repair.write(path, note, options);
} catch (const Json::exception&) {
  return other_json(source);
}

}  // namespace foldproof::io
