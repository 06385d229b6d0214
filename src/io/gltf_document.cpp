#include "io/gltf_document.h"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>

#include "base/try.h"
#include "io/base64.h"
#include "system/c_locale.h"

namespace foldproof::io {
namespace {

namespace fs = std::filesystem;
using Json = GltfDocument::Json;

constexpr int kByte = 5120, kUnsignedByte = 5121, kShort = 5122, kUnsignedShort = 5123, kUnsignedInt = 5125,
              kFloat = 5126;
constexpr std::uint64_t kCountLimit = std::uint64_t{1} << 40;
constexpr std::uint64_t kMaxValues = std::uint64_t{1} << 27;  // the budget of GltfDocument::within_budget

std::uint64_t component_bytes(int type) {
  if (type == kByte || type == kUnsignedByte) return 1;
  if (type == kShort || type == kUnsignedShort) return 2;
  return type == kUnsignedInt || type == kFloat ? 4 : 0;
}

int component_count(std::string_view type) {
  if (type == "SCALAR") return 1;
  if (type == "VEC2") return 2;
  if (type == "VEC3") return 3;
  if (type == "VEC4") return 4;
  return type == "MAT4" ? 16 : 0;
}

std::optional<std::vector<char>> decode_base64(std::string_view text) {
  while (text.ends_with('=')) text.remove_suffix(1);
  std::vector<char> bytes;
  bytes.reserve(text.size() / 4 * 3 + 3);
  std::uint32_t bits = 0;
  int bit_count = 0;
  for (const char c : text) {
    const int digit = base64_digit(c);
    if (digit < 0) return std::nullopt;
    bits = (bits << 6 | static_cast<std::uint32_t>(digit)) & 0xffffff;
    bit_count += 6;
    if (bit_count >= 8) {
      bit_count -= 8;
      bytes.push_back(static_cast<char>(bits >> bit_count & 0xff));
    }
  }
  return bytes;
}

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  return c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
}

/// Undoes percent-encoding.
std::string decode_percent(std::string_view text) {
  std::string decoded;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '%' && i + 2 < text.size() && hex_digit(text[i + 1]) >= 0 && hex_digit(text[i + 2]) >= 0) {
      decoded += static_cast<char>(hex_digit(text[i + 1]) * 16 + hex_digit(text[i + 2]));
      i += 2;
    } else {
      decoded += text[i];
    }
  }
  return decoded;
}

}  // namespace

double GltfValues::get(std::uint64_t i, int component) const {
  if (bytes == nullptr) return 0;
  const char* address =
      bytes + i * stride + static_cast<std::uint64_t>(component) * component_bytes(component_type);
  constexpr std::endian kLittle = std::endian::little;
  switch (component_type) {
    case kByte: {
      const double x = load<std::int8_t>(address, kLittle);
      return normalized ? std::max(x / 127, -1.0) : x;
    }
    case kUnsignedByte:
      return load<std::uint8_t>(address, kLittle) / (normalized ? 255.0 : 1.0);
    case kShort: {
      const double x = load<std::int16_t>(address, kLittle);
      return normalized ? std::max(x / 32767, -1.0) : x;
    }
    case kUnsignedShort:
      return load<std::uint16_t>(address, kLittle) / (normalized ? 65535.0 : 1.0);
    case kUnsignedInt:
      return load<std::uint32_t>(address, kLittle);
    default:
      return static_cast<double>(load<float>(address, kLittle));
  }
}

std::uint32_t GltfValues::integer(std::uint64_t i, int component) const {
  if (bytes == nullptr) return 0;
  const char* address =
      bytes + i * stride + static_cast<std::uint64_t>(component) * component_bytes(component_type);
  if (component_type == kUnsignedByte) return load<std::uint8_t>(address, std::endian::little);
  if (component_type == kUnsignedShort) return load<std::uint16_t>(address, std::endian::little);
  return load<std::uint32_t>(address, std::endian::little);
}

