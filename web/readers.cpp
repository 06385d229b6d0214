// Readers of formats whose libraries are not part of the WebAssembly build.
#include <filesystem>

#include "base/try.h"
#include "io/array_motion.h"

namespace foldproof::io {
namespace {

tl::unexpected<Error> not_read(const std::string& path) {
  return fail(ErrorCode::UnsupportedFormat, path, "is not read in the browser",
              "convert it, or give it to the program");
}

}  // namespace

Result<MeshData> parse_vtp(const std::string& path, std::string_view) { return not_read(path); }
Result<MeshData> parse_vtu(const std::string& path, std::string_view) { return not_read(path); }
Result<std::unique_ptr<Motion>> open_pvd(const std::string& path, const ReadProgress&) {
  return not_read(path);
}

// The page has unpacked the archive into a directory beside it.
Result<std::unique_ptr<Motion>> open_npz(const std::string& path, const ReadOptions& options,
                                         const ReadProgress&) {
  const std::string directory = path + ".arrays";
  std::vector<std::string> members;
  std::error_code ignored;  // without the directory, the arrays are reported missing
  for (const auto& member : std::filesystem::directory_iterator(directory, ignored))
    members.push_back(member.path().filename().string());
  const ArrayNames names = find_arrays(members);
  const auto open = [&](const std::string& name) -> Result<std::unique_ptr<NpyFile>> {
    auto array = std::make_unique<NpyFile>();
    FOLDPROOF_TRY(array->open(directory + "/" + name + ".npy"));
    return array;
  };
  const auto faces = FOLDPROOF_TRY(open(FOLDPROOF_TRY(choose_faces(path, names))));
  auto vertices = FOLDPROOF_TRY(open_vertices(path, names, open));
  auto motion = std::make_unique<ArrayMotion>(path, std::move(vertices), nullptr);
  FOLDPROOF_TRY(motion->open(*faces));
  return with_merged(std::move(motion), members, options, open);
}

}  // namespace foldproof::io
