// glTF and GLB as a motion: the scene is evaluated at the time of each frame.
//
// tinygltf is not used: it reports no locations, opens any file that a URI names, and leaves all range checks
// to its caller, which are most of the work.
#include <fmt/format.h>

#include <cmath>
#include <map>
#include <numeric>
#include <utility>

#include "base/try.h"
#include "io/gltf_frames.h"
#include "io/gltf_parts.h"
#include "io/gltf_pose.h"
#include "io/readers.h"

namespace foldproof::io {
namespace {

constexpr double kMaxFrames = 1e6;
constexpr std::uint64_t kMaxInstanced = std::uint64_t{1} << 27;  // vertices or corners, of all instances
// Positions, morph targets and joints that evaluating a frame reads. Accessors may share bytes, so the size
// of the file does not limit them.
constexpr std::uint64_t kMaxPerFrame = std::uint64_t{1} << 32;
constexpr std::uint64_t kMaxMorphWeights = std::uint64_t{1} << 26;  // animated, of all nodes

class GltfMotion final : public Motion {
 public:
  GltfMotion(GltfDocument document, GltfScene scene, const ReadOptions& options)
      : document_(std::move(document)),
        scene_(std::move(scene)),
        fps_(options.fps),
        weld_(options.weld),
        frames_(fps_, scene_.duration),
        pose_(scene_) {}

  Result<void> open() {
    if (!(frames_.count() <= kMaxFrames)) {
      return fail(ErrorCode::LimitExceeded, name(),
                  fmt::format("{} seconds at {} frames a second are too many frames", scene_.duration, fps_),
                  "choose a lower --fps");
    }
    info_.unit = "m";
    info_.notes = scene_.notes;
    info_.clips = scene_.clips;
    info_.taken_as = scene_.taken_as;
    if (!scene_.unchecked.empty()) info_.unchecked.push_back(scene_.unchecked);
    if (std::string note = note_on_keys(scene_, fps_, kMaxFrames); !note.empty())
      info_.notes.push_back(std::move(note));
    FOLDPROOF_TRY(check_size());
    GltfElements found;
    for (const std::size_t node : scene_.mesh_nodes) {
      FOLDPROOF_TRY(add_node(node, found));
    }
    MeshElements elements = found.finish();
    if (elements.values.empty())
      return fail(ErrorCode::InvalidFile, name(), "shows no triangles, lines or points",
                  "export a scene with meshes");
    info_.parts = gltf_parts(scene_, found.runs(), elements);
    const std::vector<Index> run_of = std::exchange(elements.values, std::move(info_.parts.of_triangle));
    if (weld_ == Weld::ByFormat) {
      info_.layered = true;
      info_.merged = find_seams();
      if (!info_.merged.empty()) elements.merge(info_.merged);
      add_notes(
          count_layers(elements.faces, static_cast<Index>(vertex_count_),
                       gltf_surfaces(scene_, found.runs(), std::span(run_of).first(elements.faces.size()))),
          info_);
    }
    info_.parts.of_triangle = std::move(elements.values);
    topology_ = FOLDPROOF_TRY(make_topology(static_cast<Index>(vertex_count_), std::move(elements.faces),
                                            elements.lines, elements.points, info_.parts));
    return {};
  }

  const std::string& name() const override { return document_.path(); }
  const Topology& topology() const override { return topology_; }
  const MotionInfo& info() const override { return info_; }
  Index frame_count() const override { return static_cast<Index>(frames_.count()); }

  Result<void> read_frame(Index k, std::span<double> out) override {
    FOLDPROOF_TRY(check_request(*this, k, out));
    pose_.set_time(frames_.time(k));
    const std::string where = fmt::format("{}, frame {}", name(), k);
    FOLDPROOF_TRY(pose_.positions(where, out));
    return check_finite(where, out);
  }

