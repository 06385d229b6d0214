// A motion and its answer for ParaView: a VTK XML polygon file per step, and the collection that assigns them
// times.
#include <fmt/format.h>

#include <algorithm>
#include <deque>
#include <filesystem>
#include <limits>
#include <optional>
#include <system_error>

#include "base/try.h"
#include "io/bytes.h"
#include "io/new_directory.h"
#include "report/joined.h"
#include "report/text_file.h"

namespace foldproof {
namespace {

namespace fs = std::filesystem;
using io::bytes_of;
using io::NewDirectory;

std::string xml_text(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '&') {
      out += "&amp;";
    } else if (c == '<') {
      out += "&lt;";
    } else if (c == '"') {
      out += "&quot;";
    } else {
      out += c;
    }
  }
  return out;
}

/// An array of a file, and the XML element that it belongs to.
struct Array {
  const char *section, *type, *name;
  int components;
  std::span<const char> bytes;
};

/// The XML elements that declare arrays; those of a section are consecutive. `offset`: byte offset of the
/// first array's data; advances past them all.
std::string declare(std::span<const Array> arrays, std::uint64_t& offset) {
  std::string xml;
  std::string_view section;
  for (const Array& a : arrays) {
    if (section != a.section) {
      if (!section.empty()) xml += fmt::format("</{}>\n", section);
      section = a.section;
      xml += fmt::format("<{}>\n", section);
    }
    // Only field data needs an explicit length, which is 1 here.
    xml += fmt::format(
        "<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\"{} format=\"appended\" "
        "offset=\"{}\"/>\n",
        a.type, a.name, a.components, section == "FieldData" ? " NumberOfTuples=\"1\"" : "", offset);
    offset += sizeof(std::uint64_t) + a.bytes.size();
  }
  return xml + fmt::format("</{}>\n", section);
}

struct Mesh {
  std::size_t points, polygons, lines, verts;
  std::span<const Array> fields, arrays;
};

/// Writes the arrays as raw bytes after the XML, each preceded by its size: VTK's "appended data", the only
/// encoding that neither enlarges the file nor needs a decoder.
Result<void> write_vtp(const std::string& path, const Mesh& mesh) {
  auto file = FOLDPROOF_TRY(FileWriter::open(path));
  std::uint64_t offset = 0;
  std::string xml =
      "<?xml version=\"1.0\"?>\n"
      "<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n"
      "<PolyData>\n";
  xml += declare(mesh.fields, offset);
  xml += fmt::format("<Piece NumberOfPoints=\"{}\" NumberOfPolys=\"{}\"", mesh.points, mesh.polygons);
  if (mesh.lines > 0) xml += fmt::format(" NumberOfLines=\"{}\"", mesh.lines);
  if (mesh.verts > 0) xml += fmt::format(" NumberOfVerts=\"{}\"", mesh.verts);
  xml += ">\n";
  xml += declare(mesh.arrays, offset);
  xml += "</Piece>\n</PolyData>\n<AppendedData encoding=\"raw\">\n_";
  FOLDPROOF_TRY(file.write(xml));
  for (const auto& arrays : {mesh.fields, mesh.arrays}) {
    for (const Array& a : arrays) {
      const std::array<std::uint64_t, 1> size{a.bytes.size()};
      FOLDPROOF_TRY(file.write(bytes_of(size)));
      FOLDPROOF_TRY(file.write(a.bytes));
    }
  }
  FOLDPROOF_TRY(file.write(std::string("\n</AppendedData>\n</VTKFile>\n")));
  return file.commit();
}

/// Error: the directory has files that this program did not write.
Result<void> require_ours(const fs::path& directory) {
  std::error_code code;
  if (!fs::exists(directory, code)) return {};
  bool ours = fs::is_directory(directory, code);
  for (const auto& entry : fs::directory_iterator(directory, code))
    ours = ours && entry.path().extension() == ".vtp";
  if (ours && !code) return {};
  return fail(
      ErrorCode::FileAccess, "--vtk",
      fmt::format("'{}' is there already and holds other things than .vtp files", directory.generic_string()),
      "choose another name, or move that away");
}

/// A value for the whole step, as an array of one element.
template <class T>
using One = std::array<T, 1>;

