// Wavefront OBJ. A parser of our own: available libraries report errors without a line number and reject
// indices of vertices that follow later.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>

#include "base/try.h"
#include "io/parts.h"
#include "io/readers.h"
#include "io/text.h"

namespace foldproof::io {
namespace {

/// Statements that add what is not read: free-form curves and surfaces (older ones of fixed sizes, too), and
/// other files.
constexpr std::array<std::string_view, 7> kGeometry{"surf", "curv", "bsp", "bzp", "cdc", "cdp", "call"};

/// Statements that add no surface: texture coordinates, normals, grouping, display, and what describes the
/// free-form curves and surfaces.
constexpr std::array<std::string_view, 28> kWithoutFaces{
    "vt",     "vn",     "vp",     "s",        "mg",       "bevel",      "lod",
    "mtllib", "usemap", "maplib", "c_interp", "d_interp", "shadow_obj", "trace_obj",
    "cstype", "deg",    "bmat",   "step",     "parm",     "trim",       "hole",
    "scrv",   "sp",     "end",    "con",      "ctech",    "stech",      "curv2"};

class ObjParser {
 public:
  ObjParser(const std::string& path, std::string_view text)
      : path_(path), cursor_(text, {.comment = '#', .continuation = true}) {}

  Result<MeshData> parse() {
    for (; cursor_.skip_to_content(); cursor_.next_line()) {
      const std::string_view keyword = cursor_.word();
      Result<void> read;
      if (keyword == "v") {
        read = read_vertex();
      } else if (keyword == "f" || keyword == "fo") {  // "fo" is an obsolete form of "f"
        read = read_face();
      } else if (keyword == "l") {
        read = read_ids("line");
        mesh_.add_polyline(ids_);
      } else if (keyword == "p") {
        read = read_ids("point");
        mesh_.points.insert(mesh_.points.end(), ids_.begin(), ids_.end());
      } else if (keyword == "o") {
        objects_.begin(mesh_.triangles.size(), cursor_.rest_of_line());
      } else if (keyword == "g") {
        groups_.begin(mesh_.triangles.size(), cursor_.rest_of_line());
      } else if (keyword == "usemtl") {
        materials_.begin(mesh_.triangles.size(), cursor_.rest_of_line());
      } else if (std::ranges::find(kWithoutFaces, keyword) == kWithoutFaces.end()) {
        count_skipped(keyword);
      }
      if (!read) return tl::unexpected(read.error());
      while (!cursor_.at_line_end()) cursor_.word();  // on lines that continue this one, too
    }
    if (highest_.index >= mesh_.vertex_count()) {
      return fail(ErrorCode::InvalidFile, at_line(path_, highest_.line),
                  fmt::format("{} refers to vertex {}, but there are {}", highest_.element,
                              highest_.index + 1, mesh_.vertex_count()),
                  "export the mesh again");
    }
    name_skipped();
    for (const NameRuns* names : {&objects_, &groups_, &materials_}) {
      if (mesh_.parts.names.empty()) mesh_.parts = names->parts(mesh_.triangles.size());
    }
    return std::move(mesh_);
  }

 private:
  // Columns after the third (a weight or a color) are ignored.
  Result<void> read_vertex() {
    for (int k = 0; k < 3; ++k) {
      double x;
      if (const Scan scan = cursor_.number(x); scan != Scan::Ok) {
        return tl::unexpected(
            scan_error(scan, at_line(path_, cursor_.line()),
                       fmt::format("coordinate {} of vertex {}", "xyz"[k], mesh_.positions.size() / 3 + 1)));
      }
      mesh_.positions.push_back(x);
    }
    return {};
  }

  /// The vertices that the rest of the line names, for a face, a line or points.
  Result<void> read_ids(const char* element) {
    ids_.clear();
    const std::uint64_t line = cursor_.line();
    while (!cursor_.at_line_end()) {
      std::int64_t number;
      if (const Scan scan = cursor_.leading_integer(number); scan != Scan::Ok) {
        return tl::unexpected(not_a_vertex(scan, element));
      }
      // A texture coordinate or a normal may follow, after a slash.
      if (const std::string_view tail = cursor_.tail(); !tail.empty() && tail[0] != '/')
        return tl::unexpected(not_a_vertex(Scan::Malformed, element));
      const auto count = static_cast<std::int64_t>(mesh_.positions.size() / 3);
      const std::int64_t index = number < 0 ? count + number : number - 1;
      if (number == 0 || index < 0 || index > static_cast<std::int64_t>(kMaxVertices)) {
        return fail(ErrorCode::InvalidFile, at_line(path_, cursor_.line()),
                    fmt::format("{} refers to vertex {}, but there are {}", element, number, count),
                    "export the mesh again");
      }
      if (highest_.line == 0 || index > highest_.index) highest_ = {index, line, element};
      ids_.push_back(static_cast<Index>(index));
    }
    return {};
  }

  Error not_a_vertex(Scan scan, const char* element) const {
    return scan_error(scan, at_line(path_, cursor_.line()), fmt::format("a vertex of the {}", element));
  }

  Result<void> read_face() {
    const std::uint64_t line = cursor_.line();
    FOLDPROOF_TRY(read_ids("face"));
    if (ids_.size() < 3) {
      return fail(ErrorCode::InvalidFile, at_line(path_, line),
                  fmt::format("face has {} vertices", ids_.size()),
                  "remove faces with fewer than three vertices");
    }
    mesh_.add_polygon(ids_);
    return {};
  }

  void count_skipped(std::string_view keyword) {
    const auto geometry = std::ranges::find(kGeometry, keyword);
    if (geometry != kGeometry.end()) {
      ++geometry_[static_cast<std::size_t>(geometry - kGeometry.begin())];
      return;
    }
    ++unknown_;
    constexpr std::size_t kNamed = 3;
    const std::string name(keyword.substr(0, 20));
    if (std::ranges::find(names_, name) != names_.end()) return;
    if (names_.size() < kNamed) {
      names_.push_back(name);
    } else {
      has_more_names_ = true;
    }
  }

  void name_skipped() {
    for (std::size_t i = 0; i < kGeometry.size(); ++i) {
      if (geometry_[i] == 0) continue;
      const bool one = geometry_[i] == 1;
      mesh_.unchecked.push_back(fmt::format("{} {} '{}' {} not checked", geometry_[i],
                                            one ? "statement" : "statements", kGeometry[i],
                                            one ? "was" : "were"));
    }
    if (unknown_ == 0) return;
    mesh_.notes.push_back(fmt::format(
        "{} {} not known and {} skipped: '{}'{}", unknown_, unknown_ == 1 ? "statement is" : "statements are",
        unknown_ == 1 ? "was" : "were", fmt::join(names_, "', '"), has_more_names_ ? " and others" : ""));
  }

  const std::string& path_;
  TextCursor cursor_;
  MeshData mesh_;
  std::array<std::uint64_t, kGeometry.size()> geometry_{};  // how many of each
  std::uint64_t unknown_ = 0;
  std::vector<std::string> names_;  // of unknown statements, the first few
  bool has_more_names_ = false;
  std::vector<Index> ids_;  // that the statement names
  NameRuns objects_, groups_, materials_;
  // Faces may precede their vertices, so the highest index is checked at the end.
  struct {
    std::int64_t index = -1;
    std::uint64_t line = 0;
    const char* element = "";
  } highest_;
};

}  // namespace

Result<MeshData> parse_obj(const std::string& path, std::string_view bytes) {
  return ObjParser(path, bytes).parse();
}

}  // namespace foldproof::io
