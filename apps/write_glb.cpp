#include "write_glb.h"

#include <bit>
#include <cstring>
#include <nlohmann/json.hpp>

#include "base/try.h"
#include "io/glb.h"

namespace foldproof {
namespace {

static_assert(std::endian::native == std::endian::little, "GLB is little-endian");

using Json = nlohmann::ordered_json;

constexpr int kFloat = 5126, kUnsignedInt = 5125;  // glTF 2.0, section 3.6.2.2

/// The only buffer, and what describes it.
class Buffer {
 public:
  /// Adds an array of vectors of `width` numbers; returns its accessor.
  template <class T>
  std::size_t add(const std::vector<T>& values, std::size_t width) {
    const std::size_t bytes = values.size() * sizeof(T), offset = bytes_.size();
    bytes_.resize(offset + bytes);
    std::memcpy(bytes_.data() + offset, values.data(), bytes);
    views_.push_back({{"buffer", 0}, {"byteOffset", offset}, {"byteLength", bytes}});
    std::vector<T> least(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(width)), most = least;
    for (std::size_t k = 0; k < values.size(); ++k) {
      least[k % width] = std::min(least[k % width], values[k]);
      most[k % width] = std::max(most[k % width], values[k]);
    }
    accessors_.push_back(
        {{"bufferView", views_.size() - 1},
         {"componentType", sizeof(T) == sizeof(float) && std::is_floating_point_v<T> ? kFloat : kUnsignedInt},
         {"count", values.size() / width},
         {"type", width == 3 ? "VEC3" : "SCALAR"},
         {"min", least},
         {"max", most}});
    return accessors_.size() - 1;
  }

  const std::string& bytes() const { return bytes_; }
  const Json& views() const { return views_; }
  const Json& accessors() const { return accessors_; }

 private:
  std::string bytes_;
  Json views_ = Json::array(), accessors_ = Json::array();
};

/// Adds the first frame, then what each other one adds to it. Returns their accessors.
Result<std::vector<std::size_t>> add_frames(Motion& motion, Buffer& buffer) {
  std::vector<double> x(3 * std::size_t{motion.topology().vertex_count()});
  std::vector<float> first, frame(x.size());
  std::vector<std::size_t> accessors;
  for (Index k = 0; k < motion.frame_count(); ++k) {
    FOLDPROOF_TRY(motion.read_frame(k, x));
    for (std::size_t i = 0; i < x.size(); ++i)
      frame[i] = static_cast<float>(x[i]) - (k == 0 ? 0.0F : first[i]);
    if (k == 0) first = frame;
    accessors.push_back(buffer.add(frame, 3));
  }
  return accessors;
}

/// At frame k, only the target of that frame counts.
Json animation(Index frames, Buffer& buffer) {
  std::vector<float> times, weights;
  for (Index k = 0; k < frames; ++k) {
    times.push_back(static_cast<float>(k) / 24);
    for (Index target = 1; target < frames; ++target) weights.push_back(target == k ? 1 : 0);
  }
  const std::size_t input = buffer.add(times, 1), output = buffer.add(weights, 1);
  return {{"samplers", {{{"input", input}, {"output", output}, {"interpolation", "LINEAR"}}}},
          {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "weights"}}}}}}};
}

}  // namespace

Result<void> write_glb(const std::string& path, Motion& motion) {
  Buffer buffer;
  std::vector<std::uint32_t> corners;
  for (const Triangle& triangle : motion.topology().triangles())
    corners.insert(corners.end(), triangle.begin(), triangle.end());
  const std::size_t indices = buffer.add(corners, 1);
  const auto frames = FOLDPROOF_TRY(add_frames(motion, buffer));
  Json targets = Json::array();
  for (std::size_t k = 1; k < frames.size(); ++k) targets.push_back({{"POSITION", frames[k]}});
  const Json primitive = {
      {"attributes", {{"POSITION", frames[0]}}}, {"indices", indices}, {"targets", targets}};
  Json document = {{"asset", {{"version", "2.0"}, {"generator", "foldproof"}}},
                   {"scene", 0},
                   {"scenes", {{{"nodes", {0}}}}},
                   {"nodes", {{{"mesh", 0}}}},
                   {"meshes", {{{"primitives", {primitive}}}}}};
  document["animations"] = Json::array({animation(motion.frame_count(), buffer)});
  document["bufferViews"] = buffer.views();
  document["accessors"] = buffer.accessors();
  document["buffers"] = Json::array({{{"byteLength", buffer.bytes().size()}}});

  return io::write_glb(path, document.dump(), buffer.bytes());
}

}  // namespace foldproof
