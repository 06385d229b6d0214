// Writes motions in the format that the extension names.
#include <filesystem>

#include "base/try.h"
#include "foldproof/io.h"
#include "io/numbered.h"

namespace foldproof {
namespace {

Result<void> write_frame(const std::string& path, Motion& motion, Index k) {
  std::vector<double> positions(std::size_t{3} * motion.topology().vertex_count());
  FOLDPROOF_TRY(motion.read_frame(k, positions));
  return extension_of(path) == ".obj" ? write_obj(path, motion.topology(), positions)
                                      : write_ply(path, motion.topology(), positions, {});
}

// A file per frame. An error takes back those that were written.
Result<void> write_frames(const io::NumberPattern& pattern, Motion& motion) {
  for (Index k = 0; k < motion.frame_count(); ++k) {
    auto done = write_frame(pattern.name(k), motion, k);
    if (done) continue;
    std::error_code ignored;
    for (Index written = 0; written < k; ++written) std::filesystem::remove(pattern.name(written), ignored);
    return done;
  }
  return {};
}

}  // namespace

Result<void> write_motion(const std::string& path, Motion& motion) {
  const std::string extension = extension_of(path);
  if (extension == ".npz") return write_npz(path, motion);
  if (extension != ".obj" && extension != ".ply") {
    return fail(ErrorCode::UnsupportedFormat, path, "is not a format that is written here",
                "name it .npz, .obj or .ply");
  }
  if (const auto pattern = io::number_pattern(path)) return write_frames(*pattern, motion);
  if (extension == ".obj" && motion.frame_count() > 1) {
    return write_obj_pc2(path, std::filesystem::path(path).replace_extension(".pc2").generic_string(),
                         motion);
  }
  if (motion.frame_count() > 1) {
    return fail(ErrorCode::UnsupportedFormat, path,
                "is PLY, which holds one frame, and there are " + std::to_string(motion.frame_count()),
                "name it .npz or .obj, or put %04d into the name for a file per frame");
  }
  return write_frame(path, motion, 0);
}

}  // namespace foldproof
