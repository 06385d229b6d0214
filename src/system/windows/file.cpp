#include "system/file.h"

#include <fmt/format.h>
#include <io.h>
#include <windows.h>

#include <algorithm>
#include <array>
#include <atomic>

#include "text.h"

namespace foldproof::system {
namespace {

namespace fs = std::filesystem;

// A file that is open may be renamed and removed all the same.
constexpr DWORD kShareAll = FILE_SHARE_READ | FILE_SHARE_WRITE | FILE_SHARE_DELETE;
constexpr std::uint64_t kEnd = ~std::uint64_t{0};
constexpr std::size_t kBlock = std::size_t{1} << 30;  // counts have 32 bits

std::error_code last_error() { return windows_error(::GetLastError()); }

HANDLE handle_of(std::intptr_t handle) { return reinterpret_cast<HANDLE>(handle); }
HANDLE handle_of_descriptor(int descriptor) { return reinterpret_cast<HANDLE>(::_get_osfhandle(descriptor)); }

std::uint64_t joined(DWORD high, DWORD low) { return std::uint64_t{high} << 32 | low; }

OVERLAPPED at(std::uint64_t offset) {
  OVERLAPPED place{};
  place.Offset = static_cast<DWORD>(offset);
  place.OffsetHigh = static_cast<DWORD>(offset >> 32);
  return place;
}

std::optional<FileStatus> status_of_handle(HANDLE handle) {
  FileStatus status;
  if (::GetFileType(handle) != FILE_TYPE_DISK) return status;
  BY_HANDLE_FILE_INFORMATION info{};
  if (!::GetFileInformationByHandle(handle, &info)) return std::nullopt;
  constexpr std::int64_t k1970 = 116'444'736'000'000'000;  // in units of 100 ns since 1601
  const std::uint64_t time = joined(info.ftLastWriteTime.dwHighDateTime, info.ftLastWriteTime.dwLowDateTime);
  status.kind =
      (info.dwFileAttributes & FILE_ATTRIBUTE_DIRECTORY) != 0 ? FileKind::Directory : FileKind::File;
  status.size = joined(info.nFileSizeHigh, info.nFileSizeLow);
  status.modified = (static_cast<std::int64_t>(time) - k1970) * 100;
  status.id = {info.dwVolumeSerialNumber, joined(info.nFileIndexHigh, info.nFileIndexLow)};
  return status;
}

/// Opens what is there already, also a directory.
HANDLE open_existing(const fs::path& path, DWORD access) {
  return ::CreateFileW(path.c_str(), access, kShareAll, nullptr, OPEN_EXISTING, FILE_FLAG_BACKUP_SEMANTICS,
                       nullptr);
}

std::error_code write_bytes(HANDLE handle, std::uint64_t offset, std::span<const char> bytes) {
  while (!bytes.empty()) {
    OVERLAPPED place = at(offset);
    DWORD count = 0;
    const auto size = static_cast<DWORD>(std::min(bytes.size(), kBlock));
    if (!::WriteFile(handle, bytes.data(), size, &count, &place)) return last_error();
    bytes = bytes.subspan(count);
    if (offset != kEnd) offset += count;
  }
  return {};
}

/// Whether Windows has a device of this name, whatever its extension.
bool is_device(std::string name) {
  name = name.substr(0, name.find('.'));
  name.erase(name.find_last_not_of(' ') + 1);
  std::ranges::transform(name, name.begin(), [](char c) { return c >= 'a' && c <= 'z' ? c - 'a' + 'A' : c; });
  if (name.size() == 4 && (name.starts_with("COM") || name.starts_with("LPT")))
    return name[3] >= '1' && name[3] <= '9';
  constexpr std::array<std::string_view, 6> kDevices{"CON", "PRN", "AUX", "NUL", "CONIN$", "CONOUT$"};
  return std::ranges::find(kDevices, name) != kDevices.end();
}

}  // namespace

std::optional<FileStatus> status_of(const fs::path& path) {
  take_utf8_in_paths();
  const HANDLE handle = open_existing(path, FILE_READ_ATTRIBUTES);
  if (handle == INVALID_HANDLE_VALUE) return std::nullopt;
  const auto status = status_of_handle(handle);
  ::CloseHandle(handle);
  return status;
}

File File::open(const fs::path& path, Mode mode, std::error_code& code) {
  DWORD access = GENERIC_READ, creation = OPEN_EXISTING;
  if (mode == Mode::Create) access = GENERIC_WRITE, creation = CREATE_NEW;
  if (mode == Mode::Write) access = GENERIC_WRITE;
  if (mode == Mode::Append) access = GENERIC_READ | GENERIC_WRITE, creation = OPEN_ALWAYS;
  File file;
  file.handle_ = reinterpret_cast<std::intptr_t>(
      ::CreateFileW(path.c_str(), access, kShareAll, nullptr, creation, FILE_FLAG_BACKUP_SEMANTICS, nullptr));
  code = file ? std::error_code() : last_error();
  return file;
}

File File::duplicate(int descriptor, std::error_code& code) {
  HANDLE handle = INVALID_HANDLE_VALUE;
  const HANDLE process = ::GetCurrentProcess();
  const bool done = ::DuplicateHandle(process, handle_of_descriptor(descriptor), process, &handle, 0, FALSE,
                                      DUPLICATE_SAME_ACCESS) != 0;
  code = done ? std::error_code() : last_error();
  File file;
  if (done) file.handle_ = reinterpret_cast<std::intptr_t>(handle);
  return file;
}

File File::temporary(std::error_code& code) {
  static std::atomic<unsigned> counter{0};
  std::error_code ignored;
  const fs::path directory = fs::temp_directory_path(ignored);
  constexpr int kMostTries = 1000;  // another process of this number may have left some behind
  File file;
  code = std::make_error_code(std::errc::file_exists);
  for (int tries = 0; tries < kMostTries && code == std::errc::file_exists; ++tries) {
    const fs::path path =
        directory / fmt::format("foldproof-{}-{}.tmp", process_number(), counter.fetch_add(1));
    file.handle_ = reinterpret_cast<std::intptr_t>(
        ::CreateFileW(path.c_str(), GENERIC_READ | GENERIC_WRITE, kShareAll, nullptr, CREATE_NEW,
                      FILE_ATTRIBUTE_TEMPORARY | FILE_FLAG_DELETE_ON_CLOSE, nullptr));
    code = file ? std::error_code() : last_error();
  }
  return file;
}

std::size_t File::read_at(std::uint64_t offset, std::span<char> out, std::error_code& code) const {
  code.clear();
  std::size_t done = 0;
  while (done < out.size()) {
    OVERLAPPED place = at(offset + done);
    DWORD count = 0;
    const auto size = static_cast<DWORD>(std::min(out.size() - done, kBlock));
    if (!::ReadFile(handle_of(handle_), out.data() + done, size, &count, &place)) {
      if (::GetLastError() != ERROR_HANDLE_EOF) code = last_error();
      break;
    }
    if (count == 0) break;
    done += count;
  }
  return done;
}

// Whoever writes files here goes on at their ends, also after write_at.
std::error_code File::write(std::span<const char> bytes) {
  return write_bytes(handle_of(handle_), kEnd, bytes);
}

std::error_code File::write_at(std::uint64_t offset, std::span<const char> bytes) {
  return write_bytes(handle_of(handle_), offset, bytes);
}

std::error_code File::truncate(std::uint64_t size) {
  FILE_END_OF_FILE_INFO end{};
  end.EndOfFile.QuadPart = static_cast<LONGLONG>(size);
  return ::SetFileInformationByHandle(handle_of(handle_), FileEndOfFileInfo, &end, sizeof end)
             ? std::error_code()
             : last_error();
}

std::optional<FileStatus> File::status() const { return status_of_handle(handle_of(handle_)); }

bool File::lock() {
  // What is locked cannot be read by others: a byte that no file has.
  OVERLAPPED place = at(std::uint64_t{1} << 62);
  return ::LockFileEx(handle_of(handle_), LOCKFILE_EXCLUSIVE_LOCK | LOCKFILE_FAIL_IMMEDIATELY, 0, 1, 0,
                      &place) != 0 ||
         ::GetLastError() != ERROR_LOCK_VIOLATION;
}

std::error_code File::close() {
  const std::intptr_t handle = std::exchange(handle_, kNone);
  if (handle == kNone || ::CloseHandle(handle_of(handle))) return {};
  return last_error();
}

std::error_code rename(const fs::path& from, const fs::path& to) {
  return ::MoveFileExW(from.c_str(), to.c_str(), MOVEFILE_REPLACE_EXISTING) ? std::error_code()
                                                                            : last_error();
}

bool can_replace_open_files() { return false; }

bool may_write(const fs::path& path) {
  std::error_code ignored;
  const HANDLE handle = open_existing(path, fs::is_directory(path, ignored) ? FILE_ADD_FILE : GENERIC_WRITE);
  if (handle == INVALID_HANDLE_VALUE) return false;
  ::CloseHandle(handle);
  return true;
}

std::uint64_t process_number() { return ::GetCurrentProcessId(); }

int descriptor_named(const fs::path&) { return -1; }

bool is_open_on(int descriptor, const fs::path& path) {
  const auto open = status_of_handle(handle_of_descriptor(descriptor)), file = status_of(path);
  return open && file && file->kind == FileKind::File && open->kind == FileKind::File && open->id == file->id;
}

std::string problem_of_name(const fs::path& path) {
  for (const fs::path& part : path.relative_path()) {
    const std::string name = part.string();
    if (name.empty() || name == "." || name == "..") continue;
    if (is_device(name)) return fmt::format("Windows keeps the name '{}' for a device", name);
    if (name.ends_with('.') || name.ends_with(' '))
      return fmt::format("Windows takes no name that ends in a point or a space ('{}')", name);
    for (const char c : name) {
      if (static_cast<unsigned char>(c) < 0x20) return "Windows takes no control characters in a name";
      if (std::string_view("<>:\"|?*").find(c) != std::string_view::npos)
        return fmt::format("Windows takes no {} in a name ('{}')", c, name);
    }
  }
  return "";
}

std::string_view separators() { return "/\\"; }

}  // namespace foldproof::system
