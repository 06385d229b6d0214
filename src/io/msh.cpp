// Gmsh meshes, versions 2.2, 4.0 and 4.1, ASCII and binary. A parser of our own: Gmsh's library is GPL.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>

#include "base/try.h"
#include "io/bytes.h"
#include "io/cells.h"
#include "io/parts.h"
#include "io/text.h"

namespace foldproof::io {
namespace {

constexpr std::size_t kMaxName = 100;  // of a section: searching for its end takes time in proportion to it
constexpr const char* kSaveAgain = "save the mesh again as Gmsh 4.1 or 2.2";

struct ElementType {
  int number;
  std::size_t vertices;
  CellShape shape;
};
constexpr std::array<ElementType, 8> kElementTypes{{{15, 1, CellShape::Points},
                                                    {1, 2, CellShape::Polyline},
                                                    {2, 3, CellShape::Polygon},
                                                    {3, 4, CellShape::Polygon},
                                                    {4, 4, CellShape::Tetrahedron},
                                                    {5, 8, CellShape::Hexahedron},
                                                    {6, 6, CellShape::Wedge},
                                                    {7, 5, CellShape::Pyramid}}};

/// Reads numbers that are text or binary. Keeps the first failure; every later number is 0.
class MshSource {
 public:
  MshSource(const std::string& path, std::string_view bytes) : path_(path), bytes_(bytes) {}

  void set_binary(std::endian order) {
    binary_ = true;
    order_ = order;
  }
  bool is_binary() const { return binary_; }
  bool failed() const { return failed_; }
  std::uint64_t remaining() const { return bytes_.size() - at_; }
  std::string where() const {
    if (binary_) return at_byte(path_, at_);
    const auto read = bytes_.substr(0, at_);
    return at_line(path_, 1 + static_cast<std::uint64_t>(std::count(read.begin(), read.end(), '\n')));
  }

  /// The rest of the line, without its end.
  std::string_view line() {
    const std::size_t end = std::min(bytes_.find('\n', at_), bytes_.size());
    std::string_view text = bytes_.substr(at_, end - at_);
    at_ = std::min(end + 1, bytes_.size());
    while (!text.empty() && (text.back() == '\r' || text.back() == ' ')) text.remove_suffix(1);
    return text;
  }
  bool at_end() const { return at_ == bytes_.size(); }
  /// Whether the line `text` comes next; moves behind it.
  bool skip_line(const std::string& text) {
    skip_blanks();
    return line() == text;
  }
  /// Moves behind the next line that ends with `text`, which may follow binary data at once; false when there
  /// is none.
  bool skip_behind(const std::string& text) {
    for (std::size_t at = bytes_.find(text, at_); at != bytes_.npos; at = bytes_.find(text, at + 1)) {
      const std::size_t end = at + text.size();
      if (end != bytes_.size() && std::string_view(" \r\n").find(bytes_[end]) == std::string_view::npos)
        continue;
      at_ = end;
      line();
      return true;
    }
    return false;
  }

  std::int64_t integer() { return binary_ ? stored<std::int32_t>() : text_integer(); }
  /// In binary files of 8 bytes.
  std::int64_t size() { return binary_ ? stored<std::int64_t>() : text_integer(); }
  /// A size of things that take at least one byte each; fails when the file is too short for them.
  std::uint64_t count(std::int64_t value) {
    failed_ |= value < 0 || static_cast<std::uint64_t>(value) > remaining();
    return failed_ ? 0 : static_cast<std::uint64_t>(value);
  }
  /// A finite number; else `scan` says what it is.
  double real(Scan& scan) {
    double value = 0;
    if (binary_) {
      value = stored<double>();
      scan = failed_ ? Scan::Missing : std::isfinite(value) ? Scan::Ok : Scan::NotFinite;
    } else {
      skip_blanks();
      TextCursor cursor(bytes_.substr(at_), {.comment = '\0', .continuation = false});
      scan = cursor.number(value);
      at_ = bytes_.size() - cursor.remaining().size();
    }
    failed_ |= scan != Scan::Ok;
    return value;
  }
  void skip_reals(std::uint64_t count) {
    Scan scan;
    for (std::uint64_t i = 0; i < count && !failed_; ++i) real(scan);
  }

