// A motion as NPZ: two stored members, streamed.
#include "io/bytes.h"
#include "io/npy.h"
#include "io/zip_writer.h"

#include "foldproof/io.h"

namespace foldproof {
namespace {

using io::append;
using io::ZipWriter;

Result<void> write_faces(ZipWriter& zip, const Topology& topology) {
  const auto triangles = topology.triangles();
  const std::array<std::uint64_t, 2> shape{triangles.size(), 3};
  const std::string header = io::npy_header("<i4", shape);
  std::vector<char> bytes(header.begin(), header.end());
  for (const Triangle& t : triangles) {
    for (const Index v : t) append(bytes, static_cast<std::int32_t>(v));
  }
  if (auto begun = zip.begin("faces.npy", bytes.size()); !begun) return begun;
  if (auto written = zip.data(bytes); !written) return written;
  return zip.end();
}

Result<void> write_vertices(ZipWriter& zip, Motion& motion) {
  const std::array<std::uint64_t, 3> shape{motion.frame_count(), motion.topology().vertex_count(), 3};
  const std::string header = io::npy_header("<f8", shape);
  std::vector<char> bytes(header.begin(), header.end());
  const std::uint64_t size = header.size() + shape[0] * shape[1] * shape[2] * sizeof(double);
  if (auto begun = zip.begin("vertices.npy", size); !begun) return begun;
  std::vector<double> positions(std::size_t{3} * motion.topology().vertex_count());
  for (Index k = 0; k < motion.frame_count(); ++k) {
    if (auto read = motion.read_frame(k, positions); !read) return read;
    for (const double x : positions) append(bytes, x);
    if (auto written = zip.data(bytes); !written) return written;
    bytes.clear();
  }
  return zip.end();
}

}  // namespace

Result<void> write_npz(const std::string& path, Motion& motion) {
  if (motion.topology().vertex_count() > 0x7fffffff) {
    return fail(path, "the motion has more vertices than int32 can count", "split the mesh");
  }
  auto file = FileWriter::open(path);
  if (!file) return tl::unexpected(file.error());
  ZipWriter zip(*file);
  if (auto written = write_faces(zip, motion.topology()); !written) return written;
  if (auto written = write_vertices(zip, motion); !written) return written;
  if (auto finished = zip.finish(); !finished) return finished;
  return file->commit();
}

}  // namespace foldproof
