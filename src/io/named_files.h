/// Which files the names of inputs and outputs stand for.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "system/file.h"

namespace foldproof::io {

/// The directory that contains a path's file.
std::filesystem::path directory_of(const std::filesystem::path& path);

/// Where writing to a path goes.
struct WriteTarget {
  std::filesystem::path file;  ///< Links are followed, also those to files that do not exist yet.
  int descriptor = -1;         ///< What is open already: a path like /dev/stdout, or the file behind 1 or 2.
};
WriteTarget write_target(const std::string& path);

/// Whether a path is that of standard output: "-", or a name of descriptor 1 or of its file.
bool is_standard_output(const std::string& path);

/// The same text for all spellings of a path, whether or not the file exists.
std::string canonical(const std::string& path);

using system::FileId;

/// None: there is no file or directory that writing could overwrite.
std::optional<FileId> file_id(const std::filesystem::path& path);

/// All files that an argument of open_motions refers to, whether they exist or not: also the buffers of a
/// glTF, the members of a collection, a directory or a glob. `recursive`: what is anywhere below a directory.
std::vector<std::filesystem::path> files_of(const std::string& name, bool recursive = false);

/// Whether an argument of open_motions will have a file among its frames, once there is one of this name:
/// because it is a directory, a glob or a numbered name.
bool will_read(const std::string& name, const std::string& file);

}  // namespace foldproof::io
