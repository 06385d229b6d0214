// VTK's legacy files (.vtk), versions 1 to 5, ASCII and binary: polygons and cells. A parser of our own, like
// that of its XML files.
#include <fmt/format.h>

#include <algorithm>

#include "base/try.h"
#include "io/cells.h"
#include "io/number_type.h"
#include "io/parts.h"
#include "io/text.h"

namespace foldproof::io {
namespace {

constexpr const char* kWriteVtkAgain = "write the file again";

std::string lower(std::string_view text) {
  std::string copy(text);
  for (char& c : copy) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return copy;
}

/// Words, and arrays of numbers that are text or big-endian.
class LegacySource {
 public:
  LegacySource(const std::string& path, std::string_view bytes)
      : path_(path), bytes_(bytes), cursor_(bytes, kDialect) {}

  void set_binary() { binary_ = true; }
  /// The next word in lower case, on this line or a later one; empty at the end.
  std::string keyword() { return cursor_.skip_to_content() ? lower(cursor_.word()) : ""; }
  std::string_view word() { return cursor_.word(); }
  std::string_view line() {
    const std::string_view text = cursor_.rest_of_line();
    cursor_.next_line();
    return text;
  }
  /// Moves behind the next empty line.
  void skip_block() {
    for (cursor_.next_line(); !cursor_.at_end() && !cursor_.at_line_end();) cursor_.next_line();
  }

  /// A count on this line.
  Result<std::uint64_t> count() {
    std::int64_t value = 0;
    if (cursor_.integer(value) != Scan::Ok || value < 0 || value >= kNoIndex)
      return error("a count is missing or wrong");
    return static_cast<std::uint64_t>(value);
  }

  /// `count` numbers of the type that has this name, from the next line on.
  template <class T>
  Result<std::vector<T>> values(const std::string& type_name, std::uint64_t count) {
    const NumberType type = legacy_number_type(type_name);
    if (type.bytes == 0 || (std::is_same_v<T, std::int64_t> && type.kind == NumberType::Kind::Float))
      return error(fmt::format("numbers of the type '{}' are not read here", type_name));
    // In text, a number and a blank; the last may have none.
    if (count > (remaining() + 1) / (binary_ ? type.bytes : 2))
      return error(fmt::format("{} numbers are announced, but the file ends before", count));
    std::vector<T> values;
    values.reserve(count);
    if (!binary_) {
      FOLDPROOF_TRY(read_text(values, count));
      return values;
    }
    cursor_.next_line();
    const std::string_view data = cursor_.remaining();
    if (count > data.size() / type.bytes)
      return error(fmt::format("{} numbers are announced, but the file ends before", count));
    for (std::uint64_t i = 0; i < count; ++i)
      values.push_back(load_as<T>(type, data.data() + i * type.bytes, std::endian::big));
    cursor_ = TextCursor(data.substr(count * type.bytes), kDialect);
    return values;
  }

  /// Moves behind `count` values of the type, which may be unknown in text.
  Result<void> skip(const std::string& type_name, std::uint64_t count) {
    const auto cut = [&] {
      return error(fmt::format("{} values are announced, but the file ends before", count));
    };
    if (!binary_) {
      for (std::uint64_t i = 0; i < count; ++i) {
        if (!cursor_.skip_to_content()) return cut();
        cursor_.word();
      }
      return {};
    }
    const std::size_t bytes = legacy_number_type(type_name).bytes;
    if (bytes == 0) return error(fmt::format("values of the type '{}' are not read here", type_name));
    cursor_.next_line();
    const std::string_view data = cursor_.remaining();
    if (count > data.size() / bytes) return cut();
    cursor_ = TextCursor(data.substr(count * bytes), kDialect);
    return {};
  }

  tl::unexpected<Error> error(std::string problem) const {
    return fail(ErrorCode::InvalidFile, where(), std::move(problem), kWriteVtkAgain);
  }
  std::string where() const {
    return binary_ ? at_byte(path_, bytes_.size() - remaining()) : at_line(path_, cursor_.line());
  }

 private:
  static constexpr TextCursor::Dialect kDialect{.comment = '\0', .continuation = false};
  std::uint64_t remaining() const { return cursor_.remaining().size(); }

  template <class T>
  Result<void> read_text(std::vector<T>& values, std::uint64_t count) {
    for (std::uint64_t i = 0; i < count; ++i) {
      cursor_.skip_to_content();
      T value;
      Scan scan;
      if constexpr (std::is_same_v<T, std::int64_t>) {
        scan = cursor_.integer(value);
      } else {
        scan = cursor_.number(value);
      }
      if (scan != Scan::Ok) return tl::unexpected(scan_error(scan, where(), fmt::format("value {}", i)));
      values.push_back(value);
    }
    return {};
  }

