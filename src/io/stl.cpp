// STL, ASCII and binary. A parser of our own: readers that are packaged report no place, and weld within a
// distance.
#include <fmt/format.h>

#include <cmath>
#include <unordered_map>

#include "base/try.h"
#include "io/bytes.h"
#include "io/parts.h"
#include "io/readers.h"
#include "io/text.h"

namespace foldproof::io {
namespace {

constexpr std::size_t kHeader = 80, kFacet = 50;
constexpr const char* kExportAgain = "export the mesh as STL again";

/// Numbers vertices in the order in which they come. Those at exactly the same place are one.
class Welder {
 public:
  explicit Welder(MeshData& mesh) : mesh_(mesh) {}

  Index vertex(const std::array<double, 3>& x) {
    const auto [at, is_new] = ids_.try_emplace(x, static_cast<Index>(ids_.size()));
    if (is_new) mesh_.positions.insert(mesh_.positions.end(), x.begin(), x.end());
    return at->second;
  }

 private:
  struct Hash {
    std::size_t operator()(const std::array<double, 3>& x) const {
      std::uint64_t hash = 0;
      for (const double c : x) {
        hash = (hash ^ std::bit_cast<std::uint64_t>(c + 0.0)) * 0x9E3779B97F4A7C15u;  // -0 equals 0
        hash ^= hash >> 29;
      }
      return hash;
    }
  };
  MeshData& mesh_;
  std::unordered_map<std::array<double, 3>, Index, Hash> ids_;
};

Result<MeshData> parse_binary(const std::string& path, std::string_view bytes, std::uint32_t facets) {
  MeshData mesh;
  Welder welder(mesh);
  mesh.triangles.reserve(facets);
  for (std::uint32_t i = 0; i < facets; ++i) {
    // The normal, 12 bytes, comes first; two bytes of attributes come last.
    const std::size_t corners = kHeader + 4 + i * kFacet + 12;
    Triangle triangle;
    for (std::size_t corner = 0; corner < 3; ++corner) {
      std::array<double, 3> x;
      for (std::size_t k = 0; k < 3; ++k) {
        x[k] = load<float>(bytes.data() + corners + 12 * corner + 4 * k, std::endian::little);
        if (std::isfinite(x[k])) continue;
        return fail(ErrorCode::NonFinite, fmt::format("{}, facet {}", path, i), "a coordinate is not finite",
                    "export the mesh without NaN or infinite coordinates");
      }
      triangle[corner] = welder.vertex(x);
    }
    mesh.triangles.push_back(triangle);
  }
  return mesh;
}

class AsciiParser {
 public:
  AsciiParser(const std::string& path, std::string_view text)
      : path_(path), cursor_(text, {.comment = '\0', .continuation = false}) {}

  Result<MeshData> parse() {
    for (; cursor_.skip_to_content(); cursor_.next_line()) {
      const std::string_view keyword = cursor_.word();
      if (keyword == "vertex") {
        FOLDPROOF_TRY(read_vertex());
      } else if (keyword == "endfacet") {
        FOLDPROOF_TRY(end_facet());
      } else if (keyword == "solid") {
        solids_.begin(mesh_.triangles.size(), cursor_.rest_of_line());
      } else if (keyword != "facet" && keyword != "outer" && keyword != "endloop" && keyword != "endsolid") {
        return error("is not understood");
      }
    }
    if (!corners_.empty()) return error("the file ends within a facet");
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
    corners_.push_back(welder_.vertex(x));
    return {};
  }

  Result<void> end_facet() {
    if (corners_.size() != 3) return error(fmt::format("facet has {} vertices", corners_.size()));
    mesh_.triangles.push_back({corners_[0], corners_[1], corners_[2]});
    corners_.clear();
    return {};
  }

  const std::string& path_;
  TextCursor cursor_;
  MeshData mesh_;
  Welder welder_{mesh_};
  NameRuns solids_;
  std::vector<Index> corners_;
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