 private:
  template <class T>
  T stored() {
    failed_ |= remaining() < sizeof(T);
    if (failed_) return {};
    at_ += sizeof(T);
    return load<T>(bytes_.data() + at_ - sizeof(T), order_);
  }
  void skip_blanks() { at_ = std::min(bytes_.find_first_not_of(" \t\r\n", at_), bytes_.size()); }
  std::int64_t text_integer() {
    skip_blanks();
    std::int64_t value = 0;
    const char *begin = bytes_.data() + at_, *end = bytes_.data() + bytes_.size();
    const auto [stop, status] = std::from_chars(begin, end, value);
    failed_ |= status != std::errc();
    at_ += static_cast<std::size_t>(stop - begin);
    return failed_ ? 0 : value;
  }

  const std::string& path_;
  std::string_view bytes_;
  std::size_t at_ = 0;
  bool binary_ = false, failed_ = false;
  std::endian order_ = std::endian::little;
};

class MshParser {
 public:
  MshParser(const std::string& path, std::string_view bytes) : in_(path, bytes) {}

  Result<MeshData> parse() {
    FOLDPROOF_TRY(read_format());
    while (!in_.at_end()) {
      const std::string section(in_.line());
      if (!section.starts_with('$')) continue;
      if (section.size() > kMaxName) return error("the name of a section is too long");
      const std::string end = "$End" + section.substr(1);
      const bool is_read = FOLDPROOF_TRY(read_section(section));
      if (is_read && in_.skip_line(end)) continue;
      if (!in_.skip_behind(end)) return error(fmt::format("the file ends within {}", section));
      if (is_read) return error(fmt::format("{} holds more than it announces", section));
    }
    return finish();
  }

 private:
  enum class Version : std::uint8_t { None, V2, V40, V41 };
  using Key = std::pair<std::int64_t, std::int64_t>;  // dimension and tag

  tl::unexpected<Error> error(std::string problem) const {
    return fail(ErrorCode::InvalidFile, in_.where(), std::move(problem), kSaveAgain);
  }
  tl::unexpected<Error> damaged() const { return error("a number is missing or wrong"); }

  Result<void> read_format() {
    if (in_.line() != "$MeshFormat") return error("does not start with $MeshFormat");
    const std::string_view version = in_.line();
    for (const auto& [name, known] :
         {std::pair("2 ", Version::V2), std::pair("2.2 ", Version::V2), std::pair("4 ", Version::V40),
          std::pair("4.0 ", Version::V40), std::pair("4.1 ", Version::V41)}) {
      if (version.starts_with(name)) version_ = known;
    }
    if (version_ == Version::None || version.size() < 5) {
      return fail(ErrorCode::UnsupportedFormat, in_.where(),
                  fmt::format("Gmsh's format '{}' is not read", version), kSaveAgain);
    }
    if (version.substr(version.find(' ') + 1).starts_with('1')) {
      in_.set_binary(std::endian::little);
      const std::int64_t one = in_.integer();
      if (one == 0x01000000) in_.set_binary(std::endian::big);
      if (one != 1 && one != 0x01000000) return damaged();
    }
    if (!in_.skip_behind("$EndMeshFormat")) return error("the file ends within $MeshFormat");
    return {};
  }

  /// False: a section that is not read.
  Result<bool> read_section(const std::string& section) {
    Result<void> read;
    if (section == "$PhysicalNames") {
      read = read_names();
    } else if (section == "$Entities") {
      read = read_entities();
    } else if (section == "$Nodes") {
      read = version_ == Version::V2 ? read_old_nodes() : read_nodes();
    } else if (section == "$Elements") {
      read = version_ == Version::V2 ? read_old_elements() : read_elements();
    } else {
      return false;
    }
    FOLDPROOF_TRY(read);
    return true;
  }

  // Lines such as: 2 7 "left wing"
  Result<void> read_names() {
    const std::uint64_t count = FOLDPROOF_TRY(count_line());
    for (std::uint64_t i = 0; i < count; ++i) {
      TextCursor cursor(in_.line(), {.comment = '\0', .continuation = false});
      std::int64_t dimension = 0, tag = 0;
      if (cursor.integer(dimension) != Scan::Ok || cursor.integer(tag) != Scan::Ok) return damaged();
      std::string_view name = cursor.rest_of_line();
      if (name.starts_with('"')) name.remove_prefix(1);
      if (name.ends_with('"')) name.remove_suffix(1);
      names_[{dimension, tag}] = name;
    }
    return {};
  }