 private:
  /// A small file can instantiate a mesh very often, so instances are counted before any is made.
  Result<void> check_size() const {
    std::vector<Size> sizes;
    for (const GltfMesh& mesh : scene_.meshes) sizes.push_back(size_of(mesh));
    Size total;
    for (const std::size_t node : scene_.mesh_nodes) {
      const Size& size = sizes[*scene_.nodes[node].mesh];
      total.vertices += size.vertices;
      total.corners += size.corners;
      total.values += size.values;
      if (total.vertices > kMaxInstanced || total.corners > kMaxInstanced) {
        return fail(ErrorCode::LimitExceeded, name(),
                    fmt::format("shows more than {} vertices or corners of triangles", kMaxInstanced),
                    "export fewer copies of its meshes");
      }
      if (total.values > kMaxPerFrame) {
        return fail(ErrorCode::LimitExceeded, name(),
                    fmt::format("has more than {} morph targets and joints of vertices", kMaxPerFrame),
                    "export fewer copies of its meshes, or fewer morph targets");
      }
    }
    std::uint64_t weights = 0;  // of nodes outside the scene, too
    std::vector<bool> counted(scene_.nodes.size());
    for (const GltfChannel& channel : scene_.channels) {
      if (channel.path != GltfPath::Weights || counted[channel.node]) continue;
      counted[channel.node] = true;
      weights += scene_.meshes[*scene_.nodes[channel.node].mesh].targets;
    }
    if (weights > kMaxMorphWeights) {
      return fail(ErrorCode::LimitExceeded, name(),
                  fmt::format("animates more than {} weights of morph targets", kMaxMorphWeights),
                  "export fewer animated meshes, or fewer morph targets");
    }
    return {};
  }

  struct Size {
    std::uint64_t vertices = 0, corners = 0, values = 0;
  };
  // Each is below 2^40 times the number of vertex sets or primitives. A primitive without corners counts as
  // one, since it takes time too.
  static Size size_of(const GltfMesh& mesh) {
    Size size;
    for (const GltfVertexSet& set : mesh.vertex_sets) {
      size.vertices += set.position.count();
      size.values += set.position.count() * (1 + set.targets.size() + set.influences.size());
    }
    for (const GltfPrimitive& primitive : mesh.primitives) {
      size.corners += std::max<std::uint64_t>(
          1, corner_count(primitive, mesh.vertex_sets[primitive.vertex_set].position.count()));
    }
    return size;
  }

  /// Adds the vertices and elements of a node's mesh.
  Result<void> add_node(std::size_t node, GltfElements& elements) {
    const std::size_t mesh_index = *scene_.nodes[node].mesh;
    const GltfMesh& mesh = scene_.meshes[mesh_index];
    std::vector<std::size_t> first_vertex;
    for (const GltfVertexSet& set : mesh.vertex_sets) {
      first_vertex.push_back(vertex_count_);
      vertex_count_ += set.position.count();
    }
    for (std::size_t p = 0; p < mesh.primitives.size(); ++p) {
      const GltfPrimitive& primitive = mesh.primitives[p];
      FOLDPROOF_TRY(elements.add({node, &primitive, static_cast<Index>(first_vertex[primitive.vertex_set])},
                                 mesh.vertex_sets[primitive.vertex_set].position.count(),
                                 fmt::format("{}, meshes[{}].primitives[{}]", name(), mesh_index, p)));
    }
    return {};
  }

  /// MotionInfo::merged: vertices that are one by construction, within the mesh of each node.
  std::vector<Index> find_seams() const {
    std::vector<Index> merged(vertex_count_);
    std::iota(merged.begin(), merged.end(), Index{0});
    std::map<std::size_t, std::vector<Index>> seams;  // per mesh
    std::size_t first = 0;                            // vertex of the node
    bool any = false;
    for (const std::size_t node : scene_.mesh_nodes) {
      const std::size_t number = *scene_.nodes[node].mesh;
      const auto [of_mesh, is_new] = seams.try_emplace(number);
      if (is_new) of_mesh->second = gltf_seams(scene_.meshes[number]);
      for (std::size_t v = 0; v < of_mesh->second.size(); ++v) {
        merged[first + v] = static_cast<Index>(first + of_mesh->second[v]);
        any |= of_mesh->second[v] != v;
      }
      for (const GltfVertexSet& set : scene_.meshes[number].vertex_sets) first += set.position.count();
    }
    return any ? merged : std::vector<Index>();
  }

  GltfDocument document_;
  GltfScene scene_;
  double fps_;
  Weld weld_;
  GltfFrames frames_;
  std::size_t vertex_count_ = 0;
  Topology topology_;
  MotionInfo info_;
  GltfPose pose_;
};

}  // namespace

Result<std::unique_ptr<Motion>> open_gltf(const std::string& path, const ReadOptions& options,
                                          const ReadProgress& progress) {
  if (!(options.fps > 0) || !std::isfinite(options.fps)) {
    return fail(ErrorCode::InvalidArgument, "--fps", fmt::format("{} is not a sampling rate", options.fps),
                "give a number above zero");
  }
  auto document = FOLDPROOF_TRY(GltfDocument::read(path, progress));
  auto scene = FOLDPROOF_TRY(read_gltf_scene(document, options.clip));
  auto motion = std::make_unique<GltfMotion>(std::move(document), std::move(scene), options);
  FOLDPROOF_TRY(motion->open());
  return motion;
}

}  // namespace foldproof::io
