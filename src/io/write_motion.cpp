// Writes motions in the format that the extension names.
#include <filesystem>

#include "base/try.h"
#include "foldproof/io.h"

namespace foldproof {

Result<void> write_motion(const std::string& path, Motion& motion) {
  const std::string extension = extension_of(path);
  if (extension == ".npz") return write_npz(path, motion);
  if (extension != ".obj" && extension != ".ply") {
    return fail(ErrorCode::UnsupportedFormat, path, "is not a format that is written here",
                "name it .npz, .obj or .ply");
  }
  if (extension == ".obj" && motion.frame_count() > 1) {
    return write_obj_pc2(path, std::filesystem::path(path).replace_extension(".pc2").string(), motion);
  }
  if (motion.frame_count() > 1) {
    return fail(ErrorCode::UnsupportedFormat, path,
                "is PLY, which holds one frame, and there are " + std::to_string(motion.frame_count()),
                "name it .npz or .obj");
  }
  std::vector<double> positions(std::size_t{3} * motion.topology().vertex_count());
  FOLDPROOF_TRY(motion.read_frame(0, positions));
  return extension == ".obj" ? write_obj(path, motion.topology(), positions)
                             : write_ply(path, motion.topology(), positions, {});
}

}  // namespace foldproof
