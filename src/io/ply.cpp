// Stanford PLY, ASCII and binary. A parser of our own: no packaged reader checks the header's counts against
// the size of the file before it allocates.
#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <unordered_set>

#include "base/try.h"
#include "io/bytes.h"
#include "io/parts.h"
#include "io/readers.h"
#include "io/text.h"

namespace foldproof::io {
namespace {

struct PlyType {
  int size;
  bool is_float;
  bool is_signed;
};

std::optional<PlyType> ply_type(std::string_view name) {
  if (name == "char" || name == "int8") return PlyType{1, false, true};
  if (name == "uchar" || name == "uint8") return PlyType{1, false, false};
  if (name == "short" || name == "int16") return PlyType{2, false, true};
  if (name == "ushort" || name == "uint16") return PlyType{2, false, false};
  if (name == "int" || name == "int32") return PlyType{4, false, true};
  if (name == "uint" || name == "uint32") return PlyType{4, false, false};
  if (name == "float" || name == "float32") return PlyType{4, true, true};
  if (name == "double" || name == "float64") return PlyType{8, true, true};
  return std::nullopt;
}

/// The role of a property in the mesh. The values of X, Y and Z are the coordinate's index.
enum class Role : std::uint8_t { X, Y, Z, Start, End, Polygon, Part, None };

struct Property {
  PlyType type;
  std::optional<PlyType> count;  ///< Type of the count, for a list.
  Role role = Role::None;
};

struct Element {
  std::string name;
  std::uint64_t count = 0;
  std::vector<Property> properties;

  bool has(Role role) const {
    return std::any_of(properties.begin(), properties.end(),
                       [=](const Property& p) { return p.role == role; });
  }
  bool is_edge() const { return has(Role::Start) && has(Role::End); }
};

enum class Encoding : std::uint8_t { Ascii, Little, Big };

struct Header {
  Encoding encoding = Encoding::Ascii;
  std::vector<Element> elements;
  std::size_t size = 0;  ///< Bytes, including the line end after end_header.
  std::uint64_t lines = 0;
  std::uint64_t vertices = 0;
  std::string_view part_kind;  ///< What the property with Role::Part holds.
};

class HeaderParser {
 public:
  HeaderParser(const std::string& path, std::string_view bytes)
      : path_(path), bytes_(bytes), cursor_(bytes, {.comment = '\0', .continuation = false}) {}

  Result<Header> parse() {
    if (cursor_.word() != "ply" || !cursor_.at_line_end()) {
      return fail(ErrorCode::InvalidFile, at_line(path_, 1), "does not start with the line 'ply'",
                  "export the mesh as PLY again");
    }
    cursor_.next_line();
    for (; cursor_.skip_to_content(); cursor_.next_line()) {
      const std::string_view keyword = cursor_.word();
      if (keyword == "end_header") return finish();
      Result<void> read;
      if (keyword == "format") {
        read = read_format();
      } else if (keyword == "element") {
        read = read_element();
      } else if (keyword == "property") {
        read = read_property();
      } else if (keyword != "comment" && keyword != "obj_info") {
        read = error("header has an unknown keyword");
      }
      if (!read) return tl::unexpected(read.error());
    }
    return error("the file ends before 'end_header'");
  }

 private:
  tl::unexpected<Error> error(std::string problem) const {
    return fail(ErrorCode::InvalidFile, at_line(path_, cursor_.line()), std::move(problem),
                "export the mesh as PLY again");
  }

  Result<void> read_format() {
    const std::string_view name = cursor_.word();
    if (name == "ascii") {
      header_.encoding = Encoding::Ascii;
    } else if (name == "binary_little_endian") {
      header_.encoding = Encoding::Little;
    } else if (name == "binary_big_endian") {
      header_.encoding = Encoding::Big;
    } else {
      return error("format is not ascii, binary_little_endian or binary_big_endian");
    }
    has_format_ = true;
    return {};
  }