double GltfAccessor::get(std::uint64_t i, int component) const {
  std::uint64_t low = 0, high = replaced.count;
  while (low < high) {
    const std::uint64_t middle = (low + high) / 2;
    if (replaced.integer(middle, 0) < i) {
      low = middle + 1;
    } else {
      high = middle;
    }
  }
  if (low < replaced.count && replaced.integer(low, 0) == i) return values.get(low, component);
  return base.get(i, component);
}

bool GltfValues::is_unsigned() const {
  return component_type == kUnsignedByte || component_type == kUnsignedShort ||
         component_type == kUnsignedInt;
}

void GltfDocument::set_error(const std::string& json_path, std::string problem, std::string remedy) {
  if (error_) return;
  error_ = Error{fmt::format("{}, {}", path_, json_path), std::move(problem), std::move(remedy),
                 ErrorCode::InvalidFile};
}

const Json& GltfDocument::list(const Json& object, const char* key, const std::string& json_path) {
  static const Json kEmpty = Json::array();
  const auto found = object.find(key);
  if (found == object.end()) return kEmpty;
  if (found->is_array()) return *found;
  set_error(json_path, fmt::format("'{}' is not a list", key));
  return kEmpty;
}

std::optional<std::uint64_t> GltfDocument::optional_count(const Json& object, const char* key,
                                                          const std::string& json_path) {
  const auto found = object.find(key);
  if (found == object.end()) return std::nullopt;
  if (found->is_number_unsigned() && found->get<std::uint64_t>() < kCountLimit)
    return found->get<std::uint64_t>();
  set_error(json_path, fmt::format("'{}' is not a number from 0 to {}", key, kCountLimit - 1));
  return std::nullopt;
}

std::uint64_t GltfDocument::count(const Json& object, const char* key, const std::string& json_path) {
  const auto value = optional_count(object, key, json_path);
  if (!value) set_error(json_path, fmt::format("'{}' is missing", key));
  return value.value_or(0);
}

std::size_t GltfDocument::checked_index(const Json& value, const char* of, const std::string& json_path) {
  const std::size_t size = list(of).size();
  if (value.is_number_unsigned() && value.get<std::uint64_t>() < size) return value.get<std::size_t>();
  set_error(json_path, fmt::format("refers to {}[{}], but there are {}", of,
                                   value.is_number() ? value.dump() : "?", size));
  return 0;
}

std::optional<std::size_t> GltfDocument::optional_index(const Json& object, const char* key, const char* of,
                                                        const std::string& json_path) {
  const auto found = object.find(key);
  if (found == object.end()) return std::nullopt;
  const std::size_t value = checked_index(*found, of, json_path);
  return error_ ? std::nullopt : std::optional(value);
}

std::size_t GltfDocument::index(const Json& object, const char* key, const char* of,
                                const std::string& json_path) {
  const auto value = optional_index(object, key, of, json_path);
  if (!value) set_error(json_path, fmt::format("'{}' is missing", key));
  return value.value_or(0);
}

bool GltfDocument::numbers(const Json& object, const char* key, std::span<double> out,
                           const std::string& json_path) {
  const auto found = object.find(key);
  if (found == object.end()) return false;
  bool good = found->is_array() && found->size() == out.size();
  for (std::size_t i = 0; good && i < out.size(); ++i) good = (*found)[i].is_number();
  if (!good) {
    set_error(json_path, fmt::format("'{}' is not a list of {} numbers", key, out.size()));
    return false;
  }
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = (*found)[i].get<double>();
  return true;
}

std::string GltfDocument::text(const Json& object, const char* key, const std::string& fallback) {
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? found->get<std::string>() : fallback;
}

std::span<const char> GltfDocument::view(std::size_t index, std::uint64_t& stride) {
  const std::string json_path = fmt::format("bufferViews[{}]", index);
  const Json& json = list("bufferViews")[index];
  const std::size_t buffer = this->index(json, "buffer", "buffers", json_path);
  const std::uint64_t offset = optional_count(json, "byteOffset", json_path).value_or(0);
  const std::uint64_t length = count(json, "byteLength", json_path);
  stride = optional_count(json, "byteStride", json_path).value_or(stride);
  if (error_) return {};
  const std::vector<char>& bytes = *buffers_[buffer];
  if (offset > bytes.size() || length > bytes.size() - offset) {
    set_error(json_path, fmt::format("needs bytes {} to {}, but buffers[{}] has {}", offset, offset + length,
                                     buffer, bytes.size()));
    return {};
  }
  return std::span<const char>(bytes).subspan(offset, length);
}

