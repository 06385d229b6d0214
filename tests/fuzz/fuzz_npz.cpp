// An archive as it is when the bytes start like one. Otherwise the bytes are two arrays, packed into a good
// archive first: checksums would keep nearly every change from reaching the arrays' own headers.
#include <zip.h>

#include "file_target.h"

namespace {

/// Two bytes tell where the first array ends, and in the highest bit whether they are to be deflated.
void write_archive(const std::string& path, const std::uint8_t* data, std::size_t size) {
  const unsigned head = data[0] + 256u * data[1];
  data += 2;
  size -= 2;
  const std::size_t cut = std::min<std::size_t>(head & 0x7fff, size);
  zip_t* archive = zip_open(path.c_str(), ZIP_CREATE | ZIP_TRUNCATE, nullptr);
  if (archive == nullptr) std::abort();
  const zip_int32_t method = (head & 0x8000) != 0 ? ZIP_CM_DEFLATE : ZIP_CM_STORE;
  const auto add = [&](const char* name, const std::uint8_t* bytes, std::size_t count) {
    const zip_int64_t index = zip_file_add(archive, name, zip_source_buffer(archive, bytes, count, 0), 0);
    if (index < 0 || zip_set_file_compression(archive, static_cast<zip_uint64_t>(index), method, 0) != 0)
      std::abort();
  };
  add("faces.npy", data, cut);
  add("vertices.npy", data + cut, size - cut);
  if (zip_close(archive) != 0) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 2 || (data[0] == 'P' && data[1] == 'K')) return foldproof::fuzz::read_as(".npz", data, size);
  static const foldproof::fuzz::ScratchFile file("-made.npz");
  write_archive(file.path(), data, size);
  foldproof::fuzz::open_and_read({file.path()}, false);
  return 0;
}
