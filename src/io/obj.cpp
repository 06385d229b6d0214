// Wavefront OBJ. A parser of our own: available libraries report errors without a line number and reject
// indices of vertices that follow later.
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "io/parts.h"
#include "io/readers.h"
#include "io/text.h"

namespace foldproof::io {
namespace {

/// Statements that add no surface: texture coordinates, normals, points, lines, grouping, display, and what
/// describes curves and surfaces, which "curv" and "surf" would add.
constexpr std::array<std::string_view, 30> kWithoutFaces{
    "vt",     "vn",     "vp",     "p",      "l",        "s",        "mg",         "bevel",
    "lod",    "mtllib", "usemap", "maplib", "c_interp", "d_interp", "shadow_obj", "trace_obj",
    "cstype", "deg",    "bmat",   "step",   "parm",     "trim",     "hole",       "scrv",
    "sp",     "end",    "con",    "ctech",  "stech",    "curv2"};

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
      } else if (keyword == "o") {
        objects_.begin(mesh_.triangles.size(), cursor_.rest_of_line());
      } else if (keyword == "g") {
        groups_.begin(mesh_.triangles.size(), cursor_.rest_of_line());
      } else if (keyword == "usemtl") {
        materials_.begin(mesh_.triangles.size(), cursor_.rest_of_line());
      } else if (std::ranges::find(kWithoutFaces, keyword) == kWithoutFaces.end()) {
        read = fail(ErrorCode::UnsupportedFormat, at_line(path_, cursor_.line()),
                    fmt::format("the statement '{}' is not read, and may add faces", keyword.substr(0, 20)),
                    "export the mesh as polygons");
      }
      if (!read) return tl::unexpected(read.error());
      while (!cursor_.at_line_end()) cursor_.word();  // on lines that continue this one, too
    }
    if (highest_.index >= mesh_.vertex_count()) {
      return fail(
          ErrorCode::InvalidFile, at_line(path_, highest_.line),
          fmt::format("face refers to vertex {}, but there are {}", highest_.index + 1, mesh_.vertex_count()),
          "export the mesh again");
    }
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

  Result<void> read_face() {
    polygon_.clear();
    const std::uint64_t line = cursor_.line();
    while (!cursor_.at_line_end()) {
      std::int64_t number;
      if (const Scan scan = cursor_.leading_integer(number); scan != Scan::Ok) {
        return tl::unexpected(scan_error(scan, at_line(path_, cursor_.line()), "a vertex of the face"));
      }
      // A texture coordinate or a normal may follow, after a slash.
      if (const std::string_view tail = cursor_.tail(); !tail.empty() && tail[0] != '/') {
        return tl::unexpected(
            scan_error(Scan::Malformed, at_line(path_, cursor_.line()), "a vertex of the face"));
      }
      const auto count = static_cast<std::int64_t>(mesh_.positions.size() / 3);
      const std::int64_t index = number < 0 ? count + number : number - 1;
      if (number == 0 || index < 0 || index > static_cast<std::int64_t>(kMaxVertices)) {
        return fail(ErrorCode::InvalidFile, at_line(path_, cursor_.line()),
                    fmt::format("face refers to vertex {}, but there are {}", number, count),
                    "export the mesh again");
      }
      if (highest_.line == 0 || index > highest_.index) highest_ = {index, line};
      polygon_.push_back(static_cast<Index>(index));
    }
    if (polygon_.size() < 3) {
      return fail(ErrorCode::InvalidFile, at_line(path_, line),
                  fmt::format("face has {} vertices", polygon_.size()),
                  "remove faces with fewer than three vertices");
    }
    mesh_.add_polygon(polygon_);
    return {};
  }

  const std::string& path_;
  TextCursor cursor_;
  MeshData mesh_;
  std::vector<Index> polygon_;
  NameRuns objects_, groups_, materials_;
  // Faces may precede their vertices, so the highest index is checked at the end.
  struct {
    std::int64_t index = -1;
    std::uint64_t line = 0;
  } highest_;
};

}  // namespace

Result<MeshData> parse_obj(const std::string& path, std::string_view bytes) {
  return ObjParser(path, bytes).parse();
}

}  // namespace foldproof::io