GltfValues GltfDocument::values(const Json& source, const GltfValues& shape, const std::string& json_path) {
  GltfValues result = shape;
  const std::uint64_t element =
      static_cast<std::uint64_t>(shape.components) * component_bytes(shape.component_type);
  result.stride = element;
  const std::size_t index = this->index(source, "bufferView", "bufferViews", json_path);
  const std::uint64_t offset = optional_count(source, "byteOffset", json_path).value_or(0);
  if (error_) return {};
  const std::span<const char> bytes = view(index, result.stride);
  if (error_) return {};
  if (element == 0 || result.stride < element || result.stride > 65535) {
    set_error(json_path, "has an unknown component type or stride");
    return {};
  }
  const std::uint64_t needed = shape.count == 0 ? 0 : (shape.count - 1) * result.stride + element;
  if (offset > bytes.size() || needed > bytes.size() - offset) {
    set_error(json_path, fmt::format("needs {} bytes from byte {}, but bufferViews[{}] has {}", needed,
                                     offset, index, bytes.size()));
    return {};
  }
  result.bytes = bytes.data() + offset;
  return result;
}

GltfAccessor GltfDocument::accessor(std::size_t index, std::string_view type, const std::string& user) {
  const std::string json_path = fmt::format("accessors[{}]", index);
  if (error_) return {};
  const Json& json = list("accessors")[index];
  GltfValues shape;
  shape.component_type = static_cast<int>(count(json, "componentType", json_path) & 0xffff);
  shape.components = component_count(type);
  shape.count = count(json, "count", json_path);
  const auto normalized = json.find("normalized");
  shape.normalized = normalized != json.end() && *normalized == true;
  if (text(json, "type", "") != type || component_bytes(shape.component_type) == 0) {
    set_error(json_path, fmt::format("is not of a type that {} may have; {} is needed", user, type));
  }
  GltfAccessor result;
  result.base = json.contains("bufferView") ? values(json, shape, json_path) : shape;
  const auto sparse = json.find("sparse");
  if (sparse == json.end() || error_) return error_ ? GltfAccessor{} : result;

  const std::uint64_t replaced = count(*sparse, "count", json_path);
  const auto indices = sparse->find("indices"), replacements = sparse->find("values");
  if (indices == sparse->end() || replacements == sparse->end()) {
    set_error(json_path, "'sparse' lacks indices or values");
    return {};
  }
  GltfValues index_shape;
  index_shape.component_type = static_cast<int>(count(*indices, "componentType", json_path) & 0xffff);
  index_shape.components = 1;
  index_shape.count = replaced;
  if (!index_shape.is_unsigned()) set_error(json_path, "'sparse' indices are not unsigned integers");
  shape.count = replaced;
  result.replaced = values(*indices, index_shape, json_path);
  result.values = values(*replacements, shape, json_path);
  if (error_) return {};
  if (!checked_sparse_.insert(index).second) return result;
  if (!within_budget(replaced, json_path)) return {};
  for (std::uint64_t i = 0; i < replaced; ++i) {
    const std::uint32_t element = result.replaced.integer(i, 0);
    if (element >= result.base.count || (i > 0 && element <= result.replaced.integer(i - 1, 0))) {
      set_error(json_path, "'sparse' indices are not ascending or out of range");
      return {};
    }
  }
  return result;
}

bool GltfDocument::within_budget(std::uint64_t count, const std::string& json_path) {
  if (count <= kMaxValues - values_read_) {
    values_read_ += count;
    return true;
  }
  set_error(json_path, fmt::format("with it, more than {} indices and times are named", kMaxValues));
  return false;
}

