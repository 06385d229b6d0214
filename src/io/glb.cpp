#include "io/glb.h"

#include <limits>

#include "base/try.h"

namespace foldproof::io {
namespace {

using Word = std::uint32_t;
constexpr std::size_t kGlbHeader = 12, kChunkGlbHeader = 8;

std::string word(std::size_t value) {
  std::string bytes(sizeof(Word), '\0');
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<char>(value >> 8 * i & 0xff);
  return bytes;
}

void pad(std::string& chunk, char filler) { chunk.resize((chunk.size() + 3) / 4 * 4, filler); }

}  // namespace

Result<void> write_glb(const std::string& path, std::string json, std::string bytes) {
  pad(json, ' ');
  pad(bytes, '\0');
  const std::size_t length = kGlbHeader + 2 * kChunkGlbHeader + json.size() + bytes.size();
  if (length > std::numeric_limits<Word>::max())
    return fail(ErrorCode::LimitExceeded, path, "would have more than 4 GiB, which GLB cannot",
                "select fewer frames (--frames)");
  auto file = FOLDPROOF_TRY(FileWriter::open(path));
  FOLDPROOF_TRY(file.write("glTF" + word(2) + word(length) + word(json.size()) + "JSON" + json +
                           word(bytes.size()) + std::string("BIN\0", 4)));
  FOLDPROOF_TRY(file.write(bytes));
  return file.commit();
}

}  // namespace foldproof::io