  Result<void> read_element() {
    Element element;
    element.name = cursor_.word();
    std::int64_t count;
    if (cursor_.integer(count) != Scan::Ok || count < 0) return error("element has no proper count");
    element.count = static_cast<std::uint64_t>(count);
    if (!names_.insert(element.name).second)
      return error(fmt::format("element '{}' is declared twice", element.name));
    if (element.name == "vertex") header_.vertices = element.count;
    header_.elements.push_back(std::move(element));
    return {};
  }

  Result<void> read_property() {
    if (header_.elements.empty()) return error("property stands before any element");
    Element& element = header_.elements.back();
    Property property{};
    std::string_view type = cursor_.word();
    if (type == "list") {
      property.count = ply_type(cursor_.word());
      if (!property.count || property.count->is_float)
        return error("the count of a list is not an integer type");
      type = cursor_.word();
    }
    const auto value = ply_type(type);
    if (!value) return error("property has an unknown type");
    property.type = *value;
    const std::string_view name = cursor_.word();
    property.role = Role::None;
    if (element.name == "vertex" && !property.count && name.size() == 1 && name[0] >= 'x' && name[0] <= 'z') {
      property.role = static_cast<Role>(name[0] - 'x');
    }
    if (element.name == "face" && (name == "vertex_indices" || name == "vertex_index")) {
      if (!property.count || value->is_float)
        return error("the vertices of a face are not a list of integers");
      property.role = Role::Polygon;
    }
    if (element.name == "face" && !property.count && !value->is_float && !element.has(Role::Part) &&
        !part_kind(name).empty()) {
      property.role = Role::Part;
      header_.part_kind = part_kind(name);
    }
    if (element.name == "edge" && !property.count && !value->is_float) {
      if (name == "vertex1") property.role = Role::Start;
      if (name == "vertex2") property.role = Role::End;
    }
    if (property.role != Role::None && element.has(property.role)) {
      return error(fmt::format("property '{}' is declared twice", name));
    }
    element.properties.push_back(property);
    return {};
  }

  Result<Header> finish() {
    if (!has_format_) return error("header has no line 'format'");
    if (names_.contains("tristrips")) {
      return fail(ErrorCode::UnsupportedFormat, at_line(path_, cursor_.line()),
                  "header declares triangle strips, which are not read",
                  "export the mesh as PLY with its faces");
    }
    bool positions = false, faces = false;
    for (const Element& e : header_.elements) {
      if (e.name == "vertex") positions = e.has(Role::X) && e.has(Role::Y) && e.has(Role::Z);
      if (e.name == "face") faces |= e.has(Role::Polygon);
      faces |= e.is_edge();
    }
    if (!positions) return error("header declares no vertices with x, y and z");
    if (!faces) {
      return fail(ErrorCode::InvalidFile, at_line(path_, cursor_.line()),
                  "header declares no faces with vertex_indices", "export the mesh with its faces");
    }
    // Not next_line(): where lines end with CR alone, the first byte of a binary body may happen to be LF.
    const std::size_t first = std::min(bytes_.find_first_of("\r\n"), bytes_.size());
    const bool lone_cr = bytes_.substr(first, 1) == "\r" && bytes_.substr(first, 2) != "\r\n";
    const std::string_view remaining = cursor_.remaining();
    const std::size_t line_end =
        !lone_cr && remaining.starts_with("\r\n") ? 2 : std::min<std::size_t>(remaining.size(), 1);
    header_.size = bytes_.size() - remaining.size() + line_end;
    header_.lines = cursor_.line();
    return std::move(header_);
  }

  const std::string& path_;
  std::string_view bytes_;
  TextCursor cursor_;
  Header header_;
  std::unordered_set<std::string> names_;  // of the elements
  bool has_format_ = false;
};

/// Reads the values of a binary body.
class BinarySource {
 public:
  BinarySource(const std::string& path, std::string_view bytes, const Header& header)
      : path_(path),
        bytes_(bytes),
        at_(header.size),
        order_(header.encoding == Encoding::Little ? std::endian::little : std::endian::big) {}

