#include "text.h"

#include <windows.h>

#include <algorithm>
#include <array>
#include <utility>

namespace foldproof::system {

std::wstring wide(const std::string& text) {
  const int size = static_cast<int>(text.size());
  std::wstring result(text.size(), L'\0');  // UTF-16 never has more units than UTF-8
  result.resize(
      static_cast<std::size_t>(::MultiByteToWideChar(CP_UTF8, 0, text.data(), size, result.data(), size)));
  return result;
}

std::string narrow(const wchar_t* text) {
  const int size = ::WideCharToMultiByte(CP_UTF8, 0, text, -1, nullptr, 0, nullptr, nullptr);
  std::string result(static_cast<std::size_t>(std::max(1, size)), '\0');
  ::WideCharToMultiByte(CP_UTF8, 0, text, -1, result.data(), size, nullptr, nullptr);
  result.pop_back();  // the final NUL
  return result;
}

std::error_code windows_error(unsigned long code) {
  using std::errc;
  constexpr std::array<std::pair<DWORD, errc>, 20> kKnown{{
      {ERROR_FILE_NOT_FOUND, errc::no_such_file_or_directory},
      {ERROR_PATH_NOT_FOUND, errc::no_such_file_or_directory},
      {ERROR_INVALID_NAME, errc::no_such_file_or_directory},
      {ERROR_BAD_NETPATH, errc::no_such_file_or_directory},
      {ERROR_DIRECTORY, errc::not_a_directory},
      {ERROR_ACCESS_DENIED, errc::permission_denied},
      {ERROR_WRITE_PROTECT, errc::read_only_file_system},
      {ERROR_SHARING_VIOLATION, errc::device_or_resource_busy},
      {ERROR_LOCK_VIOLATION, errc::device_or_resource_busy},
      {ERROR_FILE_EXISTS, errc::file_exists},
      {ERROR_ALREADY_EXISTS, errc::file_exists},
      {ERROR_DISK_FULL, errc::no_space_on_device},
      {ERROR_HANDLE_DISK_FULL, errc::no_space_on_device},
      {ERROR_BROKEN_PIPE, errc::broken_pipe},
      {ERROR_NO_DATA, errc::broken_pipe},
      {ERROR_FILENAME_EXCED_RANGE, errc::filename_too_long},
      {ERROR_INVALID_HANDLE, errc::bad_file_descriptor},
      {ERROR_TOO_MANY_OPEN_FILES, errc::too_many_files_open},
      {ERROR_NOT_ENOUGH_MEMORY, errc::not_enough_memory},
      {ERROR_DIR_NOT_EMPTY, errc::directory_not_empty},
  }};
  const auto known = std::ranges::find(kKnown, code, &std::pair<DWORD, errc>::first);
  if (known != kKnown.end()) return std::make_error_code(known->second);
  return {static_cast<int>(code), std::system_category()};
}

}  // namespace foldproof::system
