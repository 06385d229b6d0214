// Object File Format (Geomview), ASCII. A parser of our own: no packaged reader reports errors.
#include <fmt/format.h>

#include "base/try.h"
#include "io/readers.h"
#include "io/text.h"

namespace foldproof::io {
namespace {

class OffParser {
 public:
  OffParser(const std::string& path, std::string_view text)
      : path_(path), cursor_(text, {.comment = '#', .continuation = false}) {}

  Result<MeshData> parse() {
    FOLDPROOF_TRY(read_header());
    mesh_.positions.reserve(static_cast<std::size_t>(vertices_) * 3);
    mesh_.triangles.reserve(static_cast<std::size_t>(faces_));
    for (std::int64_t i = 0; i < vertices_; ++i) {
      FOLDPROOF_TRY(read_vertex(i));
    }
    for (std::int64_t i = 0; i < faces_; ++i) {
      FOLDPROOF_TRY(read_face(i));
    }
    if (cursor_.skip_to_content()) {
      return fail(ErrorCode::InvalidFile, here(), "there is more data than the header announces",
                  "export the mesh again");
    }
    return std::move(mesh_);
  }

 private:
  std::string here() const { return at_line(path_, cursor_.line()); }

  // [ST][C][N]OFF, with the counts on the same line or the next.
  Result<void> read_header() {
    cursor_.skip_to_content();
    std::string_view word = cursor_.word();
    for (const std::string_view prefix : {"ST", "C", "N"}) {
      if (word.starts_with(prefix)) word.remove_prefix(prefix.size());
    }
    if (word != "OFF") {
      return fail(ErrorCode::InvalidFile, here(), "does not start with OFF (or COFF, NOFF, STOFF)",
                  "export the mesh as OFF again");
    }
    if (!cursor_.at_line_end() && cursor_.remaining().starts_with("BINARY")) {
      return fail(ErrorCode::UnsupportedFormat, here(), "is a binary OFF file",
                  "export the mesh as ASCII OFF, or as binary PLY");
    }
    cursor_.skip_to_content();
    if (cursor_.integer(vertices_) != Scan::Ok || cursor_.integer(faces_) != Scan::Ok || vertices_ < 0 ||
        faces_ < 0) {
      return fail(ErrorCode::InvalidFile, here(), "the numbers of vertices and faces are missing",
                  "export the mesh as OFF again");
    }
    std::int64_t edges;  // unreliable in practice, and absent from old files
    if (!cursor_.at_line_end() && (cursor_.integer(edges) != Scan::Ok || !cursor_.at_line_end())) {
      return fail(ErrorCode::InvalidFile, here(), "the line of counts is not understood",
                  "export the mesh as OFF again");
    }
    // A vertex takes 6 bytes ("0 0 0" and a line end), a face 8; the last line end may be missing.
    const std::uint64_t remaining = cursor_.remaining().size() + 1;
    if (static_cast<std::uint64_t>(vertices_) > remaining / 6 ||
        static_cast<std::uint64_t>(faces_) > remaining / 8) {
      return fail(ErrorCode::InvalidFile, here(),
                  fmt::format("header announces {} vertices and {} faces, but the file ends before",
                              vertices_, faces_),
                  "copy or export the mesh again");
    }
    cursor_.next_line();
    return {};
  }

  // Normals, colors and texture coordinates after the position are ignored.
  Result<void> read_vertex(std::int64_t vertex) {
    cursor_.skip_to_content();
    for (int k = 0; k < 3; ++k) {
      double x;
      if (const Scan scan = cursor_.number(x); scan != Scan::Ok) {
        return tl::unexpected(
            scan_error(scan, here(), fmt::format("coordinate {} of vertex {}", "xyz"[k], vertex)));
      }
      mesh_.positions.push_back(x);
    }
    cursor_.next_line();
    return {};
  }

  // Colors after the vertices are ignored.
  Result<void> read_face(std::int64_t face) {
    cursor_.skip_to_content();
    std::int64_t corners;
    if (const Scan scan = cursor_.integer(corners); scan != Scan::Ok) {
      return tl::unexpected(scan_error(scan, here(), fmt::format("the size of face {}", face)));
    }
    if (corners < 3) {
      return fail(ErrorCode::InvalidFile, here(), fmt::format("face {} has {} vertices", face, corners),
                  "remove faces with fewer than three vertices");
    }
    polygon_.clear();
    for (std::int64_t i = 0; i < corners; ++i) {
      cursor_.skip_to_content();  // a face may take several lines
      std::int64_t v;
      if (const Scan scan = cursor_.integer(v); scan != Scan::Ok) {
        return tl::unexpected(scan_error(scan, here(), fmt::format("vertex {} of face {}", i, face)));
      }
      if (v < 0 || v >= vertices_) {
        return fail(ErrorCode::InvalidFile, here(),
                    fmt::format("face {} refers to vertex {}, but there are {} (counting from 0)", face, v,
                                vertices_),
                    "export the mesh again");
      }
      polygon_.push_back(static_cast<Index>(v));
    }
    mesh_.add_polygon(polygon_);
    cursor_.next_line();
    return {};
  }

  const std::string& path_;
  TextCursor cursor_;
  MeshData mesh_;
  std::int64_t vertices_ = 0, faces_ = 0;
  std::vector<Index> polygon_;
};

}  // namespace

Result<MeshData> parse_off(const std::string& path, std::string_view bytes) {
  return OffParser(path, bytes).parse();
}

}  // namespace foldproof::io
