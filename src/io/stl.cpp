// STL, ASCII and binary. A parser of our own: readers that are packaged report no place, and weld within a
// distance.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/try.h"
#include "io/bytes.h"
#include "io/parts.h"
#include "io/readers.h"
#include "io/text.h"

namespace foldproof::io {
namespace {

constexpr std::size_t kHeader = 80, kFacet = 50;
constexpr const char* kExportAgain = "export the mesh as STL again";

/// Collects the corners of facets, and numbers vertices in the order in which they come. Corners at exactly
/// the same place are one vertex. Sorts: a file could be made to defeat a hash.
class Welder {
 public:
  void reserve(std::size_t facets) { corners_.reserve(3 * facets); }
  void add(const std::array<double, 3>& x) { corners_.push_back({x, corners_.size()}); }
  std::size_t facets() const { return corners_.size() / 3; }

  /// Adds vertices and triangles to an empty mesh.
  void finish(MeshData& mesh) {
    std::ranges::sort(corners_, [](const Corner& a, const Corner& b) {
      return a.x != b.x ? a.x < b.x : a.place < b.place;  // -0 equals 0
    });
    std::vector<std::size_t> first(corners_.size());  // per place, where the first corner that equals it is
    for (std::size_t i = 0, begin = 0; i < corners_.size(); ++i) {
      if (corners_[i].x != corners_[begin].x) begin = i;
      first[corners_[i].place] = begin;
    }
    mesh.triangles.resize(facets());
    for (std::size_t place = 0; place < first.size(); ++place) {
      const auto& [x, earliest] = corners_[first[place]];
      Index& vertex = mesh.triangles[place / 3][place % 3];
      vertex = earliest == place ? mesh.vertex_count() : mesh.triangles[earliest / 3][earliest % 3];
      if (earliest == place) mesh.positions.insert(mesh.positions.end(), x.begin(), x.end());
    }
  }

 private:
  struct Corner {
    std::array<double, 3> x;
    std::size_t place;  // in the file
  };
  std::vector<Corner> corners_;
};

Result<MeshData> parse_binary(const std::string& path, std::string_view bytes, std::uint32_t facets) {
  MeshData mesh;
  Welder welder;
  welder.reserve(facets);
  for (std::uint32_t i = 0; i < facets; ++i) {
    // The normal, 12 bytes, comes first; two bytes of attributes come last.
    const std::size_t corners = kHeader + 4 + i * kFacet + 12;
    for (std::size_t corner = 0; corner < 3; ++corner) {
      std::array<double, 3> x;
      for (std::size_t k = 0; k < 3; ++k) {
        x[k] = load<float>(bytes.data() + corners + 12 * corner + 4 * k, std::endian::little);
        if (std::isfinite(x[k])) continue;
        return fail(ErrorCode::NonFinite, fmt::format("{}, facet {}", path, i), "a coordinate is not finite",
                    "export the mesh without NaN or infinite coordinates");
      }
      welder.add(x);
    }
  }
  welder.finish(mesh);
  return mesh;
}

class AsciiParser {
 public:
  AsciiParser(const std::string& path, std::string_view text)
      : path_(path), cursor_(text, {.comment = '\0', .continuation = false}) {}

  Result<MeshData> parse() {
    while (cursor_.skip_to_content()) {
      const std::string_view keyword = cursor_.word();
      if (keyword == "vertex") {
        FOLDPROOF_TRY(read_vertex());
      } else if (keyword == "endfacet") {
        FOLDPROOF_TRY(end_facet());
      } else if (keyword == "normal") {
        for (int k = 0; k < 3 && cursor_.skip_to_content(); ++k) cursor_.word();
      } else if (keyword == "solid" || keyword == "endsolid") {
        const std::string_view name = cursor_.rest_of_line();
        if (name.find("facet") != name.npos && name.find("vertex") != name.npos)
          return error("a facet is on the line of its solid");
        if (keyword == "solid") solids_.begin(welder_.facets(), name);
      } else if (keyword != "facet" && keyword != "outer" && keyword != "loop" && keyword != "endloop") {
        return error("is not understood");
      }
    }
    if (corners_ != 0) return error("the file ends within a facet");
    welder_.finish(mesh_);
    mesh_.parts = solids_.parts(mesh_.triangles.size());
    return std::move(mesh_);
  }

 private:
  tl::unexpected<Error> error(std::string problem) const {
    return fail(ErrorCode::InvalidFile, at_line(path_, cursor_.line()), std::move(problem), kExportAgain);
  }

  Result<void> read_vertex() {
    std::array<double, 3> x;
    for (std::size_t k = 0; k < 3; ++k) {
      if (const Scan scan = cursor_.number(x[k]); scan != Scan::Ok) {
        return tl::unexpected(
            scan_error(scan, at_line(path_, cursor_.line()), fmt::format("coordinate {}", "xyz"[k])));
      }
    }
    welder_.add(x);
    ++corners_;
    return {};
  }

  Result<void> end_facet() {
    if (corners_ != 3) return error(fmt::format("facet has {} vertices", corners_));
    corners_ = 0;
    return {};
  }

  const std::string& path_;
  TextCursor cursor_;
  MeshData mesh_;
  Welder welder_;
  NameRuns solids_;
  std::size_t corners_ = 0;  // of the facet so far
};

}  // namespace

Result<MeshData> parse_stl(const std::string& path, std::string_view bytes) {
  const bool has_count = bytes.size() >= kHeader + 4;
  const std::uint32_t facets =
      has_count ? load<std::uint32_t>(bytes.data() + kHeader, std::endian::little) : 0;
  // Headers of binary files may begin with "solid", too, so the size decides.
  if (has_count && bytes.size() == kHeader + 4 + std::uint64_t{facets} * kFacet)
    return parse_binary(path, bytes, facets);
  if (bytes.starts_with("solid")) return AsciiParser(path, bytes).parse();
  if (!has_count)
    return fail(ErrorCode::InvalidFile, path,
                "is too short for a binary STL, and does not begin with 'solid'", kExportAgain);
  return fail(ErrorCode::InvalidFile, at_byte(path, kHeader),
              fmt::format("header announces {} facets of {} bytes, but {} bytes follow it", facets, kFacet,
                          bytes.size() - kHeader - 4),
              "copy or export the mesh again");
}

}  // namespace foldproof::io
