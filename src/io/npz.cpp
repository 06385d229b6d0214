// NumPy archives as motions.
#include <fmt/format.h>

#include "base/try.h"
#include "io/array_motion.h"
#include "io/npz_array.h"
#include "io/npz_parts.h"
#include "io/readers.h"

namespace foldproof::io {
namespace {

constexpr const char* kNameArrays = "save arrays named 'faces' and 'vertices'";

std::vector<std::string> members_of(zip_t* archive) {
  std::vector<std::string> members;
  for (zip_int64_t i = 0; i < zip_get_num_entries(archive, 0); ++i) {
    if (const char* member = zip_get_name(archive, static_cast<zip_uint64_t>(i), 0))
      members.emplace_back(member);
  }
  return members;
}

}  // namespace

Result<std::unique_ptr<Motion>> open_npz(const std::string& path, const ReadProgress& progress) {
  std::uint64_t bytes = 0;
  auto archive = FOLDPROOF_TRY(open_archive(path, bytes));
  zip_t* zip = archive.get();
  NpzArray faces;
  auto vertices = std::make_unique<NpzArray>();
  const ArrayNames names = find_arrays(members_of(zip));
  FOLDPROOF_TRY(faces.open(zip, path, bytes, names.faces, kNameArrays));
  FOLDPROOF_TRY(vertices->open(zip, path, bytes, names.vertices, kNameArrays));
  NpzArray& frames = *vertices;
  auto motion = std::make_unique<ArrayMotion>(path, std::move(vertices), std::move(archive));
  FOLDPROOF_TRY(motion->open(faces));
  motion->set_parts(FOLDPROOF_TRY(npz_parts(zip, path, bytes, motion->topology().triangles().size())));
  FOLDPROOF_TRY(frames.unpack(progress));
  return motion;
}

}  // namespace foldproof::io
