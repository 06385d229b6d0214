/// The table of file formats that can be read.
#pragma once

#include "io/readers.h"

namespace foldproof::io {

/// A mesh file is one frame; a point cache holds the frames of the mesh file named before it; an animation
/// holds mesh and frames; of two arrays, one holds the faces and the other the frames.
enum class FileKind : std::uint8_t { Mesh, PointCache, Animation, Array };

struct FileFormat {
  const char* extension;  ///< Lower case, with its dot.
  FileKind kind;
  // Only the reader for `kind` is set; none for arrays.
  Result<MeshData> (*parse_mesh)(const std::string& path, std::string_view bytes) = nullptr;
  Result<std::unique_ptr<Motion>> (*open_cache)(const std::string& mesh, const std::string& cache,
                                                const ReadProgress& progress) = nullptr;
  Result<std::unique_ptr<Motion>> (*open_animation)(const std::string& path, const ReadOptions& options,
                                                    const ReadProgress& progress) = nullptr;
};

/// ".npz, .csv or .ply", for messages; at least one.
std::string any_of(std::span<const std::string> extensions);
/// Looks up a path's extension, in any case; null when the format cannot be read.
const FileFormat* format_of(const std::string& path);
/// The extensions of a kind, for messages: ".pc2 or .mdd".
std::string extensions_of(FileKind kind);
bool is_kind(const std::string& path, FileKind kind);

}  // namespace foldproof::io
