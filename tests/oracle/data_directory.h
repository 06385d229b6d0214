/// Where the real data is.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <optional>

namespace foldproof::oracle {

/// The directory named by FOLDPROOF_DATA, else `../shared/data` beside the source tree; nothing when it is
/// absent.
inline std::optional<std::filesystem::path> data_directory() {
  const char* named = std::getenv("FOLDPROOF_DATA");
  const std::filesystem::path path = named ? named : FOLDPROOF_SOURCE_DIR "/../shared/data";
  if (!std::filesystem::is_directory(path)) return std::nullopt;
  return path;
}

/// For GTEST_SKIP when data_directory() is empty.
inline constexpr const char* kNoData =
    "The real motions are not here. Set FOLDPROOF_DATA to the directory that holds them to run this test.";

}  // namespace foldproof::oracle
