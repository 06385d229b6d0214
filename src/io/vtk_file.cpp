#include "io/vtk_file.h"

#include <fmt/format.h>
#include <zlib.h>

#include <charconv>
#include <cmath>

#include "base/try.h"
#include "io/base64.h"
#include "io/number_type.h"
#include "io/text.h"

namespace foldproof::io {
namespace {

constexpr const char* kWriteAgain = "write the file again";
constexpr std::uint64_t kMaxPerByte = 1032;  // what deflate can expand a byte to

}  // namespace

tl::unexpected<Error> VtkFile::error(pugi::xml_node element, std::string problem) const {
  const std::string name = element.attribute("Name").value();
  return fail(ErrorCode::InvalidFile,
              fmt::format("{}, {}{}", path_, element.name(), name.empty() ? "" : " '" + name + "'"),
              std::move(problem), kWriteAgain);
}

Result<VtkFile> VtkFile::parse(const std::string& path, std::string_view bytes, const char* type) {
  VtkFile file;
  file.path_ = path;
  file.type_ = type;
  file.budget_ = bytes.size();
  std::string declared;
  std::string_view xml = bytes;
  // Appended data need not be XML, so the text ends with the tag that opens it.
  const std::size_t tag = bytes.find("<AppendedData"), end = bytes.find('>', std::min(tag, bytes.size()));
  if (tag != bytes.npos && end != bytes.npos) {
    declared = std::string(bytes.substr(0, end)) + "/></VTKFile>";
    xml = declared;
    const std::size_t start = bytes.find('_', end);
    if (start != bytes.npos) file.appended_ = bytes.substr(start + 1);
  }
  const pugi::xml_parse_result parsed = file.document_.load_buffer(xml.data(), xml.size());
  if (!parsed) {
    return fail(ErrorCode::InvalidFile, at_byte(path, static_cast<std::uint64_t>(parsed.offset)),
                fmt::format("is not XML: {}", parsed.description()), kWriteAgain);
  }
  const pugi::xml_node root = file.document_.child("VTKFile");
  const std::string found = root.attribute("type").value(), compressor = root.attribute("compressor").value();
  if (found != type) {
    return fail(ErrorCode::UnsupportedFormat, path,
                found.empty() ? "is not a VTK XML file" : fmt::format("holds {}, not {}", found, type),
                "give the file the extension of what it holds: .vtp polygons, .vtu cells, .pvd a collection");
  }
  if (!file.content())
    return fail(ErrorCode::InvalidFile, path, fmt::format("has no element {}", type), kWriteAgain);
  if (!compressor.empty() && compressor != "vtkZLibDataCompressor") {
    return fail(ErrorCode::UnsupportedFormat, path, fmt::format("is compressed with {}", compressor),
                "write it with zlib, or not compressed");
  }
  file.compressed_ = !compressor.empty();
  file.order_ = std::string_view(root.attribute("byte_order").value()) == "BigEndian" ? std::endian::big
                                                                                      : std::endian::little;
  file.word_ = std::string_view(root.attribute("header_type").value()) == "UInt64" ? 8 : 4;
  file.appended_is_base64_ =
      std::string_view(root.child("AppendedData").attribute("encoding").value()) == "base64";
  return file;
}

Result<std::uint64_t> VtkFile::count(pugi::xml_node element, const char* attribute) const {
  const std::string_view text = element.attribute(attribute).value();
  std::uint64_t value = 0;
  const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (text.empty()) return 0;
  if (status != std::errc() || end != text.data() + text.size() || value >= kNoIndex)
    return error(element, fmt::format("{} is not a count", attribute));
  return value;
}

Result<std::vector<char>> VtkFile::binary(pugi::xml_node array) {
  const std::string_view format = array.attribute("format").value();
  if (format == "binary") return unpack(array, array.text().get(), true);
  if (format != "appended") return error(array, "has an encoding other than ascii, binary and appended");
  const std::string_view text = array.attribute("offset").value();
  std::uint64_t offset = 0;
  const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), offset);
  if (status != std::errc() || end != text.data() + text.size() || offset >= appended_.size())
    return error(array, "its offset is not within the appended data");
  return unpack(array, appended_.substr(offset), appended_is_base64_);
}