  const std::string& path_;
  std::string_view bytes_;
  TextCursor cursor_;
  bool binary_ = false;
};

class LegacyParser {
 public:
  LegacyParser(const std::string& path, std::string_view bytes) : path_(path), in_(path, bytes) {}

  Result<MeshData> parse() {
    FOLDPROOF_TRY(read_header());
    for (std::string keyword = in_.keyword(); !keyword.empty(); keyword = in_.keyword()) {
      if (keyword == "point_data") break;  // nothing but attributes follows
      if (keyword == "cell_data") {
        FOLDPROOF_TRY(read_labels());
        break;
      }
      FOLDPROOF_TRY(read_section(keyword));
    }
    return finish();
  }

 private:
  /// Cells of a section, and the type of all if its name says it.
  struct Section {
    const char* name;
    std::int64_t type;
    VtkCells cells;
  };

  // The first line, a title, the encoding.
  Result<void> read_header() {
    const std::string first = lower(in_.line());
    constexpr std::string_view kStart = "# vtk datafile version ";
    if (!first.starts_with(kStart)) return in_.error("does not start with '# vtk DataFile Version'");
    has_offsets_ = first.size() > kStart.size() && first[kStart.size()] >= '5';
    in_.line();
    const std::string encoding = in_.keyword();
    if (encoding == "binary") {
      in_.set_binary();
    } else if (encoding != "ascii") {
      return in_.error("is neither ASCII nor BINARY");
    }
    return {};
  }

  Result<void> read_section(const std::string& keyword) {
    if (keyword == "metadata") {
      in_.skip_block();
      return {};
    }
    if (keyword == "field") {
      in_.word();
      return read_field([](std::string_view) { return false; });
    }
    if (keyword == "dataset") return read_type();
    if (keyword == "points") return read_points();
    const auto section = std::ranges::find_if(sections_, [&](const Section& s) { return keyword == s.name; });
    if (section != sections_.end()) return read_cells(*section);
    if (keyword == "cell_types") {
      const std::uint64_t count = FOLDPROOF_TRY(in_.count());
      sections_.back().cells.types = FOLDPROOF_TRY(in_.values<std::int64_t>("int", count));
      return {};
    }
    return in_.error(fmt::format("'{}' is not understood", keyword.substr(0, 20)));
  }

  Result<void> read_type() {
    const std::string type = lower(in_.word());
    if (type == "polydata" || type == "unstructured_grid") return {};
    return fail(ErrorCode::UnsupportedFormat, in_.where(), fmt::format("holds {}, which is not read", type),
                "extract its surface in ParaView, and save that as .vtp");
  }

  Result<void> read_points() {
    const std::uint64_t count = FOLDPROOF_TRY(in_.count());
    if (!mesh_.positions.empty()) return in_.error("has points twice");
    mesh_.positions = FOLDPROOF_TRY(in_.values<double>(lower(in_.word()), 3 * count));
    return check_finite(path_, mesh_.positions);
  }

  // Up to version 4, each cell is the number of its vertices and these. Then, the places where cells begin
  // and end come first.
  Result<void> read_cells(Section& section) {
    const std::uint64_t count = FOLDPROOF_TRY(in_.count()), size = FOLDPROOF_TRY(in_.count());
    VtkCells& cells = section.cells;
    if (!cells.ends.empty()) return in_.error(fmt::format("has {} twice", section.name));
    if (!has_offsets_) {
      const auto numbers = FOLDPROOF_TRY(in_.values<std::int64_t>("int", size));
      for (std::size_t at = 0; at < numbers.size();) {
        const auto left = static_cast<std::int64_t>(numbers.size() - at);
        const std::int64_t corners = numbers[at++];
        if (corners < 0 || corners >= left) return in_.error("a cell is longer than its section");
        cells.ids.insert(cells.ids.end(), numbers.begin() + static_cast<std::ptrdiff_t>(at),
                         numbers.begin() + static_cast<std::ptrdiff_t>(at) + corners);
        at += static_cast<std::size_t>(corners);
        cells.ends.push_back(static_cast<std::int64_t>(cells.ids.size()));
      }
      if (cells.ends.size() != count)
        return in_.error(fmt::format("{} cells are announced, but there are {}", count, cells.ends.size()));
      return {};
    }
    if (count == 0) return {};
    if (in_.keyword() != "offsets") return in_.error("OFFSETS are missing");
    cells.ends = FOLDPROOF_TRY(in_.values<std::int64_t>(lower(in_.word()), count));
    if (in_.keyword() != "connectivity") return in_.error("CONNECTIVITY is missing");
    cells.ids = FOLDPROOF_TRY(in_.values<std::int64_t>(lower(in_.word()), size));
    if (cells.ends.front() != 0) return in_.error("the first offset is not 0");
    cells.ends.erase(cells.ends.begin());
    return {};
  }

