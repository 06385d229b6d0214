/// What the readers' fuzz targets share: any bytes as a file, opened as a user would.
#pragma once

#include <unistd.h>

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "foldproof/io.h"

namespace foldproof::fuzz {

/// A file in memory, removed at the end of the program.
class ScratchFile {
 public:
  explicit ScratchFile(const std::string& extension)
      : path_("/dev/shm/foldproof-fuzz-" + std::to_string(::getpid()) + extension) {}
  ScratchFile(const ScratchFile&) = delete;
  ScratchFile& operator=(const ScratchFile&) = delete;
  ~ScratchFile() { ::unlink(path_.c_str()); }

  const std::string& path() const { return path_; }
  void write(const char* bytes, std::size_t size) const {
    std::ofstream(path_, std::ios::binary).write(bytes, static_cast<std::streamsize>(size));
  }

 private:
  std::string path_;
};

/// Opens what the arguments name and reads the first and the last frame. Bad files are errors with a place
/// and a remedy; good ones have finite coordinates. Anything else stops the program.
inline void open_and_read(const std::vector<std::string>& arguments, bool weld) {
  const auto check = [](const Result<void>& result) {
    if (!result &&
        (result.error().where.empty() || result.error().problem.empty() || result.error().remedy.empty())) {
      std::abort();
    }
    return result.has_value();
  };
  auto motions = open_motions(arguments, {.weld = weld ? Weld::Always : Weld::Never});
  if (!motions) {
    check(tl::unexpected(motions.error()));
    return;
  }
  Motion& motion = *motions->front();
  const ObjectParts& parts = motion.info().parts;
  if (!parts.names.empty() && parts.of_triangle.size() != motion.topology().triangles().size()) std::abort();
  for (const Index part : parts.of_triangle) {
    if (part >= parts.names.size()) std::abort();
  }
  std::vector<double> positions(std::size_t{3} * motion.topology().vertex_count());
  for (const Index k : {Index{0}, motion.frame_count() - 1}) {
    if (!check(motion.read_frame(k, positions))) continue;
    for (const double x : positions) {
      if (!std::isfinite(x)) std::abort();
    }
  }
}

/// The bytes as one file with this extension.
inline int read_as(const char* extension, const std::uint8_t* data, std::size_t size) {
  static const ScratchFile file(extension);
  file.write(reinterpret_cast<const char*>(data), size);
  open_and_read({file.path()}, size % 2 == 1);
  return 0;
}

/// The bytes as the point cache of a mesh of three vertices.
inline int read_as_cache(const char* extension, const std::uint8_t* data, std::size_t size) {
  static const ScratchFile file(extension);
  static const ScratchFile mesh(".obj");
  static const std::string text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  if (!std::filesystem::exists(mesh.path())) mesh.write(text.data(), text.size());
  file.write(reinterpret_cast<const char*>(data), size);
  open_and_read({mesh.path(), file.path()}, size % 2 == 1);
  return 0;
}

/// The bytes as a .npy file, together with one of the faces of a triangle.
inline int read_as_array(const std::uint8_t* data, std::size_t size) {
  static const ScratchFile file(".npy");
  static const ScratchFile faces("-faces.npy");
  static const std::string array = std::string("\x93NUMPY\1\0\x3c\0", 10) +
                                   "{'descr': '|u1', 'fortran_order': False, 'shape': (1, 3), }\n" +
                                   std::string("\0\1\2", 3);
  if (!std::filesystem::exists(faces.path())) faces.write(array.data(), array.size());
  file.write(reinterpret_cast<const char*>(data), size);
  open_and_read({file.path(), faces.path()}, size % 2 == 1);
  return 0;
}

}  // namespace foldproof::fuzz
