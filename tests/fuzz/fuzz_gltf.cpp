// A glTF or GLB file as it is when the bytes start like one. Otherwise the bytes are JSON and a buffer, put
// into a good GLB first, and half of the changes are made to values of the JSON: changes to its text rarely
// leave any.
#include <nlohmann/json.hpp>
#include <random>

#include "file_target.h"

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

namespace {

using Json = nlohmann::json;

/// Two bytes tell how long the JSON is.
struct Parts {
  Parts(const std::uint8_t* data, std::size_t size) {
    const std::size_t cut = std::min<std::size_t>(data[0] + 256u * data[1], size - 2);
    json.assign(data + 2, data + 2 + cut);
    buffer.assign(data + 2 + cut, data + size);
  }
  std::string json, buffer;
};

void append_word(std::string& bytes, std::size_t word) {
  for (int k = 0; k < 4; ++k) bytes += static_cast<char>(word >> (8 * k) & 0xff);
}

std::string glb(const Parts& parts) {
  std::string bytes = "glTF";
  append_word(bytes, 2);
  append_word(bytes, 28 + parts.json.size() + parts.buffer.size());
  append_word(bytes, parts.json.size());
  bytes += "JSON" + parts.json;
  append_word(bytes, parts.buffer.size());
  return bytes + std::string("BIN\0", 4) + parts.buffer;
}

/// One value somewhere in the JSON becomes another, goes, or is repeated.
void change(Json& json, std::mt19937& random) {
  Json* at = &json;
  Json* parent = nullptr;
  std::size_t place = 0;
  while (at->is_structured() && !at->empty() && (parent == nullptr || random() % 8 != 0)) {
    parent = at;
    place = random() % at->size();
    at = &*std::next(at->begin(), static_cast<std::ptrdiff_t>(place));
  }
  static const std::vector<Json> kValues{0,
                                         1,
                                         2,
                                         3,
                                         4,
                                         5,
                                         6,
                                         12,
                                         16,
                                         -1,
                                         5121,
                                         5123,
                                         5125,
                                         5126,
                                         65535,
                                         4294967295u,
                                         1099511627775u,
                                         0.5,
                                         -1e38,
                                         1e300,
                                         true,
                                         "VEC3",
                                         "VEC4",
                                         "SCALAR",
                                         "MAT4",
                                         "STEP",
                                         "CUBICSPLINE",
                                         "LINEAR",
                                         "weights",
                                         "rotation",
                                         Json::array(),
                                         Json::object()};
  switch (random() % 4) {
    case 0:
      if (parent != nullptr) parent->erase(std::next(parent->begin(), static_cast<std::ptrdiff_t>(place)));
      break;
    case 1:
      if (parent != nullptr && parent->is_array()) parent->push_back(Json(*at));
      break;
    default:
      *at = kValues[random() % kValues.size()];
  }
}

}  // namespace

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size,
                                               unsigned seed) {
  std::mt19937 random(seed);
  if (size < 2 || data[0] == '{' || data[0] == 'g' || random() % 2 == 0)
    return LLVMFuzzerMutate(data, size, max_size);
  const Parts parts(data, size);
  Json json = Json::parse(parts.json, nullptr, false);
  if (json.is_discarded()) return LLVMFuzzerMutate(data, size, max_size);
  for (unsigned i = 0; i <= random() % 3; ++i) change(json, random);
  const std::string text = json.dump(-1, ' ', false, Json::error_handler_t::replace);
  const std::size_t total = 2 + text.size() + parts.buffer.size();
  if (text.size() > 0xffff || total > max_size || (text.size() & 0xff) == '{' || (text.size() & 0xff) == 'g')
    return size;
  data[0] = static_cast<std::uint8_t>(text.size() & 0xff);
  data[1] = static_cast<std::uint8_t>(text.size() >> 8);
  std::copy(text.begin(), text.end(), data + 2);
  std::copy(parts.buffer.begin(), parts.buffer.end(), data + 2 + text.size());
  return total;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 2 || data[0] == '{' || data[0] == 'g') return foldproof::fuzz::read_as(".gltf", data, size);
  const std::string bytes = glb(Parts(data, size));
  return foldproof::fuzz::read_as(".glb", reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
}