// The array's size in bytes, then the bytes. Compressed: the number of blocks, their size, the size of the
// last one if it is smaller, the compressed size of each; then the blocks.
Result<std::vector<char>> VtkFile::unpack(pugi::xml_node array, std::string_view encoded, bool base64) {
  const auto cut = [&] { return error(array, "ends before its last value"); };
  ByteStream stream(encoded, base64);
  const auto word = [&](std::uint64_t& value) {
    std::array<char, 8> raw;
    if (!stream.read(std::span(raw).first(word_))) return false;
    value = word_ == 8 ? load<std::uint64_t>(raw.data(), order_) : load<std::uint32_t>(raw.data(), order_);
    return true;
  };
  const auto take = [&](std::uint64_t bytes, std::vector<char>& out) {
    if (bytes > stream.remaining() || bytes > budget_) return false;
    budget_ -= bytes;
    out.resize(bytes);
    return stream.read(out);
  };
  std::vector<char> values;
  std::uint64_t first = 0;
  if (!word(first)) return cut();
  if (!compressed_) return take(first, values) ? Result<std::vector<char>>(std::move(values)) : cut();

  std::uint64_t size = 0, last = 0;
  if (!word(size) || !word(last) || first > stream.remaining() / word_) return cut();
  std::vector<std::uint64_t> packed_sizes(first);
  for (std::uint64_t& packed : packed_sizes) {
    if (!word(packed)) return cut();
  }
  std::vector<char> packed;
  for (std::size_t i = 0; i < packed_sizes.size(); ++i) {
    const std::uint64_t bytes = i + 1 == packed_sizes.size() && last != 0 ? last : size;
    if (!take(packed_sizes[i], packed) || bytes / kMaxPerByte > packed.size()) return cut();
    const std::size_t begin = values.size();
    values.resize(begin + bytes);
    uLongf found = bytes;
    if (uncompress(reinterpret_cast<Bytef*>(values.data() + begin), &found,
                   reinterpret_cast<const Bytef*>(packed.data()), packed.size()) != Z_OK ||
        found != bytes)
      return error(array, "its compressed data are damaged");
  }
  return values;
}

template <class T>
Result<std::vector<T>> VtkFile::values(pugi::xml_node array) {
  const std::string_view name = array.attribute("type").value();
  const NumberType type = xml_number_type(name);
  constexpr bool kInteger = std::is_same_v<T, std::int64_t>;
  if (type.bytes == 0 || (kInteger && type.kind == NumberType::Kind::Float))
    return error(array, kInteger ? "does not hold integers" : "does not hold numbers");
  std::vector<T> values;
  if (std::string_view(array.attribute("format").value()) == "ascii") {
    TextCursor cursor(array.text().get(), {.comment = '\0', .continuation = false});
    while (cursor.skip_to_content()) {
      T value;
      Scan scan;
      if constexpr (kInteger) {
        scan = cursor.integer(value);
      } else {
        scan = cursor.number(value);
      }
      if (scan != Scan::Ok)
        return error(array, fmt::format("value {} is not a finite number", values.size()));
      values.push_back(value);
    }
    return values;
  }
  const auto bytes = FOLDPROOF_TRY(binary(array));
  if (bytes.size() % type.bytes != 0) return error(array, "ends within a value");
  values.reserve(bytes.size() / type.bytes);
  for (std::size_t at = 0; at < bytes.size(); at += type.bytes)
    values.push_back(load_as<T>(type, bytes.data() + at, order_));
  return values;
}

template Result<std::vector<double>> VtkFile::values(pugi::xml_node array);
template Result<std::vector<std::int64_t>> VtkFile::values(pugi::xml_node array);

}  // namespace foldproof::io