  /// Arrays, each with its name. `take(name)`: whether it is what labels cells.
  template <class Take>
  Result<void> read_field(const Take& take) {
    const std::uint64_t arrays = FOLDPROOF_TRY(in_.count());
    for (std::uint64_t i = 0; i < arrays; ++i) {
      std::string name = in_.keyword();
      if (name == "metadata") {
        in_.skip_block();
        name = in_.keyword();
      }
      const std::uint64_t components = FOLDPROOF_TRY(in_.count()), tuples = FOLDPROOF_TRY(in_.count());
      const std::string type = lower(in_.word());
      const bool integers = legacy_number_type(type).kind != NumberType::Kind::Float;
      if (components == 1 && integers && take(name)) {
        labels_ = FOLDPROOF_TRY(in_.values<std::int64_t>(type, tuples));
        return {};
      }
      FOLDPROOF_TRY(in_.skip(type, components * tuples));
    }
    return {};
  }

  /// Numbers of one name, after the name of a table of colors.
  template <class Take>
  Result<void> read_scalars(std::uint64_t cells, const Take& take) {
    const std::string name(in_.word()), type = lower(in_.word());
    const std::string_view text = in_.word();
    const std::uint64_t components = text.empty() ? 1 : static_cast<std::uint64_t>(text[0] - '0');
    if (text.size() > 1 || components < 1 || components > 4)
      return in_.error("SCALARS have 1 to 4 components");
    if (in_.keyword() != "lookup_table") return in_.error("LOOKUP_TABLE is missing");
    in_.word();
    if (components > 1 || legacy_number_type(type).kind == NumberType::Kind::Float || !take(name))
      return in_.skip(type, cells * components);
    labels_ = FOLDPROOF_TRY(in_.values<std::int64_t>(type, cells));
    return {};
  }

  // Attributes of cells, up to the first that labels them, or of a kind other than these two.
  Result<void> read_labels() {
    const std::uint64_t cells = FOLDPROOF_TRY(in_.count());
    const auto take = [&](std::string_view name) {
      part_kind_ = part_kind(name);
      return !part_kind_.empty();
    };
    while (part_kind_.empty()) {
      const std::string keyword = in_.keyword();
      if (keyword == "metadata") {
        in_.skip_block();
      } else if (keyword == "field") {
        in_.word();
        FOLDPROOF_TRY(read_field(take));
      } else if (keyword == "scalars") {
        FOLDPROOF_TRY(read_scalars(cells, take));
      } else {
        return {};
      }
    }
    return {};
  }

  Result<MeshData> finish() {
    std::size_t first_cell = 0;
    for (Section& section : sections_) {
      VtkCells& cells = section.cells;
      const auto error = [&](std::string problem) {
        return fail(ErrorCode::InvalidFile, fmt::format("{}, {}", path_, section.name), std::move(problem),
                    kWriteVtkAgain);
      };
      if (section.type != 0) cells.types.assign(cells.ends.size(), section.type);
      if (cells.types.size() != cells.ends.size())
        return error(fmt::format("has {} types for {} cells", cells.types.size(), cells.ends.size()));
      const auto labels = std::span(labels_).subspan(std::min(first_cell, labels_.size()));
      first_cell += cells.ends.size();
      if (std::string problem = cells_.add(cells, {0, mesh_.vertex_count()}, labels); !problem.empty())
        return error(std::move(problem));
    }
    const std::vector<std::int64_t> parts = cells_.finish();
    mesh_.parts = parts_by_number(part_kind_, parts);
    return std::move(mesh_);
  }

  const std::string& path_;
  LegacySource in_;
  MeshData mesh_;
  CellCollector cells_{mesh_};
  bool has_offsets_ = false;  // version 5
  // In the order in which VTK counts cells.
  std::array<Section, 5> sections_{{{"vertices", 2, {}},
                                    {"lines", 4, {}},
                                    {"polygons", 7, {}},
                                    {"triangle_strips", 6, {}},
                                    {"cells", 0, {}}}};
  std::string_view part_kind_;
  std::vector<std::int64_t> labels_;  // per cell
};

}  // namespace

Result<MeshData> parse_vtk(const std::string& path, std::string_view bytes) {
  return LegacyParser(path, bytes).parse();
}

}  // namespace foldproof::io