  /// The smallest size of a property in a record, for checking counts.
  static std::uint64_t min_bytes(const Property& p) {
    return static_cast<std::uint64_t>(p.count ? p.count->size : p.type.size);
  }
  std::uint64_t remaining() const { return bytes_.size() - at_; }
  std::string where() const { return at_byte(path_, last_); }
  void begin_element() { last_ = at_; }
  bool begin_record() { return true; }
  bool end_record() { return true; }
  bool at_end() {
    last_ = at_;
    return bytes_.find_first_not_of(std::string_view("\0\r\n", 3), at_) == bytes_.npos;
  }

  Scan value(PlyType type, double& out) {
    last_ = at_;
    if (remaining() < static_cast<std::uint64_t>(type.size)) return Scan::Missing;
    const char* bytes = bytes_.data() + at_;
    at_ += static_cast<std::size_t>(type.size);
    if (type.is_float) {
      out = type.size == 4 ? static_cast<double>(load<float>(bytes, order_)) : load<double>(bytes, order_);
      return std::isfinite(out) ? Scan::Ok : Scan::NotFinite;
    }
    switch (type.size) {
      case 1:
        out = type.is_signed ? load<std::int8_t>(bytes, order_) : load<std::uint8_t>(bytes, order_);
        break;
      case 2:
        out = type.is_signed ? load<std::int16_t>(bytes, order_) : load<std::uint16_t>(bytes, order_);
        break;
      default:
        out = type.is_signed ? static_cast<double>(load<std::int32_t>(bytes, order_))
                             : static_cast<double>(load<std::uint32_t>(bytes, order_));
    }
    return Scan::Ok;
  }

 private:
  const std::string& path_;
  std::string_view bytes_;
  std::size_t at_;
  std::size_t last_ = 0;  // offset of the last value read
  std::endian order_;
};

/// Reads the values of an ASCII body, one record per line.
class AsciiSource {
 public:
  AsciiSource(const std::string& path, std::string_view bytes, const Header& header)
      : path_(path),
        header_lines_(header.lines),
        cursor_(bytes.substr(header.size), {.comment = '\0', .continuation = false}) {}

  static std::uint64_t min_bytes(const Property&) { return 2; }
  /// One byte more, as the last line may have no line end.
  std::uint64_t remaining() const { return cursor_.remaining().size() + 1; }
  std::string where() const { return at_line(path_, header_lines_ + cursor_.line()); }
  void begin_element() {}
  bool begin_record() { return cursor_.skip_to_content(); }
  bool end_record() {
    if (!cursor_.at_line_end()) return false;
    cursor_.next_line();
    return true;
  }
  bool at_end() { return !cursor_.skip_to_content(); }
  Scan value(PlyType type, double& out) {
    if (type.is_float) return cursor_.number(out);
    std::int64_t integer = 0;
    const Scan scan = cursor_.integer(integer);
    out = static_cast<double>(integer);
    return scan;
  }

 private:
  const std::string& path_;
  std::uint64_t header_lines_;
  TextCursor cursor_;
};

template <class Source>
class BodyParser {
 public:
  BodyParser(const std::string& path, const Header& header, Source source)
      : path_(path), header_(header), source_(std::move(source)) {}

  Result<MeshData> parse() {
    for (const Element& element : header_.elements) {
      source_.begin_element();
      std::uint64_t min_bytes = 0;
      for (const Property& p : element.properties) min_bytes += Source::min_bytes(p);
      if (min_bytes == 0) continue;  // no properties: nothing to read, whatever the count
      if (element.count > source_.remaining() / min_bytes) {
        return fail(ErrorCode::InvalidFile, source_.where(),
                    fmt::format("header announces {} of element '{}', but the file ends before",
                                element.count, element.name),
                    "copy or export the mesh again");
      }
      if (element.name == "edge" && element.count > 0 && !element.is_edge()) {
        mesh_.unchecked.push_back(
            fmt::format("{} edges without vertex1 and vertex2 were not checked", element.count));
      }
      if (element.name == "vertex") mesh_.positions.reserve(element.count * 3);
      if (element.name == "face") mesh_.triangles.reserve(element.count);
      for (std::uint64_t i = 0; i < element.count; ++i) {
        FOLDPROOF_TRY(read_record(element, i));
      }
    }
    if (!source_.at_end()) {
      return fail(ErrorCode::InvalidFile, source_.where(), "there is more data than the header announces",
                  "export the mesh again");
    }
    mesh_.parts = parts_by_number(header_.part_kind, parts_);
    return std::move(mesh_);
  }