class VtkReport : public ReportWriter {
 public:
  VtkReport(TextFile collection, NewDirectory directory, std::string folder, Motions motions,
            JoinedMesh joined, Index substeps)
      : collection_(std::move(collection)),
        directory_(std::move(directory)),
        folder_(std::move(folder)),
        motions_(motions),
        joined_(std::move(joined)),
        substeps_(substeps) {
    const Topology& topology = joined_.topology;
    for (std::size_t i = 0; i < motions.size(); ++i)
      object_.insert(object_.end(), motions[i]->topology().vertex_count(), static_cast<std::int32_t>(i));
    for (std::int32_t i = 0; i < static_cast<std::int32_t>(topology.face_count()); ++i)
      polygon_ends_.push_back(3 * i + 3);
    lines_ = topology.lines();
    points_ = topology.points();
    for (std::int32_t i = 0; i < static_cast<std::int32_t>(lines_.size()); ++i)
      line_ends_.push_back(2 * i + 2);
    for (std::int32_t i = 0; i < static_cast<std::int32_t>(points_.size()); ++i) point_ends_.push_back(i + 1);
    collection_.add(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">\n"
        "<Collection>\n");
  }

  Result<void> start(const CheckedStep& pose) override {
    now_.update(joined_, motions_, pose);
    return {};
  }

  Result<void> step(const CheckedStep& step) override {
    if (step.pose) now_.update(joined_, motions_, step);
    if (now_.inside.empty()) now_.inside.assign(joined_.topology.triangles().size(), 0);  // not tested
    describe(step);
    FOLDPROOF_TRY(write(step));
    if (step.index.next_frame == step.index.frame) return {};
    now_.update(joined_, motions_, step);  // the next step's first pose
    last_ = step.index;
    return {};
  }

  /// The collection comes last, so that the files it refers to exist.
  Result<void> finish(const CheckTotals&) override {
    if (last_) FOLDPROOF_TRY(write_last_pose());
    collection_.add("</Collection>\n</VTKFile>\n");
    FOLDPROOF_TRY(directory_.replace());
    return collection_.commit();
  }

 private:
  void describe(const CheckedStep& step) {
    joined_.pose(step, 0, positions_);
    mark_meeting(joined_, motions_, step, meets_);
    joined_.pose(step, 1, end_);
    displacement_.resize(end_.size());
    for (std::size_t k = 0; k < end_.size(); ++k) displacement_[k] = end_[k] - positions_[k];
  }

  /// The pose at the end of the last step, from which no step begins.
  Result<void> write_last_pose() {
    positions_ = end_;
    std::fill(displacement_.begin(), displacement_.end(), 0.0);
    std::fill(meets_.begin(), meets_.end(), std::uint8_t{0});
    const StepResult nothing;
    CheckedStep none;
    none.step = &nothing;
    none.index = {last_->number + 1, last_->next_frame, last_->next_frame, 0};
    none.earliest_toi = 1;
    return write(none);
  }

  /// Values per triangle as VTK numbers its cells: points, lines, faces. `copy` holds them where they are not
  /// in this order.
  template <class T>
  std::span<const char> in_vtk_order(const std::vector<T>& values, std::vector<char>& copy) const {
    const auto all = bytes_of(values);
    const std::size_t faces = sizeof(T) * joined_.topology.face_count(), lines = sizeof(T) * lines_.size();
    if (all.size() == faces) return all;
    for (const auto& part : {all.subspan(faces + lines), all.subspan(faces, lines), all.first(faces)})
      copy.insert(copy.end(), part.begin(), part.end());
    return copy;
  }

