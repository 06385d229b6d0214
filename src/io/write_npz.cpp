// NPZ writer: two stored members, streamed. libzip can only write files of its own naming, and would bypass
// FileWriter.
#include <fmt/format.h>
#include <zlib.h>

#include "io/bytes.h"
#include "io/npy.h"

#include "foldproof/io.h"

namespace foldproof {
namespace {

using io::append;

struct Member {
  std::string name;
  std::uint64_t offset = 0;  ///< Of its local header.
  std::uint64_t bytes = 0;
  std::uint32_t crc = 0;
};

constexpr std::uint16_t kZip64Version = 45;
constexpr std::uint32_t kSeeZip64 = 0xffffffff;
constexpr std::uint64_t kCrcInLocalHeader = 14;  // bytes from the start of the local header

/// A stored ZIP archive, written front to back. Always in the 64-bit form, so that there is one form to test.
class ZipWriter {
 public:
  explicit ZipWriter(FileWriter& file) : file_(file) {}

  Result<void> begin(std::string name, std::uint64_t bytes) {
    members_.push_back({std::move(name), at_, bytes, 0});
    std::vector<char> header;
    append<std::uint32_t>(header, 0x04034b50);
    append_common(header, members_.back());
    append<std::uint16_t>(header, 20);  // size of the extra field
    append_name(header, members_.back());
    append<std::uint16_t>(header, 1);  // the extra field: 64-bit sizes
    append<std::uint16_t>(header, 16);
    append(header, bytes);
    append(header, bytes);
    return put(header);
  }

  Result<void> data(std::span<const char> bytes) {
    std::uint32_t& crc = members_.back().crc;
    for (std::size_t done = 0; done < bytes.size();) {
      const std::size_t count = std::min<std::size_t>(bytes.size() - done, std::size_t{1} << 30);
      crc = static_cast<std::uint32_t>(
          crc32(crc, reinterpret_cast<const Bytef*>(bytes.data() + done), static_cast<uInt>(count)));
      done += count;
    }
    return put(bytes);
  }

  /// The checksum is known only now.
  Result<void> end() {
    std::vector<char> crc;
    append(crc, members_.back().crc);
    return file_.rewrite(members_.back().offset + kCrcInLocalHeader, crc);
  }

  Result<void> finish() {
    const std::uint64_t start = at_;
    std::vector<char> directory;
    for (const Member& member : members_) {
      append<std::uint32_t>(directory, 0x02014b50);
      append(directory, kZip64Version);
      append_common(directory, member);
      append<std::uint16_t>(directory, 28);  // size of the extra field
      append<std::uint16_t>(directory, 0);   // comment
      append<std::uint16_t>(directory, 0);   // disk
      append<std::uint16_t>(directory, 0);   // attributes
      append<std::uint32_t>(directory, 0);
      append(directory, kSeeZip64);  // offset
      append_name(directory, member);
      append<std::uint16_t>(directory, 1);
      append<std::uint16_t>(directory, 24);
      append(directory, member.bytes);
      append(directory, member.bytes);
      append(directory, member.offset);
    }
    const std::uint64_t size = directory.size(), count = members_.size();
    append<std::uint32_t>(directory, 0x06064b50);  // end of the directory, 64-bit form
    append<std::uint64_t>(directory, 44);
    append(directory, kZip64Version);
    append(directory, kZip64Version);
    append<std::uint64_t>(directory, 0);  // disks
    append(directory, count);
    append(directory, count);
    append(directory, size);
    append(directory, start);
    append<std::uint32_t>(directory, 0x07064b50);  // where that end is
    append<std::uint32_t>(directory, 0);
    append<std::uint64_t>(directory, start + size);
    append<std::uint32_t>(directory, 1);
    append<std::uint32_t>(directory, 0x06054b50);  // end of the directory, 32-bit form: look above
    append<std::uint32_t>(directory, 0);
    append<std::uint32_t>(directory, kSeeZip64);  // both counts
    append(directory, kSeeZip64);
    append(directory, kSeeZip64);
    append<std::uint16_t>(directory, 0);
    return put(directory);
  }

 private:
  // Fields that the local header and the directory have in common, up to the length of the name.
  static void append_common(std::vector<char>& bytes, const Member& member) {
    append(bytes, kZip64Version);
    append<std::uint16_t>(bytes, 0);       // flags
    append<std::uint16_t>(bytes, 0);       // stored
    append<std::uint16_t>(bytes, 0);       // time
    append<std::uint16_t>(bytes, 0x0021);  // 1980-01-01: the same motion gives the same file
    append(bytes, member.crc);
    append(bytes, kSeeZip64);
    append(bytes, kSeeZip64);
    append(bytes, static_cast<std::uint16_t>(member.name.size()));
  }
  static void append_name(std::vector<char>& bytes, const Member& member) {
    bytes.insert(bytes.end(), member.name.begin(), member.name.end());
  }
  Result<void> put(std::span<const char> bytes) {
    at_ += bytes.size();
    return file_.write(bytes);
  }

  FileWriter& file_;
  std::uint64_t at_ = 0;
  std::vector<Member> members_;
};

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
