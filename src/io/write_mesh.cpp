// Writes PLY with face properties, and OBJ with PC2 or MDD.
#include <fmt/format.h>

#include <cmath>

#include "base/try.h"
#include "io/bytes.h"
#include "io/readers.h"
#include "io/write_times.h"

namespace foldproof {
namespace {

using io::append;

// Most programs use signed 32-bit counts and indices; PC2 has no others.
constexpr Index kMaxSigned = 0x7fffffff;

std::vector<char> pc2_header(const Motion& motion) {
  std::vector<char> bytes;
  for (const char c : std::string_view("POINTCACHE2\0", 12)) bytes.push_back(c);
  append<std::int32_t>(bytes, 1);
  append<std::int32_t>(bytes, static_cast<std::int32_t>(motion.topology().vertex_count()));
  append<float>(bytes, 0);  // first frame
  append<float>(bytes, 1);  // frames between samples
  append<std::int32_t>(bytes, static_cast<std::int32_t>(motion.frame_count()));
  return bytes;
}

std::vector<char> mdd_header(const Motion& motion, std::span<const double> seconds) {
  std::vector<char> bytes;
  append(bytes, static_cast<std::int32_t>(motion.frame_count()), std::endian::big);
  append(bytes, static_cast<std::int32_t>(motion.topology().vertex_count()), std::endian::big);
  for (const double time : seconds) append(bytes, static_cast<float>(time), std::endian::big);
  return bytes;
}

Result<void> write_obj_text(FileWriter& file, const Topology& topology, std::span<const double> positions) {
  std::string text;
  // fmt's default is the shortest text that reads back as the same double.
  for (std::size_t i = 0; i + 2 < positions.size(); i += 3) {
    text += fmt::format("v {} {} {}\n", positions[i], positions[i + 1], positions[i + 2]);
  }
  for (const Triangle& t : topology.faces())
    text += fmt::format("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
  for (const auto& [a, b] : topology.lines()) text += fmt::format("l {} {}\n", a + 1, b + 1);
  for (const Index p : topology.points()) text += fmt::format("p {}\n", p + 1);
  return file.write(text);
}

// Writes the mesh, and all frames as 32-bit floats after a header.
Result<void> write_cache(const std::string& obj_path, const std::string& path, Motion& motion,
                         std::vector<char> bytes, std::endian order) {
  if (motion.topology().vertex_count() > kMaxSigned || motion.frame_count() > kMaxSigned) {
    return fail(ErrorCode::LimitExceeded, path,
                "the motion has more vertices or frames than a point cache can count", "write NPZ instead");
  }
  auto obj = FOLDPROOF_TRY(FileWriter::open(obj_path));
  auto cache = FOLDPROOF_TRY(FileWriter::open(path));
  std::vector<double> positions(std::size_t{3} * motion.topology().vertex_count());
  for (Index k = 0; k < motion.frame_count(); ++k) {
    FOLDPROOF_TRY(motion.read_frame(k, positions));
    if (k == 0) FOLDPROOF_TRY(write_obj_text(obj, motion.topology(), positions));
    for (std::size_t i = 0; i < positions.size(); ++i) {
      const auto narrow = static_cast<float>(positions[i]);
      if (!std::isfinite(narrow)) {
        return fail(ErrorCode::LimitExceeded, fmt::format("{}, frame {}, vertex {}", path, k, i / 3),
                    fmt::format("a coordinate is too large for {}, which holds 32-bit floats",
                                order == std::endian::big ? "MDD" : "PC2"),
                    "write NPZ instead");
      }
      append(bytes, narrow, order);
    }
    FOLDPROOF_TRY(cache.write(bytes));
    bytes.clear();
  }
  FOLDPROOF_TRY(cache.commit());
  return obj.commit();
}

Result<void> require_sizes(const std::string& path, const Topology& topology,
                           std::span<const double> positions, std::span<const FaceProperty> properties) {
  const std::size_t vertices = topology.vertex_count(), triangles = topology.triangles().size();
  const auto wrong = [&](const std::string& given) {
    return fail(ErrorCode::InvalidArgument, path,
                fmt::format("a mesh of {} vertices and {} triangles is to be written from {}", vertices,
                            triangles, given),
                "pass three numbers a vertex and one value a triangle");
  };
  if (positions.size() != 3 * vertices) return wrong(fmt::format("{} numbers", positions.size()));
  for (const FaceProperty& p : properties) {
    const std::size_t count = std::visit([](const auto& values) { return values.size(); }, p.values);
    if (count != triangles) return wrong(fmt::format("{} values of '{}'", count, p.name));
  }
  return {};
}

const char* ply_name(const FaceProperty& property) {
  static constexpr std::array<const char*, 3> kTypes{"uchar", "int", "float"};  // in variant's order
  return kTypes[property.values.index()];
}

}  // namespace

Result<void> write_ply(const std::string& path, const Topology& topology, std::span<const double> positions,
                       std::span<const std::uint8_t> marks) {
  const FaceProperty mark{"mark", marks};
  return write_ply_properties(path, topology, positions, std::span(&mark, marks.empty() ? 0 : 1));
}

Result<void> write_ply_properties(const std::string& path, const Topology& topology,
                                  std::span<const double> positions,
                                  std::span<const FaceProperty> properties) {
  const auto triangles = topology.triangles();
  const std::size_t faces = topology.face_count(), lines = topology.line_count();
  FOLDPROOF_TRY(require_sizes(path, topology, positions, properties));
  auto file = FOLDPROOF_TRY(FileWriter::open(path));
  const char* id_type = topology.vertex_count() <= kMaxSigned ? "int" : "uint";
  std::string header = fmt::format(
      "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty double x\nproperty double y\n"
      "property double z\nelement face {}\nproperty list uchar {} vertex_indices\n",
      topology.vertex_count(), faces, id_type);
  const auto declare_properties = [&] {
    for (const FaceProperty& p : properties) header += fmt::format("property {} {}\n", ply_name(p), p.name);
  };
  declare_properties();
  if (lines > 0) {
    header +=
        fmt::format("element edge {}\nproperty {} vertex1\nproperty {} vertex2\n", lines, id_type, id_type);
    declare_properties();
  }
  FOLDPROOF_TRY(file.write(header + "end_header\n"));
  std::vector<char> bytes;
  for (const double x : positions) append(bytes, x);
  FOLDPROOF_TRY(file.write(bytes));
  bytes.clear();
  for (std::size_t i = 0; i < faces + lines; ++i) {
    if (i < faces) bytes.push_back(3);
    for (const Index v : std::span(triangles[i]).first(i < faces ? 3 : 2)) append(bytes, v);
    for (const FaceProperty& p : properties)
      std::visit([&](const auto& values) { append(bytes, values[i]); }, p.values);
  }
  FOLDPROOF_TRY(file.write(bytes));
  return file.commit();
}

Result<void> write_obj(const std::string& path, const Topology& topology, std::span<const double> positions) {
  FOLDPROOF_TRY(require_sizes(path, topology, positions, {}));
  auto file = FOLDPROOF_TRY(FileWriter::open(path));
  FOLDPROOF_TRY(write_obj_text(file, topology, positions));
  return file.commit();
}

Result<void> write_obj_pc2(const std::string& obj_path, const std::string& pc2_path, Motion& motion) {
  return write_cache(obj_path, pc2_path, motion, pc2_header(motion), std::endian::little);
}

Result<void> io::write_obj_mdd(const std::string& obj_path, const std::string& mdd_path, Motion& motion,
                               std::span<const double> seconds) {
  return write_cache(obj_path, mdd_path, motion, mdd_header(motion, seconds), std::endian::big);
}

}  // namespace foldproof
