// VTK's XML files as ParaView writes them: polygons, cells, and collections of them over time. A reader of
// our own over pugixml: VTK's aborts or warns on damaged files and brings dozens of libraries.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <optional>

#include "base/try.h"
#include "io/cells.h"
#include "io/parts.h"
#include "io/text.h"
#include "io/vtk_file.h"

namespace foldproof::io {
namespace {

namespace fs = std::filesystem;
using pugi::xml_node;

class VtkMesh {
 public:
  explicit VtkMesh(VtkFile file) : file_(std::move(file)) {}

  Result<MeshData> read() {
    for (const xml_node piece : file_.content().children("Piece")) {
      FOLDPROOF_TRY(read_piece(piece));
    }
    const std::vector<std::int64_t> parts = cells_.finish();
    mesh_.parts = parts_by_number(part_kind_, parts);
    return std::move(mesh_);
  }

 private:
  static xml_node array(xml_node section, const char* name) {
    return section.find_child_by_attribute("DataArray", "Name", name);
  }

  /// What a section of the piece holds, by the piece's attribute, which may be absent only with the section.
  Result<std::uint64_t> count(xml_node piece, const char* section) const {
    const std::string attribute = fmt::format("NumberOf{}", section);
    if (*piece.attribute(attribute.c_str()).value() == '\0' && piece.child(section).child("DataArray"))
      return file_.error(piece, fmt::format("has {}, but no {}", section, attribute));
    return file_.count(piece, attribute.c_str());
  }

  Result<void> read_piece(xml_node piece) {
    const std::uint64_t points = FOLDPROOF_TRY(count(piece, "Points"));
    first_vertex_ = mesh_.vertex_count();
    if (points > kMaxVertices - first_vertex_) return file_.error(piece, "has too many points");
    vertex_count_ = static_cast<Index>(points);
    if (points > 0) {
      const xml_node coordinates = piece.child("Points").child("DataArray");
      const auto positions = FOLDPROOF_TRY(file_.values<double>(coordinates));
      if (positions.size() != 3 * points)
        return file_.error(coordinates,
                           fmt::format("has {} numbers for {} points", positions.size(), points));
      FOLDPROOF_TRY(check_finite(file_.path(), positions));
      mesh_.positions.insert(mesh_.positions.end(), positions.begin(), positions.end());
    }
    FOLDPROOF_TRY(read_labels(piece.child("CellData")));
    std::uint64_t first_cell = 0;
    for (const auto& [section, type] :
         {std::pair("Verts", 2), std::pair("Lines", 4), std::pair("Polys", 7), std::pair("Strips", 6)}) {
      const std::uint64_t cells = FOLDPROOF_TRY(count(piece, section));
      if (cells == 0) continue;
      FOLDPROOF_TRY(read_cells(piece.child(section), cells, first_cell, type));
      first_cell += cells;
    }
    const std::uint64_t cells = FOLDPROOF_TRY(count(piece, "Cells"));
    return cells == 0 ? Result<void>() : read_cells(piece.child("Cells"), cells, 0, std::nullopt);
  }

  // The first array of integers whose name says that it names parts.
  Result<void> read_labels(xml_node cell_data) {
    labels_.clear();
    for (const xml_node data : cell_data.children("DataArray")) {
      const std::string_view kind = part_kind(data.attribute("Name").value());
      if (kind.empty() || std::string_view(data.attribute("type").value()).starts_with("Float")) continue;
      labels_ = FOLDPROOF_TRY(file_.values<std::int64_t>(data));
      part_kind_ = kind;
      return {};
    }
    return {};
  }

  /// `type`: of all cells; none: the file says it for each.
  Result<void> read_cells(xml_node section, std::uint64_t count, std::uint64_t first_cell,
                          std::optional<std::int64_t> type) {
    VtkCells cells;
    cells.ends = FOLDPROOF_TRY(file_.values<std::int64_t>(array(section, "offsets")));
    cells.ids = FOLDPROOF_TRY(file_.values<std::int64_t>(array(section, "connectivity")));
    if (type) {
      cells.types.assign(cells.ends.size(), *type);
    } else {
      cells.types = FOLDPROOF_TRY(file_.values<std::int64_t>(array(section, "types")));
    }
    if (cells.ends.size() != count || cells.types.size() != count)
      return file_.error(section, fmt::format("has {} offsets for {} cells", cells.ends.size(), count));
    const auto labels = std::span(labels_).subspan(std::min<std::uint64_t>(first_cell, labels_.size()));
    if (std::string problem = cells_.add(cells, {first_vertex_, vertex_count_}, labels); !problem.empty())
      return file_.error(section, std::move(problem));
    return {};
  }

  VtkFile file_;
  MeshData mesh_;
  CellCollector cells_{mesh_};
  Index first_vertex_ = 0, vertex_count_ = 0;  // of the piece
  std::string_view part_kind_;
  std::vector<std::int64_t> labels_;  // per cell of the piece
};

}  // namespace

Result<MeshData> parse_vtp(const std::string& path, std::string_view bytes) {
  return VtkMesh(FOLDPROOF_TRY(VtkFile::parse(path, bytes, "PolyData"))).read();
}

Result<MeshData> parse_vtu(const std::string& path, std::string_view bytes) {
  return VtkMesh(FOLDPROOF_TRY(VtkFile::parse(path, bytes, "UnstructuredGrid"))).read();
}

Result<std::vector<std::string>> pvd_files(const std::string& path) {
  const auto bytes = FOLDPROOF_TRY(read_file(path));
  const auto file = FOLDPROOF_TRY(VtkFile::parse(path, {bytes.data(), bytes.size()}, "Collection"));
  std::vector<std::pair<double, std::string>> frames;
  for (const xml_node set : file.content().children("DataSet")) {
    const fs::path name = set.attribute("file").value();
    const auto leaves = [](const fs::path& part) { return part == ".."; };
    if (name.empty() || name.has_root_path() || std::ranges::any_of(name, leaves)) {
      return fail(ErrorCode::InvalidFile, path,
                  fmt::format("refers to '{}', which is not below its directory", name.generic_string()),
                  "keep the files of a collection beside it");
    }
    TextCursor text(set.attribute("timestep").as_string("0"), {.comment = '\0', .continuation = false});
    double time = 0;
    if (text.number(time) != Scan::Ok || text.skip_to_content()) {
      return fail(ErrorCode::InvalidFile, path,
                  fmt::format("the time of '{}' is not a finite number", name.generic_string()),
                  "write the file again");
    }
    frames.emplace_back(time, (fs::path(path).parent_path() / name).generic_string());
  }
  std::ranges::stable_sort(frames, {}, &std::pair<double, std::string>::first);
  std::vector<std::string> files;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (i > 0 && frames[i].first == frames[i - 1].first) {
      return fail(ErrorCode::UnsupportedFormat, path,
                  fmt::format("has several parts at time {}", frames[i].first),
                  "append them into one data set in ParaView and save that");
    }
    files.push_back(frames[i].second);
  }
  if (files.empty()) return fail(ErrorCode::InvalidFile, path, "refers to no files", "write the file again");
  return files;
}

Result<std::unique_ptr<Motion>> open_pvd(const std::string& path, const ReadProgress& progress) {
  return open_sequence(path, FOLDPROOF_TRY(pvd_files(path)), progress);
}

}  // namespace foldproof::io
