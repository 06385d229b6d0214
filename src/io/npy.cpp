#include "io/npy.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <charconv>

#include "base/try.h"

namespace foldproof::io {
namespace {

constexpr std::string_view kMagic("\x93NUMPY", 6);
constexpr std::size_t kMaxText = std::size_t{1} << 20;  // characters of an element

/// Parses the header's text, a Python dictionary as NumPy writes it.
class DictionaryParser {
 public:
  explicit DictionaryParser(std::string_view text) : text_(text) {}

  bool parse(NpyHeader& header) {
    bool has_type = false, has_order = false, has_shape = false;
    if (!accept('{')) return false;
    while (!accept('}')) {
      const auto key = string();
      if (!key || !accept(':')) return false;
      if (*key == "descr") {
        has_type = parse_type(header);
        if (!has_type) return false;
      } else if (*key == "fortran_order") {
        has_order = parse_bool(header.fortran_order);
        if (!has_order) return false;
      } else if (*key == "shape") {
        has_shape = parse_shape(header.shape);
        if (!has_shape) return false;
      } else {
        return false;
      }
      if (!accept(',') && !peek('}')) return false;
    }
    return has_type && has_order && has_shape;
  }

 private:
  void skip_blanks() { text_.remove_prefix(std::min(text_.find_first_not_of(" \t\n"), text_.size())); }
  bool peek(char c) {
    skip_blanks();
    return !text_.empty() && text_[0] == c;
  }
  bool accept(char c) {
    if (!peek(c)) return false;
    text_.remove_prefix(1);
    return true;
  }
  std::optional<std::string_view> string() {
    const char quote = peek('"') ? '"' : '\'';
    if (!accept(quote)) return std::nullopt;
    const std::size_t end = text_.find(quote);
    if (end == text_.npos) return std::nullopt;
    const std::string_view value = text_.substr(0, end);
    text_.remove_prefix(end + 1);
    return value;
  }
  bool parse_bool(bool& value) {
    skip_blanks();
    value = text_.starts_with("True");
    if (!value && !text_.starts_with("False")) return false;
    text_.remove_prefix(value ? 4 : 5);
    return true;
  }
  bool parse_type(NpyHeader& header) {
    const auto type = string();
    if (!type || type->size() < 3) return false;
    const char order = (*type)[0];
    if (order == '>') {
      header.order = std::endian::big;
    } else if (order == '=') {
      header.order = std::endian::native;
    } else if (order != '<' && order != '|') {
      return false;
    }
    header.kind = (*type)[1];
    const char* end = type->data() + type->size();
    const auto [stop, status] = std::from_chars(type->data() + 2, end, header.item_bytes);
    if (status != std::errc() || stop != end) return false;
    if (header.kind != 'S' && header.kind != 'U')
      return std::has_single_bit(header.item_bytes) && header.item_bytes <= 8;
    if (header.item_bytes == 0 || header.item_bytes > kMaxText) return false;
    if (header.kind == 'U') header.item_bytes *= 4;
    return true;
  }
  bool parse_shape(std::vector<std::uint64_t>& shape) {
    if (!accept('(')) return false;
    while (!accept(')')) {
      skip_blanks();
      std::uint64_t size = 0;
      const auto [end, status] = std::from_chars(text_.data(), text_.data() + text_.size(), size);
      if (status != std::errc()) return false;
      text_.remove_prefix(static_cast<std::size_t>(end - text_.data()));
      shape.push_back(size);
      if (!accept(',') && !peek(')')) return false;
    }
    return true;
  }

  std::string_view text_;
};

}  // namespace

Result<NpyHeader> parse_npy_header(const std::string& where, std::string_view bytes) {
  const auto bad = [&](const char* problem) {
    return fail(ErrorCode::InvalidFile, where, problem, kSaveArrayAgain);
  };
  if (bytes.size() < 12 || !bytes.starts_with(kMagic)) return bad("is not a NumPy array");
  const int version = static_cast<unsigned char>(bytes[6]);
  if (version < 1 || version > 3) return bad("has an unknown array format version");
  const std::size_t start = version == 1 ? 10 : 12;
  const std::size_t length = version == 1 ? load<std::uint16_t>(bytes.data() + 8, std::endian::little)
                                          : load<std::uint32_t>(bytes.data() + 8, std::endian::little);
  if (length > kNpyHeaderLimit - start) return bad("has an array header that is too long");
  if (length > bytes.size() - start) return bad("ends within its array header");
  NpyHeader header;
  header.data = start + length;
  if (!DictionaryParser(bytes.substr(start, length)).parse(header)) {
    return bad("has an array header that is not understood");
  }
  return header;
}

std::int64_t load_integer(const char* bytes, const NpyHeader& header) {
  const bool is_signed = header.kind == 'i';
  switch (header.item_bytes) {
    case 1:
      return is_signed ? load<std::int8_t>(bytes, header.order) : load<std::uint8_t>(bytes, header.order);
    case 2:
      return is_signed ? load<std::int16_t>(bytes, header.order) : load<std::uint16_t>(bytes, header.order);
    case 4:
      return is_signed ? load<std::int32_t>(bytes, header.order)
                       : static_cast<std::int64_t>(load<std::uint32_t>(bytes, header.order));
    default:
      return load<std::int64_t>(bytes, header.order);
  }
}

Result<void> NpyArray::parse(std::string where, std::string_view start, std::uint64_t size) {
  where_ = std::move(where);
  header_ = FOLDPROOF_TRY(parse_npy_header(where_, start));
  if (header_.fortran_order) {
    return fail(ErrorCode::UnsupportedFormat, where_, "is in Fortran order",
                "save numpy.ascontiguousarray(array)");
  }
  elements_ = (size - header_.data) / header_.item_bytes;
  std::uint64_t remaining = elements_;
  bool fits = (size - header_.data) % header_.item_bytes == 0;
  for (const std::uint64_t extent : header_.shape) {
    if (extent == 0)
      return fail(ErrorCode::InvalidFile, where_, "is empty", "save at least one triangle and one frame");
    fits = fits && remaining % extent == 0;
    remaining /= extent;
  }
  if (!fits || remaining != 1) {
    return fail(ErrorCode::InvalidFile, where_,
                fmt::format("its shape does not fit its {} bytes", size - header_.data), kSaveArrayAgain);
  }
  return {};
}

Result<void> NpyFile::open(const std::string& path) {
  file_ = FOLDPROOF_TRY(InputFile::open(path));
  std::vector<char> start(std::min<std::uint64_t>(file_->size(), kNpyHeaderLimit));
  FOLDPROOF_TRY(file_->read_at(0, start));
  return parse(path, {start.data(), start.size()}, file_->size());
}

std::string npy_header(std::string_view type, std::span<const std::uint64_t> shape) {
  std::string text = fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': ({}{}), }}", type,
                                 fmt::join(shape, ", "), shape.size() == 1 ? "," : "");
  constexpr std::size_t kPrefix = 10, kAlignment = 64;
  text.append((kAlignment - (kPrefix + text.size() + 1) % kAlignment) % kAlignment, ' ');
  text += '\n';
  std::vector<char> bytes(kMagic.begin(), kMagic.end());
  bytes.push_back(1);
  bytes.push_back(0);
  append(bytes, static_cast<std::uint16_t>(text.size()));
  return std::string(bytes.begin(), bytes.end()) + text;
}

}  // namespace foldproof::io