Result<GltfDocument> GltfDocument::read(const std::string& path, const ReadProgress& progress) {
  GltfDocument document;
  document.path_ = path;
  auto file = FOLDPROOF_TRY(read_file(path, progress));
  const bool is_glb = std::string_view(file.data(), file.size()).starts_with("glTF");
  const auto parsed =
      is_glb ? document.split_glb(std::move(file)) : document.parse_json({file.data(), file.size()}, 0);
  if (!parsed) return tl::unexpected(parsed.error());
  document.check_extensions();
  if (!document.error_) document.load_buffers(progress);
  if (document.error_) return tl::unexpected(*document.error_);
  return document;
}

Result<void> GltfDocument::split_glb(std::vector<char> file) {
  constexpr std::uint64_t kHeader = 12, kChunkHeader = 8;
  constexpr std::uint32_t kJson = 0x4e4f534a, kBinary = 0x004e4942;
  const auto word = [&](std::uint64_t at) {
    return load<std::uint32_t>(file.data() + at, std::endian::little);
  };
  const char* remedy = "copy or export the file again";
  if (file.size() < kHeader)
    return fail(ErrorCode::InvalidFile, path_, "is too short for a GLB header", remedy);
  if (word(4) != 2)
    return fail(ErrorCode::UnsupportedFormat, at_byte(path_, 4),
                fmt::format("GLB version {} is not read", word(4)), "export glTF 2.0");
  if (word(8) != file.size()) {
    return fail(ErrorCode::InvalidFile, at_byte(path_, 8),
                fmt::format("header announces {} bytes, but the file has {}", word(8), file.size()), remedy);
  }
  bool has_json = false;
  for (std::uint64_t at = kHeader; at < file.size();) {
    if (file.size() - at < kChunkHeader || word(at) > file.size() - at - kChunkHeader) {
      return fail(ErrorCode::InvalidFile, at_byte(path_, at), "a chunk reaches beyond the end of the file",
                  remedy);
    }
    const std::size_t length = word(at);
    const std::uint32_t kind = word(at + 4);
    at += kChunkHeader;
    if (!has_json) {
      if (kind != kJson)
        return fail(ErrorCode::InvalidFile, at_byte(path_, at), "the first chunk is not JSON", remedy);
      FOLDPROOF_TRY(parse_json({file.data() + at, length}, at));
      has_json = true;
    } else if (kind == kBinary && !chunk_) {
      chunk_.emplace(file.data() + at, file.data() + at + length);
    }
    at += length;
  }
  if (!has_json) return fail(ErrorCode::InvalidFile, path_, "has no JSON chunk", remedy);
  return {};
}

Result<void> GltfDocument::parse_json(std::string_view text, std::uint64_t offset) {
  const char* remedy = "export the file again";
  const CLocale numbers;
  try {
    json_ = Json::parse(text.begin(), text.end());
  } catch (const Json::parse_error& e) {
    return fail(ErrorCode::InvalidFile, at_byte(path_, offset + e.byte), "is not valid JSON here", remedy);
  } catch (const Json::exception&) {
    return fail(ErrorCode::InvalidFile, path_, "has a JSON number that is too large", remedy);
  }
  const Json& json = json_;
  const auto asset = json.find("asset");
  if (asset == json.end() || !this->text(*asset, "version", "").starts_with("2.")) {
    return fail(ErrorCode::UnsupportedFormat, path_, "is not glTF 2", "export glTF 2.0");
  }
  return {};
}

/// Extensions that change the look of a scene but no positions are harmless.
void GltfDocument::check_extensions() {
  constexpr std::array<std::string_view, 6> kHarmless{
      "KHR_materials_", "KHR_texture_", "KHR_lights_", "EXT_texture_", "KHR_mesh_quantization", "KHR_xmp"};
  for (const Json& name : list("extensionsRequired")) {
    const std::string text = name.is_string() ? name.get<std::string>() : "?";
    const bool harmless = std::any_of(kHarmless.begin(), kHarmless.end(),
                                      [&](std::string_view prefix) { return text.starts_with(prefix); });
    if (!harmless)
      set_error("extensionsRequired", fmt::format("'{}' is not read", text), "export without it");
  }
  for (const Json& name : list("extensionsUsed")) {
    if (name == "EXT_mesh_gpu_instancing") {
      set_error("extensionsUsed", "'EXT_mesh_gpu_instancing' is not read", "export without it");
    }
  }
}