  /// Writes what is described, and adds it to the collection.
  Result<void> write(const CheckedStep& step) {
    const StepIndex& index = step.index;
    const Topology& topology = joined_.topology;
    const One<std::int32_t> frame{static_cast<std::int32_t>(index.frame)};
    const One<std::int32_t> substep{static_cast<std::int32_t>(index.substep)};
    const One<std::uint64_t> collisions{step.collisions.sum()}, listed{step.listed().sum()};
    const One<double> toi{step.earliest_toi};
    const std::array<Array, 5> fields{{
        {"FieldData", "Int32", "frame", 1, bytes_of(frame)},
        {"FieldData", "Int32", "substep", 1, bytes_of(substep)},
        {"FieldData", "UInt64", "collisions", 1, bytes_of(collisions)},
        {"FieldData", "UInt64", "listed", 1, bytes_of(listed)},
        {"FieldData", "Float64", "earliest_toi", 1, bytes_of(toi)},
    }};
    std::vector<Array> arrays{
        {"PointData", "Int32", "object", 1, bytes_of(object_)},
        {"PointData", "Float64", "displacement", 3, bytes_of(displacement_)},
    };
    std::deque<std::vector<char>> cells;
    const auto add_cells = [&](const char* type, const char* array, const auto& values) {
      arrays.push_back({"CellData", type, array, 1, in_vtk_order(values, cells.emplace_back())});
    };
    add_cells("UInt8", "collides", now_.inside);
    add_cells("UInt8", "meets", meets_);
    if (!now_.number.empty()) {
      add_cells("Int32", "contact", now_.number);
      add_cells("Float32", "contact_depth", now_.depth);
    }
    arrays.push_back({"Points", "Float64", "Points", 3, bytes_of(positions_)});
    const auto add_topology = [&](const char* section, std::span<const char> corners, const auto& ends) {
      if (ends.empty()) return;
      arrays.push_back({section, "Int32", "connectivity", 1, corners});
      arrays.push_back({section, "Int32", "offsets", 1, bytes_of(ends)});
    };
    add_topology("Verts", bytes_of(points_), point_ends_);
    add_topology("Lines", bytes_of(lines_), line_ends_);
    add_topology("Polys", bytes_of(topology.faces()), polygon_ends_);
    const std::string name = fmt::format("step{:06}.vtp", index.number);
    FOLDPROOF_TRY(write_vtp(
        (directory_.path() / name).generic_string(),
        {topology.vertex_count(), topology.face_count(), lines_.size(), points_.size(), fields, arrays}));
    const double part = static_cast<double>(index.substep) / substeps_;
    collection_.add("<DataSet timestep=\"{}\" part=\"0\" file=\"{}/{}\"/>\n",
                    index.frame + part * (index.next_frame - index.frame), folder_, name);
    return collection_.flush_if_large();
  }

  TextFile collection_;
  NewDirectory directory_;
  std::string folder_;  // escaped for XML
  Motions motions_;
  JoinedMesh joined_;
  Index substeps_;
  std::vector<Edge> lines_;
  std::vector<Index> points_;
  std::vector<std::int32_t> object_, polygon_ends_, line_ends_, point_ends_;
  std::vector<double> positions_, end_, displacement_;  // of the step
  std::optional<StepIndex> last_;                       // the last step with motion
  InsideMarks now_;                                     // of the frame at which the next step starts
  std::vector<std::uint8_t> meets_;
};

}  // namespace

Result<std::unique_ptr<ReportWriter>> vtk_report(const std::string& path, Motions motions,
                                                 const CheckSettings& settings) {
  if (extension_of(path) != ".pvd") {
    return fail(ErrorCode::InvalidArgument, "--vtk", fmt::format("'{}' does not end in .pvd", path),
                "name a file that does, as ParaView expects; the meshes go into a directory beside it");
  }
  auto joined = FOLDPROOF_TRY(join(motions, "--vtk"));
  // Signed 32-bit integers count the corners, which halves the files.
  constexpr std::size_t kMax = std::numeric_limits<std::int32_t>::max();
  if (joined.topology.triangles().size() > kMax / 3 || joined.topology.vertex_count() > kMax) {
    return fail(ErrorCode::LimitExceeded, "--vtk", "all objects together are too large for one mesh",
                "check fewer objects at a time");
  }
  auto collection = FOLDPROOF_TRY(FileWriter::open(path));
  const fs::path target = fs::path(path).replace_extension();
  FOLDPROOF_TRY(require_ours(target));
  auto directory = FOLDPROOF_TRY(NewDirectory::open(target));
  return std::make_unique<VtkReport>(TextFile(std::move(collection)), std::move(directory),
                                     xml_text(fs::path(path).stem().generic_string()), motions,
                                     std::move(joined), settings.substeps);
}

}  // namespace foldproof