 private:
  tl::unexpected<Error> error(Scan scan, const Element& element, std::uint64_t record) const {
    return tl::unexpected(
        scan_error(scan, source_.where(), fmt::format("a value of {} {}", element.name, record)));
  }

  Result<void> read_record(const Element& element, std::uint64_t record) {
    std::array<double, 5> values{};  // of the roles before Polygon
    std::optional<std::int64_t> part;
    if (!source_.begin_record()) return error(Scan::Missing, element, record);
    for (const Property& property : element.properties) {
      if (property.count) {
        FOLDPROOF_TRY(read_list(element, property, record));
        continue;
      }
      double value = 0;
      const Scan scan = source_.value(property.type, value);
      const bool used = property.role != Role::None;
      if (scan != Scan::Ok && (used || scan != Scan::NotFinite)) return error(scan, element, record);
      if (property.role == Role::Part) {
        part = static_cast<std::int64_t>(std::clamp(value, -0x1p53, 0x1p53));  // text may exceed the type
      } else if (used) {
        values[static_cast<std::size_t>(property.role)] = value;
      }
    }
    if (!source_.end_record()) {
      return fail(ErrorCode::InvalidFile, source_.where(),
                  fmt::format("{} {} has more values than declared", element.name, record),
                  "export the mesh again");
    }
    if (element.name == "vertex") {
      mesh_.positions.insert(mesh_.positions.end(), values.begin(), values.begin() + 3);
    }
    if (element.is_edge()) {
      const Index a = FOLDPROOF_TRY(vertex("edge", record, values[3]));
      mesh_.add_polyline(std::array{a, FOLDPROOF_TRY(vertex("edge", record, values[4]))});
    }
    if (part) parts_.resize(mesh_.triangles.size(), *part);
    return {};
  }

  Result<Index> vertex(const char* element, std::uint64_t record, double id) const {
    if (id >= 0 && id < static_cast<double>(header_.vertices)) return static_cast<Index>(id);
    return fail(ErrorCode::InvalidFile, source_.where(),
                fmt::format("{} {} refers to vertex {}, but there are {} (counting from 0)", element, record,
                            id, header_.vertices),
                "export the mesh again");
  }

  Result<void> read_list(const Element& element, const Property& property, std::uint64_t record) {
    double count = 0;
    const Scan scan = source_.value(*property.count, count);
    if (scan != Scan::Ok) return error(scan, element, record);
    const bool polygon = property.role == Role::Polygon;
    if (count < (polygon ? 3 : 0)) {
      return fail(ErrorCode::InvalidFile, source_.where(),
                  fmt::format("{} {} has a list of {} values", element.name, record, count),
                  "remove faces with fewer than three vertices");
    }
    polygon_.clear();
    for (std::uint64_t n = static_cast<std::uint64_t>(count); n > 0; --n) {
      double value = 0;
      const Scan item = source_.value(property.type, value);
      if (item != Scan::Ok && (polygon || item != Scan::NotFinite)) return error(item, element, record);
      if (!polygon) continue;
      polygon_.push_back(FOLDPROOF_TRY(vertex("face", record, value)));
    }
    if (polygon) mesh_.add_polygon(polygon_);
    return {};
  }

  const std::string& path_;
  const Header& header_;
  Source source_;
  MeshData mesh_;
  std::vector<std::int64_t> parts_;  // per triangle
  std::vector<Index> polygon_;
};

}  // namespace

Result<MeshData> parse_ply(const std::string& path, std::string_view bytes) {
  const auto header = FOLDPROOF_TRY(HeaderParser(path, bytes).parse());
  if (header.vertices > kMaxVertices) {
    return fail(ErrorCode::LimitExceeded, path, fmt::format("header announces {} vertices", header.vertices),
                "split the mesh");
  }
  return header.encoding == Encoding::Ascii
             ? BodyParser(path, header, AsciiSource(path, bytes, header)).parse()
             : BodyParser(path, header, BinarySource(path, bytes, header)).parse();
}

}  // namespace foldproof::io