void GltfDocument::load_buffers(const ReadProgress& progress) {
  const Json& buffers = list("buffers");
  for (std::size_t i = 0; i < buffers.size() && !error_; ++i) {
    const std::string json_path = fmt::format("buffers[{}]", i);
    const std::uint64_t length = count(buffers[i], "byteLength", json_path);
    Buffer bytes;
    if (const auto uri = buffers[i].find("uri"); uri != buffers[i].end()) {
      auto loaded = load_uri(uri->is_string() ? uri->get<std::string>() : "", json_path, progress);
      if (!loaded) {
        error_ = loaded.error();
        return;
      }
      bytes = std::move(*loaded);
    } else if (i == 0 && chunk_) {
      bytes = std::make_shared<const std::vector<char>>(std::move(*chunk_));
    } else {
      set_error(json_path, "has neither a uri nor a binary chunk");
      return;
    }
    if (length > bytes->size()) {
      set_error(json_path, fmt::format("announces {} bytes, but there are {}", length, bytes->size()),
                "copy or export the file again");
    }
    buffers_.push_back(std::move(bytes));
  }
}

/// Loads embedded data, or a file in or below the directory of this one.
Result<GltfDocument::Buffer> GltfDocument::load_uri(const std::string& uri, const std::string& json_path,
                                                    const ReadProgress& progress) {
  const std::string where = fmt::format("{}, {}", path_, json_path);
  if (uri.starts_with("data:")) {
    const std::size_t comma = uri.find(',');
    if (comma == uri.npos || !std::string_view(uri).substr(0, comma).ends_with(";base64")) {
      return fail(ErrorCode::InvalidFile, where, "embedded data is not base64", "export the file again");
    }
    auto bytes = decode_base64(std::string_view(uri).substr(comma + 1));
    if (!bytes)
      return fail(ErrorCode::InvalidFile, where, "embedded data is not base64", "export the file again");
    return std::make_shared<const std::vector<char>>(std::move(*bytes));
  }
  const std::string name = decode_percent(uri);
  std::error_code status;
  const fs::path directory = fs::weakly_canonical(fs::absolute(path_, status).parent_path(), status);
  const fs::path target = status ? fs::path() : fs::weakly_canonical(directory / name, status);
  const fs::path relative = target.lexically_relative(directory);
  if (name.empty() || name.find('\0') != name.npos || name.find("://") != name.npos ||
      fs::path(name).has_root_path() || status || relative.empty() || relative == "." ||
      *relative.begin() == "..") {
    return fail(ErrorCode::InvalidFile, where,
                fmt::format("'{}' is not a file beside this one", uri.substr(0, 200)),
                "put the buffer beside it, or export GLB");
  }
  Buffer& file = files_[target.generic_string()];
  if (file) return file;
  auto bytes = read_file(target.generic_string(), progress);
  if (!bytes)
    return fail(bytes.error().code, where,
                fmt::format("buffer '{}' {}", uri.substr(0, 200), bytes.error().problem),
                bytes.error().remedy);
  file = std::make_shared<const std::vector<char>>(std::move(*bytes));
  return file;
}

std::vector<std::string> gltf_files(const std::string& path) {
  std::vector<std::string> files;
  const auto bytes = read_file(path, {});
  if (!bytes) return files;
  const CLocale numbers;
  const Json json = Json::parse(bytes->begin(), bytes->end(), nullptr, false);
  const auto buffers = json.is_object() ? json.find("buffers") : json.end();
  if (buffers == json.end() || !buffers->is_array()) return files;
  for (const Json& buffer : *buffers) {
    const auto uri = buffer.is_object() ? buffer.find("uri") : buffer.end();
    if (uri == buffer.end() || !uri->is_string() || uri->get_ref<const std::string&>().starts_with("data:"))
      continue;
    files.push_back(
        (fs::path(path).parent_path() / decode_percent(uri->get<std::string>())).generic_string());
  }
  return files;
}

}  // namespace foldproof::io
