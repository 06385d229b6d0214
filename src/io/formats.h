/// The file formats that are read, in one table.
#pragma once

#include "io/readers.h"

namespace foldproof::io {

/// A mesh is a frame or a single pose; a point cache moves the mesh that is named before it; an animation
/// holds both.
enum class FileKind : std::uint8_t { Mesh, PointCache, Animation };

struct FileFormat {
  const char* extension;  ///< Lower case, with its dot.
  FileKind kind;
  // The reader of its kind; the others are null.
  Result<MeshData> (*parse_mesh)(const std::string& path, std::string_view bytes) = nullptr;
  Result<std::unique_ptr<Motion>> (*open_cache)(const std::string& mesh, const std::string& cache) = nullptr;
  Result<std::unique_ptr<Motion>> (*open_animation)(const std::string& path,
                                                    const ReadOptions& options) = nullptr;
};

/// By a path's extension, in any case; null for what is not read.
const FileFormat* format_of(const std::string& path);
bool is_kind(const std::string& path, FileKind kind);

}  // namespace foldproof::io