  Result<void> read_entities() {
    std::array<std::uint64_t, 4> counts;
    for (std::uint64_t& count : counts) count = in_.count(in_.size());
    for (std::size_t dimension = 0; dimension < 4; ++dimension) {
      for (std::uint64_t i = 0; i < counts[dimension] && !in_.failed(); ++i) {
        const std::int64_t tag = in_.integer();
        in_.skip_reals(dimension == 0 && version_ == Version::V41 ? 3 : 6);
        const std::uint64_t physical = in_.count(in_.size());
        for (std::uint64_t k = 0; k < physical && !in_.failed(); ++k) {
          const std::int64_t group = in_.integer();
          if (k == 0) groups_[{static_cast<std::int64_t>(dimension), tag}] = group;
        }
        const std::uint64_t bounds = dimension == 0 ? 0 : in_.count(in_.size());
        for (std::uint64_t k = 0; k < bounds && !in_.failed(); ++k) in_.integer();
      }
    }
    return in_.failed() ? Result<void>(damaged()) : Result<void>();
  }

  Result<void> read_node(std::int64_t tag) {
    for (int k = 0; k < 3; ++k) {
      Scan scan;
      mesh_.positions.push_back(in_.real(scan));
      if (scan != Scan::Ok)
        return tl::unexpected(
            scan_error(scan, in_.where(), fmt::format("coordinate {} of node {}", "xyz"[k], tag)));
    }
    nodes_.emplace_back(tag, static_cast<Index>(nodes_.size()));
    return {};
  }

  /// By their tags, for find_node().
  Result<void> sort_nodes() {
    std::ranges::sort(nodes_);
    const auto twice = std::ranges::adjacent_find(nodes_, {}, &Node::first);
    return twice == nodes_.end() ? Result<void>()
                                 : error(fmt::format("node {} is there twice", twice->first));
  }

  Index find_node(std::int64_t tag) const {
    const auto found = std::ranges::lower_bound(nodes_, tag, {}, &Node::first);
    return found == nodes_.end() || found->first != tag ? kNoIndex : found->second;
  }

  // Counts are on lines of their own in version 2.2, also in binary files.
  Result<std::uint64_t> count_line() {
    TextCursor cursor(in_.line(), {.comment = '\0', .continuation = false});
    std::int64_t count = 0;
    if (cursor.integer(count) != Scan::Ok) return damaged();
    const std::uint64_t checked = in_.count(count);
    if (in_.failed()) return error("announces more than the file holds");
    return checked;
  }

  Result<void> read_old_nodes() {
    const std::uint64_t count = FOLDPROOF_TRY(count_line());
    for (std::uint64_t i = 0; i < count; ++i) {
      const std::int64_t tag = in_.integer();
      if (in_.failed()) return damaged();
      FOLDPROOF_TRY(read_node(tag));
    }
    return sort_nodes();
  }

  /// The number of blocks of a section; other counts follow it.
  std::uint64_t block_count() {
    const std::uint64_t blocks = in_.count(in_.size());
    for (int i = 0; i < (version_ == Version::V41 ? 3 : 1); ++i) in_.size();
    return blocks;
  }
  /// Dimension and tag of a block's entity.
  Key entity() {
    const std::int64_t first = in_.integer(), second = in_.integer();
    return version_ == Version::V41 ? Key{first, second} : Key{second, first};
  }

  Result<void> read_nodes() {
    const std::uint64_t blocks = block_count();
    std::vector<std::int64_t> tags;
    for (std::uint64_t b = 0; b < blocks; ++b) {
      const std::int64_t dimension = entity().first;
      const bool parametric = in_.integer() != 0;
      tags.resize(in_.count(in_.size()));
      for (std::int64_t& tag : tags) tag = version_ == Version::V41 ? in_.size() : 0;
      if (in_.failed() || dimension < 0 || dimension > 3) return damaged();
      for (std::int64_t tag : tags) {
        if (version_ == Version::V40) tag = in_.integer();  // beside its coordinates
        if (in_.failed()) return damaged();
        FOLDPROOF_TRY(read_node(tag));
        if (parametric) in_.skip_reals(static_cast<std::uint64_t>(dimension));
      }
    }
    return in_.failed() ? Result<void>(damaged()) : sort_nodes();
  }

  static const ElementType* type_of(std::int64_t number) {
    const auto* found = std::ranges::find(kElementTypes, number, &ElementType::number);
    return found == kElementTypes.end() ? nullptr : found;
  }
  tl::unexpected<Error> unknown_type(std::int64_t number) const {
    return fail(ErrorCode::UnsupportedFormat, in_.where(),
                fmt::format("elements of Gmsh's type {} are not read", number),
                "save the mesh with elements of the first order");
  }

