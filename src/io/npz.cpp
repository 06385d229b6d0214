// NumPy archives as motions.
#include <fmt/format.h>

#include <algorithm>

#include "base/try.h"
#include "io/array_motion.h"
#include "io/npz_array.h"
#include "io/npz_parts.h"
#include "io/readers.h"

namespace foldproof::io {
namespace {

std::vector<std::string> members_of(zip_t* archive) {
  std::vector<std::string> members;
  for (zip_int64_t i = 0; i < zip_get_num_entries(archive, 0); ++i) {
    if (const char* member = zip_get_name(archive, static_cast<zip_uint64_t>(i), 0))
      members.emplace_back(member);
  }
  return members;
}

/// Some of an archive's members, for a message.
std::string list(std::span<const std::string> members) {
  constexpr std::size_t kMost = 8;
  std::vector<std::string> names;
  for (const std::string& member : members) {
    const bool plain = std::ranges::none_of(member, [](unsigned char c) { return c < ' '; });
    if (plain && names.size() < kMost) names.push_back(member);
  }
  if (names.empty()) return "none";
  return fmt::format("{}{}", fmt::join(names, ", "), members.size() > names.size() ? " and others" : "");
}

}  // namespace

Result<std::unique_ptr<Motion>> open_npz(const std::string& path, const ReadOptions& options,
                                         const ReadProgress& progress) {
  std::uint64_t bytes = 0;
  auto archive = FOLDPROOF_TRY(open_archive(path, bytes));
  zip_t* zip = archive.get();
  const std::vector<std::string> members = members_of(zip);
  const ArrayNames names = find_arrays(members);
  const std::string remedy =
      fmt::format("save arrays named 'faces' and 'vertices'; its arrays are {}", list(members));
  NpzArray faces;
  FOLDPROOF_TRY(faces.open(zip, path, bytes, FOLDPROOF_TRY(choose_faces(path, names)), remedy));
  const auto open = [&](const std::string& name) -> Result<std::unique_ptr<NpzArray>> {
    auto array = std::make_unique<NpzArray>();
    FOLDPROOF_TRY(array->open(zip, path, bytes, name, remedy));
    return array;
  };
  auto vertices = FOLDPROOF_TRY(open_vertices(path, names, open));
  NpzArray& frames = *vertices;
  auto motion = std::make_unique<ArrayMotion>(path, std::move(vertices), std::move(archive));
  FOLDPROOF_TRY(motion->open(faces));
  motion->set_parts(FOLDPROOF_TRY(npz_parts(zip, path, bytes, motion->topology().triangles().size())));
  FOLDPROOF_TRY(frames.unpack(progress));
  return with_merged(std::move(motion), members, options, open);
}

}  // namespace foldproof::io
