#include "io/zip_writer.h"

#include <zlib.h>

#include "io/bytes.h"

namespace foldproof::io {
namespace {

constexpr std::uint16_t kZip64Version = 45;
constexpr std::uint32_t kSeeZip64 = 0xffffffff;
constexpr std::uint64_t kCrcInLocalHeader = 14;  // byte offset from the start of the local header

}  // namespace

Result<void> ZipWriter::begin(std::string name, std::uint64_t bytes) {
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

Result<void> ZipWriter::data(std::span<const char> bytes) {
  std::uint32_t& crc = members_.back().crc;
  for (std::size_t done = 0; done < bytes.size();) {
    const std::size_t count = std::min<std::size_t>(bytes.size() - done, std::size_t{1} << 30);
    crc = static_cast<std::uint32_t>(
        crc32(crc, reinterpret_cast<const Bytef*>(bytes.data() + done), static_cast<uInt>(count)));
    done += count;
  }
  return put(bytes);
}

// The checksum is known only now.
Result<void> ZipWriter::end() {
  std::vector<char> crc;
  append(crc, members_.back().crc);
  return file_.rewrite(members_.back().offset + kCrcInLocalHeader, crc);
}

Result<void> ZipWriter::finish() {
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
  append<std::uint32_t>(directory, 0x07064b50);  // locator of that record
  append<std::uint32_t>(directory, 0);
  append<std::uint64_t>(directory, start + size);
  append<std::uint32_t>(directory, 1);
  append<std::uint32_t>(directory, 0x06054b50);  // end of the directory, 32-bit form: refers to the above
  append<std::uint32_t>(directory, 0);
  append<std::uint32_t>(directory, kSeeZip64);  // both counts
  append(directory, kSeeZip64);
  append(directory, kSeeZip64);
  append<std::uint16_t>(directory, 0);
  return put(directory);
}

// Fields common to the local header and the directory, up to the length of the name.
void ZipWriter::append_common(std::vector<char>& bytes, const Member& member) {
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

void ZipWriter::append_name(std::vector<char>& bytes, const Member& member) {
  bytes.insert(bytes.end(), member.name.begin(), member.name.end());
}

Result<void> ZipWriter::put(std::span<const char> bytes) {
  at_ += bytes.size();
  return file_.write(bytes);
}

}  // namespace foldproof::io
