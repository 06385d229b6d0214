/// Builds small NumPy arrays and archives for tests.
#pragma once

#include <zip.h>

#include "io/support.h"

namespace foldproof::testing {

inline std::string npy(const std::string& type, const std::string& shape, const std::string& data,
                       int version = 1) {
  std::string text = "{'descr': '" + type + "', 'fortran_order': False, 'shape': (" + shape + "), }\n";
  const auto size = static_cast<std::uint32_t>(text.size());
  return std::string("\x93NUMPY", 6) + static_cast<char>(version) + '\0' +
         (version == 1 ? bytes_of(static_cast<std::uint16_t>(size)) : bytes_of(size)) + text + data;
}

template <class T>
std::string array(const std::vector<T>& values, std::endian order = std::endian::little) {
  std::string bytes;
  for (const T x : values) bytes += bytes_of(x, order);
  return bytes;
}

/// Writes members, name and bytes, into a new archive; returns its path.
inline std::string write_archive(const std::string& path,
                                 const std::vector<std::pair<std::string, std::string>>& members,
                                 bool packed = false) {
  std::filesystem::remove(path);
  zip_t* archive = zip_open(path.c_str(), ZIP_CREATE, nullptr);
  for (const auto& [name, data] : members) {
    zip_source_t* source = zip_source_buffer(archive, data.data(), data.size(), 0);
    const auto index = zip_file_add(archive, name.c_str(), source, 0);
    zip_set_file_compression(archive, static_cast<zip_uint64_t>(index),
                             packed ? ZIP_CM_DEFLATE : ZIP_CM_STORE, 0);
  }
  EXPECT_EQ(zip_close(archive), 0);
  return path;
}

}  // namespace foldproof::testing
