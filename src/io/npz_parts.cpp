#include "io/npz_parts.h"

#include <unordered_map>

#include "base/try.h"
#include "io/bytes.h"

namespace foldproof::io {
namespace {

constexpr std::string_view kEnding = ".npy";

void append_utf8(std::string& text, std::uint32_t c) {
  if (c > 0x10ffff || (c >= 0xd800 && c < 0xe000)) c = 0xfffd;
  const auto add = [&](std::uint32_t byte) { text += static_cast<char>(byte); };
  if (c < 0x80) return add(c);
  if (c < 0x800) {
    add(0xc0 | c >> 6);
  } else {
    if (c < 0x10000) {
      add(0xe0 | c >> 12);
    } else {
      add(0xf0 | c >> 18);
      add(0x80 | (c >> 12 & 0x3f));
    }
    add(0x80 | (c >> 6 & 0x3f));
  }
  add(0x80 | (c & 0x3f));
}

/// The text of an element, which zeros pad at its end: of bytes, or of 32-bit characters.
std::string text_of(std::string_view bytes, const NpyHeader& header) {
  std::string text;
  if (header.kind == 'S') {
    text = bytes;
  } else {
    for (std::size_t i = 0; i < bytes.size(); i += 4)
      append_utf8(text, load<std::uint32_t>(bytes.data() + i, header.order));
  }
  while (!text.empty() && text.back() == '\0') text.pop_back();
  return text;
}

/// Calls `use` with the bytes of each element, in order; memory holds a block of them.
Result<void> for_each_element(NpyArray& array, const auto& use) {
  const std::size_t item = array.header().item_bytes;
  const std::uint64_t per_block = std::max<std::uint64_t>(1, (std::uint64_t{1} << 20) / item);
  std::vector<char> block;
  for (std::uint64_t done = 0; done < array.elements();) {
    const std::uint64_t count = std::min(per_block, array.elements() - done);
    block.resize(count * item);
    FOLDPROOF_TRY(array.read_at(done * item, block));
    for (std::size_t i = 0; i < count; ++i) use(std::string_view(block.data() + i * item, item));
    done += count;
  }
  return {};
}

Result<ObjectParts> parts_from(NpyArray& array, std::string_view kind) {
  const NpyHeader& header = array.header();
  if (array.is_integer()) {
    std::vector<std::int64_t> numbers;
    numbers.reserve(array.elements());
    FOLDPROOF_TRY(for_each_element(
        array, [&](std::string_view bytes) { numbers.push_back(load_integer(bytes.data(), header)); }));
    return parts_by_number(kind, numbers);
  }
  std::vector<std::string> names;
  std::vector<Index> of_triangle;
  std::unordered_map<std::string, Index> known;  // by the element's bytes
  of_triangle.reserve(array.elements());
  FOLDPROOF_TRY(for_each_element(array, [&](std::string_view bytes) {
    const auto [at, is_new] = known.try_emplace(std::string(bytes), static_cast<Index>(names.size()));
    if (is_new) names.push_back(text_of(bytes, header));
    of_triangle.push_back(at->second);
  }));
  return parts_by_name(names, of_triangle);
}

bool is_per_triangle(const NpyHeader& header, std::size_t triangles) {
  return header.shape.size() == 1 && header.shape[0] == triangles &&
         std::string_view("iuUS").find(header.kind) != std::string_view::npos;
}

}  // namespace

Result<ObjectParts> npz_parts(zip_t* archive, const std::string& path, std::uint64_t file_size,
                              std::size_t triangles) {
  const zip_int64_t members = zip_get_num_entries(archive, 0);
  for (zip_int64_t i = 0; i < members; ++i) {
    const char* member = zip_get_name(archive, static_cast<zip_uint64_t>(i), 0);
    std::string name = member ? member : "";
    if (!name.ends_with(kEnding)) continue;
    name.resize(name.size() - kEnding.size());
    const std::string_view kind = part_kind(name);
    NpzArray array;
    if (kind.empty() || !array.open(archive, path, file_size, name, "") ||
        !is_per_triangle(array.header(), triangles))
      continue;
    return parts_from(array, kind);
  }
  return ObjectParts();
}

}  // namespace foldproof::io
