// Writes a motion as NPZ: stored members, streamed.
#include "io/write_times.h"

#include "base/try.h"
#include "io/bytes.h"
#include "io/npy.h"
#include "io/zip_writer.h"

namespace foldproof {
namespace {

using io::append;
using io::ZipWriter;

Result<void> write_faces(ZipWriter& zip, const Topology& topology) {
  const auto triangles = topology.faces();
  const std::array<std::uint64_t, 2> shape{triangles.size(), 3};
  const std::string header = io::npy_header("<i4", shape);
  std::vector<char> bytes(header.begin(), header.end());
  for (const Triangle& t : triangles) {
    for (const Index v : t) append(bytes, static_cast<std::int32_t>(v));
  }
  FOLDPROOF_TRY(zip.begin("faces.npy", bytes.size()));
  FOLDPROOF_TRY(zip.data(bytes));
  return zip.end();
}

Result<void> write_times(ZipWriter& zip, std::span<const double> times) {
  if (times.empty()) return {};
  const std::array<std::uint64_t, 1> shape{times.size()};
  const std::string header = io::npy_header("<f8", shape);
  std::vector<char> bytes(header.begin(), header.end());
  for (const double time : times) append(bytes, time);
  FOLDPROOF_TRY(zip.begin("times.npy", bytes.size()));
  FOLDPROOF_TRY(zip.data(bytes));
  return zip.end();
}

Result<void> write_vertices(ZipWriter& zip, Motion& motion) {
  const std::array<std::uint64_t, 3> shape{motion.frame_count(), motion.topology().vertex_count(), 3};
  const std::string header = io::npy_header("<f8", shape);
  std::vector<char> bytes(header.begin(), header.end());
  const std::uint64_t size = header.size() + shape[0] * shape[1] * shape[2] * sizeof(double);
  FOLDPROOF_TRY(zip.begin("vertices.npy", size));
  std::vector<double> positions(std::size_t{3} * motion.topology().vertex_count());
  for (Index k = 0; k < motion.frame_count(); ++k) {
    FOLDPROOF_TRY(motion.read_frame(k, positions));
    for (const double x : positions) append(bytes, x);
    FOLDPROOF_TRY(zip.data(bytes));
    bytes.clear();
  }
  return zip.end();
}

}  // namespace

Result<void> io::write_npz(const std::string& path, Motion& motion, std::span<const double> times) {
  if (motion.topology().vertex_count() > 0x7fffffff) {
    return fail(ErrorCode::LimitExceeded, path, "the motion has more vertices than int32 can count",
                "split the mesh");
  }
  if (motion.topology().face_count() < motion.topology().triangles().size()) {
    return fail(ErrorCode::UnsupportedFormat, path,
                "is NPZ, which holds faces alone, and there are lines or points", "name it .obj");
  }
  auto file = FOLDPROOF_TRY(FileWriter::open(path));
  ZipWriter zip(file);
  FOLDPROOF_TRY(write_faces(zip, motion.topology()));
  FOLDPROOF_TRY(write_vertices(zip, motion));
  FOLDPROOF_TRY(write_times(zip, times));
  FOLDPROOF_TRY(zip.finish());
  return file.commit();
}

Result<void> write_npz(const std::string& path, Motion& motion) { return io::write_npz(path, motion, {}); }

}  // namespace foldproof
