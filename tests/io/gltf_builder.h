/// Builds small glTF files for tests: numbers go into one buffer, the test sets the JSON.
#pragma once

#include <nlohmann/json.hpp>

#include "io/support.h"

namespace foldproof::testing {

using Json = nlohmann::json;

class GltfBuilder {
 public:
  GltfBuilder() {
    json["asset"]["version"] = "2.0";
    json["scene"] = 0;
    json["scenes"] = {{{"nodes", {0}}}};
  }

  /// Adds bytes as a buffer view; returns its index.
  int view(const std::string& bytes, int stride = 0) {
    buffer.resize((buffer.size() + 3) / 4 * 4);
    json["bufferViews"].push_back(
        {{"buffer", 0}, {"byteOffset", buffer.size()}, {"byteLength", bytes.size()}});
    if (stride > 0) json["bufferViews"].back()["byteStride"] = stride;
    buffer += bytes;
    return static_cast<int>(json["bufferViews"].size()) - 1;
  }

  template <class T>
  static int component_type() {
    if constexpr (std::is_same_v<T, std::int8_t>) return 5120;
    if constexpr (std::is_same_v<T, std::uint8_t>) return 5121;
    if constexpr (std::is_same_v<T, std::int16_t>) return 5122;
    if constexpr (std::is_same_v<T, std::uint16_t>) return 5123;
    if constexpr (std::is_same_v<T, std::uint32_t>) return 5125;
    return 5126;
  }

  /// Adds numbers as an accessor; returns its index.
  template <class T>
  int accessor(const std::string& type, const std::vector<T>& values) {
    const std::size_t width = type == "SCALAR" ? 1 : type == "VEC3" ? 3 : type == "VEC4" ? 4 : 16;
    std::string bytes;
    for (const T x : values) bytes += bytes_of(x);
    json["accessors"].push_back({{"bufferView", view(bytes)},
                                 {"componentType", component_type<T>()},
                                 {"count", values.size() / width},
                                 {"type", type}});
    return static_cast<int>(json["accessors"].size()) - 1;
  }
  int floats(const std::string& type, const std::vector<float>& values) { return accessor(type, values); }

  /// Adds a mesh of one triangle (0,0,0) (1,0,0) (0,1,0); returns its primitive.
  Json& triangle() {
    const int position = floats("VEC3", {0, 0, 0, 1, 0, 0, 0, 1, 0});
    json["meshes"].push_back({{"primitives", {{{"attributes", {{"POSITION", position}}}}}}});
    return json["meshes"].back()["primitives"][0];
  }

  /// Adds an animation of one channel; returns its sampler.
  Json& animate(int node, const std::string& path, int times, int values) {
    json["animations"].push_back(
        {{"channels", {{{"sampler", 0}, {"target", {{"node", node}, {"path", path}}}}}},
         {"samplers", {{{"input", times}, {"output", values}}}}});
    return json["animations"].back()["samplers"][0];
  }

  /// Makes one clip of all animations.
  void play_together() {
    Json& whole = json["animations"][0];
    for (std::size_t i = 1; i < json["animations"].size(); ++i) {
      const Json& clip = json["animations"][i];
      for (Json channel : clip["channels"]) {
        channel["sampler"] = channel["sampler"].get<std::size_t>() + whole["samplers"].size();
        whole["channels"].push_back(channel);
      }
      for (const Json& sampler : clip["samplers"]) whole["samplers"].push_back(sampler);
    }
    json["animations"].erase(json["animations"].begin() + 1, json["animations"].end());
  }

  static std::string base64(const std::string& bytes) {
    const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
      std::uint32_t bits = 0;
      for (std::size_t k = 0; k < 3; ++k) {
        bits = bits << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
      }
      for (int k = 3; k >= 0; --k) text += digits[bits >> (6 * k) & 63];
    }
    for (std::size_t k = 0; k < (3 - bytes.size() % 3) % 3; ++k) text[text.size() - 1 - k] = '=';
    return text;
  }

  /// With the buffer embedded.
  std::string gltf() {
    json["buffers"] = {
        {{"byteLength", buffer.size()}, {"uri", "data:application/octet-stream;base64," + base64(buffer)}}};
    return json.dump();
  }
  /// With the buffer in a separate file.
  std::string gltf_beside(const std::string& uri) {
    json["buffers"] = {{{"byteLength", buffer.size()}, {"uri", uri}}};
    return json.dump();
  }
  std::string glb() {
    json["buffers"] = {{{"byteLength", buffer.size()}}};
    std::string text = json.dump(), binary = buffer;
    text.resize((text.size() + 3) / 4 * 4, ' ');
    binary.resize((binary.size() + 3) / 4 * 4);
    const auto word = [](std::size_t x) { return bytes_of(static_cast<std::uint32_t>(x)); };
    return "glTF" + word(2) + word(12 + 8 + text.size() + 8 + binary.size()) + word(text.size()) + "JSON" +
           text + word(binary.size()) + std::string("BIN\0", 4) + binary;
  }

  Json json;
  std::string buffer;
};

class GltfIoTest : public IoTest {
 protected:
  std::unique_ptr<Motion> gltf(GltfBuilder& b, const ReadOptions& options = {}) {
    return open({files.write("a.gltf", b.gltf())}, options);
  }
};

}  // namespace foldproof::testing