  /// A tag of an element or of one of its nodes.
  std::int64_t element_number() { return version_ == Version::V41 ? in_.size() : in_.integer(); }

  /// The next element's vertices become a cell.
  Result<void> read_element(const ElementType& type, std::int64_t part) {
    std::array<Index, 8> vertices;
    for (std::size_t k = 0; k < type.vertices; ++k) {
      const std::int64_t tag = element_number();
      if (in_.failed()) return damaged();
      vertices[k] = find_node(tag);
      if (vertices[k] == kNoIndex)
        return error(fmt::format("an element refers to node {}, which is not there", tag));
    }
    if (type.shape == CellShape::Wedge) {  // the other way around than in VTK
      std::swap(vertices[1], vertices[2]);
      std::swap(vertices[4], vertices[5]);
    }
    cells_.add(type.shape, std::span(vertices).first(type.vertices), part);
    return {};
  }

  Result<void> read_old_elements() {
    const std::uint64_t count = FOLDPROOF_TRY(count_line());
    for (std::uint64_t done = 0; done < count;) {
      // Binary elements come in blocks; in text, each is a block whose number comes first.
      if (!in_.is_binary()) in_.integer();
      const std::int64_t number = in_.integer();
      const std::uint64_t block = in_.is_binary() ? in_.count(in_.integer()) : 1;
      const std::uint64_t tags = in_.count(in_.integer());
      const ElementType* type = type_of(number);
      if (in_.failed() || block == 0 || block > count - done) return damaged();
      if (!type) return unknown_type(number);
      for (std::uint64_t i = 0; i < block; ++i) {
        if (in_.is_binary()) in_.integer();
        std::array<std::int64_t, 2> tag{};  // physical group, entity
        for (std::uint64_t k = 0; k < tags && !in_.failed(); ++k) {
          const std::int64_t value = in_.integer();
          if (k < 2) tag[k] = value;
        }
        FOLDPROOF_TRY(read_element(*type, part_of(*type, tag[0], tag[1])));
      }
      done += block;
    }
    return {};
  }

  Result<void> read_elements() {
    const std::uint64_t blocks = block_count();
    for (std::uint64_t b = 0; b < blocks; ++b) {
      const Key key = entity();
      const std::int64_t number = in_.integer();
      const std::uint64_t count = in_.count(in_.size());
      if (in_.failed()) return damaged();
      const ElementType* type = type_of(number);
      if (!type) return unknown_type(number);
      const auto group = groups_.find(key);
      const std::int64_t part = part_of(*type, group == groups_.end() ? 0 : group->second, key.second);
      for (std::uint64_t i = 0; i < count; ++i) {
        element_number();
        FOLDPROOF_TRY(read_element(*type, part));
      }
    }
    return in_.failed() ? Result<void>(damaged()) : Result<void>();
  }

  /// The id of a part: a physical group, else a geometrical entity.
  std::int64_t part_of(const ElementType& type, std::int64_t group, std::int64_t entity) {
    const std::int64_t dimension = type.shape == CellShape::Polygon ? 2 : 3;
    const std::array<std::int64_t, 3> key{dimension, group, group == 0 ? entity : 0};
    const auto [at, is_new] = part_ids_.try_emplace(key, part_names_.size());
    if (is_new) {
      const auto name = names_.find({dimension, group});
      part_names_.push_back(group == 0 ? fmt::format("{} {}", dimension == 2 ? "surface" : "volume", entity)
                            : name != names_.end() ? name->second
                                                   : fmt::format("group {}", group));
    }
    return static_cast<std::int64_t>(at->second);
  }

  Result<MeshData> finish() {
    const std::vector<std::int64_t> parts = cells_.finish();
    std::vector<Index> ids(parts.size());
    std::ranges::transform(parts, ids.begin(), [](std::int64_t part) { return static_cast<Index>(part); });
    mesh_.parts = parts_by_name(part_names_, ids);
    return std::move(mesh_);
  }

  using Node = std::pair<std::int64_t, Index>;  // tag and vertex
  MshSource in_;
  Version version_ = Version::None;
  MeshData mesh_;
  CellCollector cells_{mesh_};
  std::vector<Node> nodes_;
  std::map<Key, std::string> names_;
  std::map<Key, std::int64_t> groups_;  // of entities
  std::map<std::array<std::int64_t, 3>, std::size_t> part_ids_;
  std::vector<std::string> part_names_;
};

}  // namespace

Result<MeshData> parse_msh(const std::string& path, std::string_view bytes) {
  return MshParser(path, bytes).parse();
}

}  // namespace foldproof::io
